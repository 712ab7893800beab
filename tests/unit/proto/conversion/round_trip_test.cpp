#include <cstring>

#include <gtest/gtest.h>

#include "conversion/codec.hpp"
#include "conversion/limits.hpp"
#include "copepod/v1/envelope.pb.h"
#include "samples.hpp"

namespace copepod::conversion {
namespace {

using session::Header;
using session::MessageKind;

const Header kHeader{2, 0, 0x0123456789abcdef, 99, 5, 2, 7};

/// Equality of bits: distinguishes signed zeros.
template <class Matrix>
void expect_same_bits(const Matrix& a, const Matrix& b) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  if (a.size() == 0) return;
  EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())), 0);
}

class RoundTrip : public testing::Test {
 protected:
  template <class... Body>
  MessageKind send(const Body&... body) {
    return decoder.parse(encoder.encode(kHeader, body...));
  }
  Encoder encoder;
  Decoder decoder;
};

TEST(MessageKinds, AreTheFieldsOfTheEnvelope) {
  const auto* bodies = v1::Envelope::descriptor()->FindOneofByName("body");
  ASSERT_EQ(session::kMessageNames.size(), static_cast<std::size_t>(bodies->field_count()) + 1);  // none
  for (int i = 0; i < bodies->field_count(); ++i) {
    EXPECT_EQ(name_of(static_cast<MessageKind>(bodies->field(i)->number())), bodies->field(i)->message_type()->name());
  }
}

TEST_F(RoundTrip, KeepsEveryHeaderField) {
  EXPECT_EQ(send(MessageKind::summarise), MessageKind::summarise);
  EXPECT_EQ(decoder.header(), kHeader);
}

TEST_F(RoundTrip, ChangesNothingButTheAttemptWhenAMessageIsSentAgain) {
  const Kinematics sent = sample_kinematics(2);
  ASSERT_EQ(send(sent), MessageKind::kinematics);
  ASSERT_EQ(decoder.parse(encoder.encode_again(7)), MessageKind::kinematics);
  Header expected = kHeader;
  expected.step = sent.step;
  expected.attempt = 7;
  EXPECT_EQ(decoder.header(), expected);
  Kinematics received;
  decoder.read(received, 2);
  expect_same_bits(received.position_m, sent.position_m);
}

TEST_F(RoundTrip, KeepsKinematicsBitForBit) {
  for (const Eigen::Index bodies : {0, 1, 3, 2000}) {
    const Kinematics sent = sample_kinematics(bodies);
    ASSERT_EQ(send(sent), MessageKind::kinematics);
    Kinematics received;
    decoder.read(received, bodies);
    EXPECT_EQ(received.step, sent.step);
    expect_same_bits(received.position_m, sent.position_m);
    expect_same_bits(received.orientation_wxyz, sent.orientation_wxyz);
    expect_same_bits(received.velocity_m_per_s, sent.velocity_m_per_s);
    expect_same_bits(received.angular_velocity_rad_per_s, sent.angular_velocity_rad_per_s);
  }
}

TEST_F(RoundTrip, KeepsLoadsBitForBit) {
  Loads sent = sample_loads(17);
  sent.flow = awkward_numbers<Eigen::Matrix<double, 1, Eigen::Dynamic>>(5, 8).transpose();
  ASSERT_EQ(send(sent), MessageKind::loads);
  Loads received;
  decoder.read(received, 17, 5);
  expect_same_bits(received.flow, sent.flow);
  EXPECT_THROW(decoder.read(received, 17, 4), MalformedMessage);
  EXPECT_THROW(decoder.read(received, 17, 0), MalformedMessage);
  sent.flow[4] = std::numeric_limits<double>::quiet_NaN();
  ASSERT_EQ(send(sent), MessageKind::loads);
  EXPECT_THROW(decoder.read(received, 17, 5), NotFinite);
  decoder.read(received, 17);
  EXPECT_EQ(received.step, sent.step);
  expect_same_bits(received.force_N, sent.force_N);
  expect_same_bits(received.torque_N_m, sent.torque_N_m);
}

