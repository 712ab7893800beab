// The threads of the body service change no bit: not of motions, not of saved states, not of errors.

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <utility>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

/// Rows of three bodies along z, joined in one of several ways, free, or restricted in their motion.
class Swarm {
 public:
  Swarm(Integrator integrator, bool contacts) : contacts_(contacts), setup_(setup_of({}, 1e-9, integrator)) {
    setup_.gravity_m_per_s2 = {0, 0, -9.81};
    setup_.fluid_density_kg_per_m3 = 1000.0;
  }

  void add(int island) {
    const int first = static_cast<int>(setup_.bodies.size());
    const Eigen::Vector3d place_m(4e-5 * (island % 20), 4e-5 * static_cast<int>(island / 20), 0.0);
    for (int part = 0; part < 3; ++part) {
      const std::string name = std::to_string(island) + "." + std::to_string(part);
      const Eigen::Vector3d centre_m = place_m + Eigen::Vector3d(0, 1e-6 * part * part, 2e-5 * part);
      BodySpecification body = island % 3 == 1 ? capsule(name, centre_m) : bead(name, centre_m);
      body.orientation_wxyz = Eigen::Vector4d(1, 0.02 * part, 0.01 * (island % 7), 0).normalized();
      body.velocity_m_per_s = {0.1 * std::sin(island), 0.1 * std::cos(3.0 * island), 0.01 * part};
      body.angular_velocity_rad_per_s = {100.0 * std::cos(island), 50.0 * part, 200};
      setup_.bodies.push_back(body);
    }
    if (island % 9 < 5) join_by_springs(first, island % 9 > 2);
    if (island % 9 == 5) join_by_joints(first);
    if (island % 9 == 6) restrict_motions(first);
    if (island % 9 == 7) send(first, {0, 0, 3.99e-6}, 1.0);    // to the next body, 10 nm away
    if (island % 9 == 8) send(first, {0, 0, -3.99e-6}, -1.0);  // to the wall
  }

  [[nodiscard]] const BodySetup& setup() const { return setup_; }

 private:
  void join_by_springs(int first, bool anchored) {
    for (int i = first; i < first + 2; ++i) {
      SpringSpecification spring{i, i + 1, 1.0, 1e-7, 1.9e-5};
      if (anchored) spring.anchor_A_m = {1e-6, 0, 3e-6};
      setup_.springs.push_back(spring);
      setup_.actuators.push_back(pair_force(i, i + 1));
      if (!anchored) continue;
      setup_.actuators.back().anchor_B_m = {0, 1e-6, -3e-6};
      setup_.actuators.push_back(actuator_on(i, ActuatorKind::body_torque, {0, 0, 1}));
    }
    setup_.bends.push_back({first, first + 1, first + 2, 1e-12});
  }

  void join_by_joints(int first) {
    const auto middle_in = [&](int body) -> Eigen::Vector3d {
      const BodySpecification& joined = setup_.bodies[body];
      const Eigen::Vector3d middle_m =
          0.5 * (setup_.bodies[first].position_m + setup_.bodies[first + 1].position_m) - joined.position_m;
      return rotation_matrix(joined.orientation_wxyz).transpose() * middle_m;
    };
    setup_.joints.push_back(
        {JointKind::hinge, first, first + 1, middle_in(first), middle_in(first + 1), {0, 0.6, 0.8}});
    setup_.joints.push_back({JointKind::distance, first + 1, first + 2});
    if (setup_.integrator != Integrator::runge_kutta_4) return;
    ActuatorSpecification motion;
    motion.kind = ActuatorKind::joint_motion;
    motion.body_A = first;
    motion.joint = static_cast<int>(setup_.joints.size()) - 2;
    setup_.actuators.push_back(motion);
  }

  void restrict_motions(int first) {
    setup_.bodies[first].motion = MotionKind::axis;
    setup_.bodies[first].velocity_m_per_s = {0, 0, 0.1};
    setup_.bodies[first].angular_velocity_rad_per_s = {0, 0, 10};
    setup_.bodies[first + 1].motion = MotionKind::prescribed;
    setup_.bodies[first + 2].motion = MotionKind::fixed;
    setup_.bodies[first + 2].velocity_m_per_s.setZero();
    setup_.bodies[first + 2].angular_velocity_rad_per_s.setZero();
  }

  void send(int body, const Eigen::Vector3d& shift_m, double speed_m_per_s) {
    setup_.bodies[body].position_m += shift_m;
    setup_.bodies[body].orientation_wxyz = {1, 0, 0, 0};
    setup_.bodies[body].velocity_m_per_s.z() = contacts_ ? speed_m_per_s : 0.0;
  }

  bool contacts_;
  BodySetup setup_;
};

BodySetup swarm(Integrator integrator, bool contacts, int islands = 400) {
  Swarm swarm(integrator, contacts);
  for (int island = 0; island < islands; ++island) swarm.add(island);
  BodySetup setup = swarm.setup();
  if (contacts) {
    setup.contact = {10.0, 0.8, 0.3};
    setup.walls.push_back({{0, 0, -8e-6}, {0, 0, 1}, {0, 0, 0}, 0.2});
  }
  return setup;
}