TEST_F(RoundTrip, KeepsAppliedLoadsBitForBit) {
  const AppliedLoads sent = sample_applied_loads(5, 4, 3);
  ASSERT_EQ(send(sent), MessageKind::applied_loads);
  AppliedLoads received;
  decoder.read(received, 5, 4, 3);
  EXPECT_EQ(received.hydrodynamic.step, sent.hydrodynamic.step);
  expect_same_bits(received.hydrodynamic.force_N, sent.hydrodynamic.force_N);
  expect_same_bits(received.hydrodynamic.torque_N_m, sent.hydrodynamic.torque_N_m);
  expect_same_bits(received.actuation, sent.actuation);
}

TEST_F(RoundTrip, ForgetsTheLastMessageOfTheSameKind) {
  ASSERT_EQ(send(sample_kinematics(50)), MessageKind::kinematics);
  ASSERT_EQ(send(sample_kinematics(2)), MessageKind::kinematics);
  Kinematics received;
  decoder.read(received, 2);
  EXPECT_EQ(received.bodies(), 2);
}

TEST_F(RoundTrip, KeepsTheFluidSetup) {
  const FluidSetup sent = sample_fluid_setup();
  ASSERT_EQ(send(sent), MessageKind::fluid_setup);
  FluidSetup received;
  received.bodies.resize(9);
  decoder.read(received);
  EXPECT_EQ(received.kind, sent.kind);
  EXPECT_EQ(received.step_s, sent.step_s);
  EXPECT_EQ(received.cell_size_m, sent.cell_size_m);
  EXPECT_EQ(received.density_kg_per_m3, sent.density_kg_per_m3);
  EXPECT_EQ(received.kinematic_viscosity_m2_per_s, sent.kinematic_viscosity_m2_per_s);
  EXPECT_EQ(received.domain_cells, sent.domain_cells);
  for (std::size_t face = 0; face < 6; ++face) {
    EXPECT_EQ(received.boundaries[face].kind, sent.boundaries[face].kind);
    EXPECT_EQ(received.boundaries[face].velocity_m_per_s, sent.boundaries[face].velocity_m_per_s);
    EXPECT_EQ(received.boundaries[face].pressure_Pa, sent.boundaries[face].pressure_Pa);
    EXPECT_EQ(received.boundaries[face].profile, sent.boundaries[face].profile);
    EXPECT_EQ(received.boundaries[face].removes_bodies, sent.boundaries[face].removes_bodies);
  }
  EXPECT_EQ(received.no_slip_plane, sent.no_slip_plane);
  EXPECT_EQ(received.symmetry_planes, sent.symmetry_planes);
  EXPECT_EQ(received.body_force_N_per_m3, sent.body_force_N_per_m3);
  EXPECT_EQ(received.initial_flow.kind, sent.initial_flow.kind);
  EXPECT_EQ(received.initial_flow.velocity_m_per_s, sent.initial_flow.velocity_m_per_s);
  EXPECT_EQ(received.initial_flow.speed_m_per_s, sent.initial_flow.speed_m_per_s);
  EXPECT_EQ(received.initial_flow.file, sent.initial_flow.file);
  EXPECT_EQ(received.initial_flow.group, sent.initial_flow.group);
  EXPECT_EQ(received.film_thickness_m, sent.film_thickness_m);
  EXPECT_EQ(received.wall_overlap_m, sent.wall_overlap_m);
  EXPECT_EQ(received.collision, sent.collision);
  EXPECT_EQ(received.moving_boundary, sent.moving_boundary);
  EXPECT_EQ(received.refill, sent.refill);
  EXPECT_EQ(received.precision, sent.precision);
  ASSERT_EQ(received.bodies.size(), 2U);
  EXPECT_EQ(received.bodies[1].kind, ShapeKind::capsule);
  EXPECT_EQ(received.bodies[1].radius_m, 4e-6);
  EXPECT_EQ(received.bodies[1].length_m, 8e-6);
  EXPECT_EQ(received.jointed, sent.jointed);
  EXPECT_EQ(received.fields.directory, sent.fields.directory);
  EXPECT_EQ(received.fields.every_steps, 100);
  EXPECT_EQ(received.fields.mean_start, 5);
  EXPECT_EQ(received.fields.mean_stop, 50);
  EXPECT_EQ(received.fields.mean_every_steps, 2);
}