/// Loads that differ from body to body and from step to step.
void load(AppliedLoads& applied) {
  const auto step = static_cast<double>(applied.hydrodynamic.step);
  for (Eigen::Index body = 0; body < applied.hydrodynamic.bodies(); ++body) {
    const auto i = static_cast<double>(body);
    applied.hydrodynamic.force_N.col(body) = 1e-9 * Eigen::Vector3d(std::sin(i + step), std::cos(i), std::sin(3 * i));
    applied.hydrodynamic.torque_N_m.col(body) = 1e-15 * Eigen::Vector3d(std::cos(i), std::sin(i - step), 1.0);
  }
  for (Eigen::Index node = 0; node < applied.actuation.cols(); ++node) {
    for (Eigen::Index i = 0; i < applied.actuation.rows(); ++i)
      applied.actuation(i, node) =
          1e-12 * std::sin(0.1 * static_cast<double>(i) + step + 0.5 * static_cast<double>(node));
  }
}

std::uint64_t digest_after(BodySetup setup, int threads, int steps) {
  setup.threads = threads;
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, steps, load, static_cast<Eigen::Index>(setup.actuators.size()));
  EXPECT_EQ(end.step, steps);
  Kinematics asked_for;
  solver.kinematics(asked_for);
  EXPECT_EQ(end.position_m, asked_for.position_m);
  EXPECT_EQ(end.angular_velocity_rad_per_s, asked_for.angular_velocity_rad_per_s);
  return solver.summarise().digest;
}

TEST(Threads, ChangeNoBitOfASwarm) {
  for (const Integrator integrator : {Integrator::runge_kutta_4, Integrator::semi_implicit_euler}) {
    for (const bool contacts : {false, true}) {
      const BodySetup setup = swarm(integrator, contacts);
      const std::uint64_t of_one = digest_after(setup, 1, 20);
      for (const int threads : {2, 3, 7}) EXPECT_EQ(digest_after(setup, threads, 20), of_one) << threads << " threads";
    }
  }
}

TEST(Threads, OfAnotherNumberResumeWithTheSameBits) {
  const auto file = std::filesystem::temp_directory_path() / ("threads_" + std::to_string(::getpid()));
  for (const bool contacts : {false, true}) {
    BodySetup setup = swarm(Integrator::runge_kutta_4, contacts);
    const std::uint64_t undisturbed = digest_after(setup, 1, 20);
    for (const auto& [before, after] : {std::pair(1, 3), std::pair(2, 1), std::pair(3, 2)}) {
      setup.threads = before;
      RigidBodySolver first(setup);
      advance(first, 10, load, static_cast<Eigen::Index>(setup.actuators.size()));
      first.save(file);
      setup.threads = after;
      RigidBodySolver second(setup);
      second.restore(file);
      std::filesystem::remove(file);
      advance(second, 10, load, static_cast<Eigen::Index>(setup.actuators.size()));
      EXPECT_EQ(second.summarise().digest, undisturbed) << before << " threads, then " << after;
    }
  }
}

TEST(Threads, ReportTheFirstBodyThatDiverges) {
  BodySetup setup = swarm(Integrator::runge_kutta_4, false);
  for (const int threads : {1, 2, 7}) {
    setup.threads = threads;
    RigidBodySolver solver(setup);
    const auto two_diverge = [](AppliedLoads& applied) {
      load(applied);
      if (applied.hydrodynamic.step != 3) return;
      applied.hydrodynamic.force_N(1, 1152) = std::nan("");
      applied.hydrodynamic.force_N(0, 693) = std::nan("");
    };
    const std::string reason = reason_of<SolverError>(
        [&] { advance(solver, 5, two_diverge, static_cast<Eigen::Index>(setup.actuators.size())); });
    EXPECT_TRUE(contains(reason, "body '231.0' is not finite")) << threads << " threads";
  }
}

TEST(Threads, ReportTheFirstBodiesThatOverlap) {
  BodySetup setup = swarm(Integrator::semi_implicit_euler, false);
  for (const int body : {1080, 810}) setup.bodies[body].velocity_m_per_s.z() = 2e4;
  for (const int threads : {1, 3}) {
    setup.threads = threads;
    RigidBodySolver solver(setup);
    const std::string reason =
        reason_of<SolverError>([&] { advance(solver, 5, load, static_cast<Eigen::Index>(setup.actuators.size())); });
    EXPECT_TRUE(contains(reason, "bodies '270.0' and '270.1' overlap")) << threads << " threads";
  }
}

TEST(Threads, OfAnImpossibleNumberAreRefused) {
  BodySetup setup = swarm(Integrator::runge_kutta_4, false, 1);
  for (const int threads : {0, -1, 2000}) {
    setup.threads = threads;
    EXPECT_THROW(RigidBodySolver{setup}, CaseError);
  }
}

}  // namespace
}  // namespace copepod::body