TEST_F(RoundTrip, KeepsTheBodySetup) {
  const BodySetup sent = sample_body_setup();
  ASSERT_EQ(send(sent), MessageKind::body_setup);
  BodySetup received;
  decoder.read(received);
  EXPECT_EQ(received.step_s, sent.step_s);
  EXPECT_EQ(received.integrator, sent.integrator);
  EXPECT_EQ(received.gravity_m_per_s2, sent.gravity_m_per_s2);
  EXPECT_EQ(received.fluid_density_kg_per_m3, sent.fluid_density_kg_per_m3);
  EXPECT_EQ(received.periodic_length_m, sent.periodic_length_m);
  ASSERT_EQ(received.bodies.size(), 2U);
  const BodySpecification& body = received.bodies[1];
  const BodySpecification& original = sent.bodies[1];
  EXPECT_EQ(body.name, original.name);
  EXPECT_EQ(body.shape.kind, original.shape.kind);
  EXPECT_EQ(body.mass_kg, original.mass_kg);
  EXPECT_EQ(body.motion, original.motion);
  EXPECT_EQ(body.axis, original.axis);
  EXPECT_EQ(body.position_m, original.position_m);
  EXPECT_EQ(body.orientation_wxyz, original.orientation_wxyz);
  EXPECT_EQ(body.velocity_m_per_s, original.velocity_m_per_s);
  EXPECT_EQ(body.angular_velocity_rad_per_s, original.angular_velocity_rad_per_s);
  ASSERT_EQ(received.springs.size(), 1U);
  EXPECT_EQ(received.springs[0].body_A, 0);
  EXPECT_EQ(received.springs[0].body_B, 1);
  EXPECT_EQ(received.springs[0].stiffness_N_per_m, 1.72965);
  EXPECT_EQ(received.springs[0].damping_N_s_per_m, 1.57237e-7);
  EXPECT_EQ(received.springs[0].rest_length_m, 1.6e-5);
  EXPECT_EQ(received.springs[0].anchor_A_m, sent.springs[0].anchor_A_m);
  EXPECT_EQ(received.springs[0].anchor_B_m, sent.springs[0].anchor_B_m);
  ASSERT_EQ(received.walls.size(), 1U);
  EXPECT_EQ(received.walls[0].point_m, sent.walls[0].point_m);
  EXPECT_EQ(received.walls[0].normal, sent.walls[0].normal);
  EXPECT_EQ(received.walls[0].velocity_m_per_s, sent.walls[0].velocity_m_per_s);
  EXPECT_EQ(received.walls[0].friction, 0.25);
  EXPECT_TRUE(received.walls[0].removes_bodies);
  EXPECT_EQ(received.contact.stiffness_N_per_m, sent.contact.stiffness_N_per_m);
  EXPECT_EQ(received.contact.restitution, 0.9);
  EXPECT_EQ(received.contact.friction, 0.3);
  ASSERT_EQ(received.bends.size(), 1U);
  EXPECT_EQ(received.bends[0].body_A, 1);
  EXPECT_EQ(received.bends[0].body_B, 0);
  EXPECT_EQ(received.bends[0].body_C, 1);
  EXPECT_EQ(received.bends[0].stiffness_N_m_per_rad, 2e-16);
  EXPECT_EQ(received.bends[0].rest_angle_rad, 2.5);
  ASSERT_EQ(received.joints.size(), sent.joints.size());
  for (std::size_t i = 0; i < sent.joints.size(); ++i) {
    EXPECT_EQ(received.joints[i].kind, sent.joints[i].kind);
    EXPECT_EQ(received.joints[i].body_A, sent.joints[i].body_A);
    EXPECT_EQ(received.joints[i].body_B, sent.joints[i].body_B);
    EXPECT_EQ(received.joints[i].anchor_A_m, sent.joints[i].anchor_A_m);
    EXPECT_EQ(received.joints[i].anchor_B_m, sent.joints[i].anchor_B_m);
    EXPECT_EQ(received.joints[i].axis, sent.joints[i].axis);
    EXPECT_EQ(received.joints[i].stiffness, sent.joints[i].stiffness);
    EXPECT_EQ(received.joints[i].damping, sent.joints[i].damping);
    EXPECT_EQ(received.joints[i].rest, sent.joints[i].rest);
    EXPECT_EQ(received.joints[i].lowest, sent.joints[i].lowest);
    EXPECT_EQ(received.joints[i].highest, sent.joints[i].highest);
  }
  ASSERT_EQ(received.actuators.size(), sent.actuators.size());
  for (std::size_t i = 0; i < sent.actuators.size(); ++i) {
    EXPECT_EQ(received.actuators[i].control, sent.actuators[i].control);
    EXPECT_EQ(received.actuators[i].joint, sent.actuators[i].joint);
    EXPECT_EQ(received.actuators[i].kind, sent.actuators[i].kind);
    EXPECT_EQ(received.actuators[i].body_A, sent.actuators[i].body_A);
    EXPECT_EQ(received.actuators[i].body_B, sent.actuators[i].body_B);
    EXPECT_EQ(received.actuators[i].direction, sent.actuators[i].direction);
    EXPECT_EQ(received.actuators[i].anchor_A_m, sent.actuators[i].anchor_A_m);
    EXPECT_EQ(received.actuators[i].anchor_B_m, sent.actuators[i].anchor_B_m);
  }
  EXPECT_EQ(received.parameters, sent.parameters);
  EXPECT_EQ(received.model.text, "<mujoco/>");
  EXPECT_EQ(received.model.length_m, 1e-6);
  EXPECT_EQ(received.model.mass_kg, 1e-15);
  EXPECT_EQ(received.model.time_s, 1.0 / 3);
}

TEST_F(RoundTrip, KeepsWhatControllersAreSentAndAnswer) {
  const ControllerSetup setup = sample_controller_setup();
  ASSERT_EQ(send(setup), MessageKind::controller_setup);
  ControllerSetup read;
  decoder.read(read);
  EXPECT_EQ(read.name, setup.name);
  EXPECT_EQ(read.step_s, setup.step_s);
  EXPECT_EQ(read.every_steps, 100);
  EXPECT_EQ(read.bodies, setup.bodies);
  EXPECT_EQ(read.actuators, setup.actuators);
  EXPECT_EQ(read.parameters, setup.parameters);
  EXPECT_EQ(read.trace_directory, setup.trace_directory);

  EXPECT_EQ(read.flow, setup.flow);

  Observation sent = sample_observation(3);
  sent.loads.flow = Eigen::Vector2d(1.0 / 3, -0.0);
  ASSERT_EQ(send(sent), MessageKind::observation);
  Observation received;
  decoder.read(received, 3, 2);
  expect_same_bits(received.loads.flow, sent.loads.flow);
  EXPECT_THROW(decoder.read(received, 3, 1), MalformedMessage);
  EXPECT_EQ(received.kinematics.step, sent.kinematics.step);
  EXPECT_EQ(received.loads.step, sent.kinematics.step - 1);
  expect_same_bits(received.kinematics.position_m, sent.kinematics.position_m);
  expect_same_bits(received.kinematics.orientation_wxyz, sent.kinematics.orientation_wxyz);
  expect_same_bits(received.kinematics.velocity_m_per_s, sent.kinematics.velocity_m_per_s);
  expect_same_bits(received.kinematics.angular_velocity_rad_per_s, sent.kinematics.angular_velocity_rad_per_s);
  expect_same_bits(received.loads.force_N, sent.loads.force_N);
  expect_same_bits(received.loads.torque_N_m, sent.loads.torque_N_m);
  EXPECT_THROW(decoder.read(received, 2, 2), MalformedMessage);

  const std::vector<double> action{1.0 / 3, -0.0};
  ASSERT_EQ(send(action), MessageKind::action);
  EXPECT_EQ(decoder.header().step, kHeader.step);
  std::vector<double> answer(2);
  decoder.read(answer);
  EXPECT_EQ(std::memcmp(answer.data(), action.data(), 2 * sizeof(double)), 0);
  answer.resize(3);
  EXPECT_THROW(decoder.read(answer), MalformedMessage);
  ASSERT_EQ(send(std::vector<double>{NAN}), MessageKind::action);
  answer.resize(1);
  EXPECT_THROW(decoder.read(answer), NotFinite);
}

TEST_F(RoundTrip, KeepsTheHandshake) {
  session::Hello hello{session::Role::body,
                       session::Lane::control,
                       {1, 0, 3},
                       "token",
                       {"solver", "2.1", {"a", "b"}},
                       "node7",
                       4321,
                       16,
                       0xfedcba9876543210,
                       "pilot"};
  ASSERT_EQ(send(hello), MessageKind::hello);
  session::Hello received;
  decoder.read(received);
  EXPECT_EQ(received.role, hello.role);
  EXPECT_EQ(received.lane, hello.lane);
  EXPECT_EQ(received.versions, hello.versions);
  EXPECT_EQ(received.session_token, hello.session_token);
  EXPECT_EQ(received.capabilities.name, "solver");
  EXPECT_EQ(received.capabilities.features, hello.capabilities.features);
  EXPECT_EQ(received.host, "node7");
  EXPECT_EQ(received.pid, 4321);
  EXPECT_EQ(received.ranks, 16U);
  EXPECT_EQ(received.instance, hello.instance);
  EXPECT_EQ(received.name, "pilot");

  ASSERT_EQ(send(session::Welcome{3, 17, 18}), MessageKind::welcome);
  session::Welcome welcome;
  decoder.read(welcome);
  EXPECT_EQ(welcome.minor, 3U);
  EXPECT_EQ(welcome.session_id, 17U);
  EXPECT_EQ(welcome.epoch, 18U);

  ASSERT_EQ(send(session::Refusal{"no"}), MessageKind::refusal);
  session::Refusal refusal;
  decoder.read(refusal);
  EXPECT_EQ(refusal.reason, "no");

  ASSERT_EQ(send(session::Configured{{0, 0.5, 1}}), MessageKind::configured);
  session::Configured configured;
  decoder.read(configured);
  EXPECT_EQ(configured.driving_nodes, (std::vector<double>{0, 0.5, 1}));
}

TEST_F(RoundTrip, KeepsControlMessages) {
  ASSERT_EQ(send(session::Ping{77}), MessageKind::ping);
  session::Ping ping;
  decoder.read(ping);
  EXPECT_EQ(ping.stamp_ns, 77U);

  ASSERT_EQ(send(session::Pong{77, 5, session::Phase::advancing, 8, 9, 10, 11}), MessageKind::pong);
  session::Pong pong;
  decoder.read(pong);
  EXPECT_EQ(pong.stamp_ns, 77U);
  EXPECT_EQ(pong.step, 5);
  EXPECT_EQ(pong.phase, session::Phase::advancing);
  EXPECT_EQ(pong.progress, 8U);
  EXPECT_EQ(pong.received_sequence, 9U);
  EXPECT_EQ(pong.replied_sequence, 10U);
  EXPECT_EQ(pong.awaited_rank, 11);
}

TEST_F(RoundTrip, KeepsWhyNothingWasSaved) {
  session::Saved saved{"Disk full (quota). Free some space."};
  ASSERT_EQ(send(saved), MessageKind::saved);
  session::Saved received;
  decoder.read(received);
  EXPECT_EQ(received.problem, saved.problem);
}

TEST_F(RoundTrip, KeepsFailuresAndAborts) {
  const FailureReport sent{ExitCode::storage_failed, "fluid", "node7", 3, 12, "Disk full (quota). Free some space."};
  FailureReport received;
  ASSERT_EQ(send(sent), MessageKind::failure);
  decoder.read(received);
  EXPECT_EQ(received.code, sent.code);
  EXPECT_EQ(received.component, sent.component);
  EXPECT_EQ(received.host, sent.host);
  EXPECT_EQ(received.rank, sent.rank);
  EXPECT_EQ(received.step, sent.step);
  EXPECT_EQ(received.reason, sent.reason);

  ASSERT_EQ(decoder.parse(encoder.encode_abort(kHeader, sent)), MessageKind::abort);
  received = {};
  decoder.read(received);
  EXPECT_EQ(received.reason, sent.reason);
}

TEST_F(RoundTrip, MakesTextTravelWhateverItsEncoding) {
  const FailureReport latin1{ExitCode::solver_failed, "fluid", "node7", 0, 1, "Str\xF6mung \xC3\xA4 \xE2\x82"};
  ASSERT_EQ(send(latin1), MessageKind::failure);
  FailureReport received;
  decoder.read(received);
  EXPECT_EQ(received.reason, "Str?mung \xC3\xA4 ??");

  ASSERT_EQ(send(session::Saved{"m\xFCnchen: cannot open it"}), MessageKind::saved);
  session::Saved saved;
  decoder.read(saved);
  EXPECT_EQ(saved.problem, "m?nchen: cannot open it");
}

TEST_F(RoundTrip, KeepsSummariesAndPaths) {
  SolverSummary sent{0xffffffffffffffff, 1ULL << 60, 12,  {{"bulk", 1.5}, {"map", 0.25}, {"idle", 3.0}}, {"map"},
                     {"idle"},           -2e-4,      3e-3};
  ASSERT_EQ(send(sent), MessageKind::summary);
  SolverSummary summary;
  summary.seconds["old"] = 1;
  summary.body_phases = {"old"};
  decoder.read(summary);
  EXPECT_EQ(summary.digest, sent.digest);
  EXPECT_EQ(summary.cell_updates, sent.cell_updates);
  EXPECT_EQ(summary.ranks, 12);
  EXPECT_EQ(summary.seconds, sent.seconds);
  EXPECT_EQ(summary.body_phases, sent.body_phases);
  EXPECT_EQ(summary.waiting_phases, sent.waiting_phases);
  EXPECT_EQ(summary.mass_drift, sent.mass_drift);
  EXPECT_EQ(summary.momentum_drift, sent.momentum_drift);

  for (const MessageKind kind : {MessageKind::save, MessageKind::restore}) {
    ASSERT_EQ(send(kind, session::CheckpointPath{"/runs/a/checkpoints/7"}), kind);
    session::CheckpointPath path;
    decoder.read(path);
    EXPECT_EQ(path.path, "/runs/a/checkpoints/7");
  }
}

TEST_F(RoundTrip, TellsMessagesWithoutFieldsApart) {
  for (const MessageKind kind : {MessageKind::kinematics_request, MessageKind::restored, MessageKind::summarise,
                                 MessageKind::finish, MessageKind::finished}) {
    EXPECT_EQ(send(kind), kind);
  }
  EXPECT_THROW(send(MessageKind::loads), std::logic_error);
}

TEST(Text, HasAQuestionMarkForEveryByteThatIsNotUtf8) {
  const std::string ends = "A\x7F\xC2\x80\xDF\xBF\xE0\xA0\x80\xED\x9F\xBF\xEE\x80\x80\xF0\x90\x80\x80\xF4\x8F\xBF\xBF";
  EXPECT_EQ(as_utf8(ends, 100), ends);
  // Overlong ones, halves of surrogate pairs, numbers beyond the last, and what is cut off.
  for (const std::string wrong : {"\x80", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
                                  "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFE", "\xFF", "\xE2\x82", "\xE2\x28\xA1"}) {
    std::string due(wrong.size(), '?');
    if (wrong.find('(') != std::string::npos) due[1] = '(';
    EXPECT_EQ(as_utf8("a" + wrong + "b", 100), "a" + due + "b");
  }
  EXPECT_EQ(as_utf8("a\xC2\x80", 2), "a");
  EXPECT_EQ(as_utf8("a\xFF\xFF", 2), "a?");
}

}  // namespace
}  // namespace copepod::conversion
