// Follows every key of the case to the component that reads it (docs/how_a_key_travels.md): a new field of
// FluidSetup or BodySetup that is forgotten anywhere on its way fails here.

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include "config/load_case.hpp"
#include "config/sections/sections.hpp"
#include "config/setups.hpp"
#include "config/yaml/document.hpp"
#include "conversion/codec.hpp"
#include "copepod/v1/setup.pb.h"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

/// Overrides of the case every_key.yaml that change one field of a setup, by the field's path in the Protobuf
/// message; entries of lists share one. None: the run sets it, or there is one value only.
using Travels = std::map<std::string, std::vector<std::string>>;

/// Sets the text of a mesh: another tetrahedron than in every_key.yaml.
std::string other_mesh(const std::string& path) {
  return path + R"(.text="v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -2\nf 2 1 3\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")";
}

/// Our Stokes flow has spheres only.
const std::string only_ball =
    "bodies=[{name: ball, radius_m: 2.0e-6, mass_kg: 5.0e-13, position_m: [8.0e-6, 25.0e-6, 20.0e-6]}]";

std::string inflow_with(const std::string& signal) {
  return "fluid.boundaries.z={low: {velocity_m_per_s: [0, 0, 0.1], signal: " + signal + "}, high: outflow}";
}

const char* const removal =
    "fluid.boundaries.z={low: {velocity_m_per_s: [0, 0, 0.1]}, high: {outflow: {bodies: remove}}}";

std::string ones(int count) {
  std::string list = "1";
  for (int i = 1; i < count; ++i) list += ", 1";
  return list;
}

const Travels fluid_travels{
    {"kind", {"fluid.solver=stokes", "obstacles=null", only_ball}},
    {"step_s", {"fluid.relaxation_time=0.7"}},
    {"cell_size_m", {"fluid.symmetry_planes=[]", "fluid.cell_size_m=1.05e-6"}},
    {"density_kg_per_m3", {"fluid.density_kg_per_m3=1300"}},
    {"kinematic_viscosity_m2_per_s", {"fluid.kinematic_viscosity_m2_per_s=7.0e-5"}},
    {"domain_cells", {"fluid.domain_cells=[50, 50, 96]"}},
    {"boundaries.kind", {"fluid.boundaries.x=no_slip"}},
    {"boundaries.velocity_m_per_s", {"fluid.boundaries.y={velocity_m_per_s: [0, 0, 0.4]}"}},
    {"boundaries.pressure_Pa", {"fluid.boundaries.z={low: {pressure_Pa: 2}, high: {pressure_Pa: 1}}"}},
    {"boundaries.parabolic",
     {"fluid.boundaries.z={low: {velocity_m_per_s: [0, 0, 0.1], profile: parabolic}, high: {outflow: {}}}"}},
    {"boundaries.profile",
     {"fluid.boundaries.z={low: {velocity_m_per_s: [0, 0, 0.1], profile: {factors: [" + ones(48 * 50) +
      "]}}, high: outflow}"}},
    {"boundaries.removes_bodies", {removal}},
    {"boundaries.signal.kind", {inflow_with("{kind: constant}")}},
    {"boundaries.signal.amplitude", {inflow_with("{kind: constant, amplitude: 0.7}")}},
    {"boundaries.signal.period_steps", {inflow_with("{kind: sinusoid, period_steps: 90}")}},
    {"boundaries.signal.lag_steps", {inflow_with("{kind: sinusoid, period_steps: 90, lag_deg: 20}")}},
    {"boundaries.signal.rise", {inflow_with("{kind: trapezoid, period_steps: 90}")}},
    {"boundaries.signal.ramp_steps", {inflow_with("{kind: constant, ramp_steps: 7}")}},
    {"boundaries.signal.start_step", {inflow_with("{kind: constant, start_step: 3}")}},
    {"boundaries.signal.stop_step", {inflow_with("{kind: constant, stop_step: 9}")}},
    {"symmetry_planes", {"fluid.symmetry_planes=[]"}},
    {"body_force_N_per_m3", {"fluid.body_force_N_per_m3=[0, 0, 0.5]"}},
    {"initial_flow.kind", {"fluid.initial_flow={kind: rest}"}},
    {"initial_flow.velocity_m_per_s", {"fluid.initial_flow.velocity_m_per_s=[0, 0, 0.3]"}},
    {"initial_flow.speed_m_per_s",
     {"fluid.boundaries.x=periodic", "fluid.boundaries.y=periodic", "fluid.symmetry_planes=[]",
      "fluid.initial_flow={kind: taylor_green, speed_m_per_s: 0.2}"}},
    {"initial_flow.file", {"fluid.initial_flow={kind: file, file: fields.h5}"}},
    {"initial_flow.group", {"fluid.initial_flow={kind: file, file: fields.h5, group: mean}"}},
    {"collision", {"fluid.collision=bgk"}},
    {"moving_boundary", {"fluid.moving_boundary=interpolated"}},
    {"refill", {"fluid.refill=nonequilibrium"}},
    {"precision", {"fluid.precision=double"}},
    {"film_thickness_m", {"lubrication.cut_off_cells=auto"}},
    {"wall_overlap_m", {"fluid.symmetry_planes=[]", "fluid.cell_size_m=1.05e-6"}},
    {"jointed.body_A", {"joints.0.bodies=[swimmer.B1, swimmer.B3]"}},
    {"jointed.body_B", {"joints.0.bodies=[ball, swimmer.B3]"}},
    {"bodies.kind", {"bodies.0.shape=capsule"}},
    {"bodies.radius_m", {"bodies.0.radius_m=2.1e-6"}},
    {"bodies.length_m", {"bodies.0.shape=capsule", "bodies.0.length_m=1.0e-6"}},
    {"bodies.extents_m",
     {"bodies.1.semi_axes_m=[1.0e-6, 2.0e-6, 2.5e-6]", "bodies.2.edges_m=[3.0e-6, 4.0e-6, 5.5e-6]"}},
    {"bodies.mesh",
     {"bodies.1={name: egg, shape: mesh, unit_m: 1.0e-6, mass_kg: 1.0e-13, position_m: [40.0e-6, 18.0e-6, 10.0e-6]}",
      other_mesh("bodies.1")}},
    {"bodies.parts.shape.kind", {"bodies.4.parts.0.shape=capsule"}},
    {"bodies.parts.shape.radius_m", {"bodies.4.parts.0.radius_m=1.1e-6"}},
    {"bodies.parts.shape.length_m", {"bodies.4.parts.0.length_m=5.0e-6"}},
    {"bodies.parts.shape.extents_m", {"bodies.4.parts.1.edges_m=[2.0e-6, 5.0e-6, 2.0e-6]"}},
    {"bodies.parts.shape.mesh", {"bodies.4.parts.0={shape: mesh, unit_m: 1.0e-6}", other_mesh("bodies.4.parts.0")}},
    {"bodies.parts.position_m",
     {"bodies.4.parts.1.position_m=[0, 0, 7.0e-6]", "bodies.2.center_of_mass_m=[1.0e-7, 2.0e-7, 4.0e-7]"}},
    {"bodies.parts.orientation_wxyz", {"bodies.4.parts.1.orientation_wxyz=[0.8, 0, 0, 0.6]"}},
    {"meshes.vertices_m", {"bodies.3.unit_m=2.1e-6"}},
    {"meshes.triangles", {other_mesh("bodies.3")}},
    {"obstacles.name", {"obstacles.0.name=ledge"}},
    {"obstacles.shape.kind",
     {"obstacles.0={name: step, shape: sphere, radius_m: 1.0e-6, position_m: [44.0e-6, 5.0e-6, 0]}"}},
    {"obstacles.shape.radius_m", {"obstacles.0.edges_m=[9.0e-6, 4.0e-6, 7.0e-6]"}},
    {"obstacles.shape.length_m",
     {"obstacles.0={name: step, shape: capsule, radius_m: 1.0e-6, length_m: 2.0e-6, position_m: [44.0e-6, 5.0e-6, "
      "0]}"}},
    {"obstacles.shape.extents_m", {"obstacles.0.edges_m=[9.0e-6, 4.0e-6, 7.0e-6]"}},
    {"obstacles.shape.mesh",
     {"obstacles.0={name: step, shape: mesh, unit_m: 1.0e-6, position_m: [44.0e-6, 5.0e-6, 0]}",
      other_mesh("obstacles.0")}},
    {"obstacles.position_m", {"obstacles.0.position_m=[44.0e-6, 5.0e-6, 61.0e-6]"}},
    {"obstacles.orientation_wxyz", {"obstacles.0.orientation_wxyz=[1, 0, 0, 0]"}},
    {"obstacles.loads", {"obstacles.0.loads=false"}},
    {"fields.directory", {}},
    {"fields.every_steps", {"output.fields.every_steps=500"}},
    {"fields.mean_start", {"output.fields.mean_over_steps=[8500, 12000]"}},
    {"fields.mean_stop", {"output.fields.mean_over_steps=[8000, 12500]"}},
    {"fields.mean_every_steps", {"output.fields.mean_every_steps=20"}},
    {"fields.quantities", {"output.fields.quantities=[velocity, vorticity]"}},
    {"fields.region_cells", {"output.fields.region_cells={x: 4}"}},
    {"fields.compression", {"output.fields.compression=none"}},
    {"flow.every_steps", {"output.flow.every_steps=10"}},
    {"flow.totals", {"output.flow.totals=false"}},
    {"flow.probes.name", {"output.flow.probes.0.name=lee"}},
    {"flow.probes.position_m", {"output.flow.probes.0.position_m=[1.1e-5, 2.0e-5, 3.0e-5]"}},
    {"flow.faces", {"output.flow.faces=false"}},
    {"no_slip_plane", {"fluid.no_slip_plane=none"}},
    {"trace_directory", {}},
    {"parameters", {"services.fluid={command: fluid, parameters: {a: 1}}"}},
};

const Travels body_travels{
    {"step_s", {"fluid.relaxation_time=0.7"}},
    {"integrator", {"body.integrator=semi_implicit_euler", "joints.1.signal=null", "joints.2.signal=null"}},
    {"gravity_m_per_s2", {"gravity_m_per_s2=[0, 0, -1]"}},
    {"fluid_density_kg_per_m3", {"fluid.density_kg_per_m3=1300"}},
    {"periodic_length_m", {"fluid.boundaries.x=periodic"}},
    {"bodies.name",
     {"bodies.0.name=globe", "springs.0.bodies=[globe, swimmer.B2]", "actuators=[]", "output.coefficients=null"}},
    {"bodies.shape.kind", {"bodies.0.shape=capsule"}},
    {"bodies.shape.radius_m", {"bodies.0.radius_m=2.1e-6"}},
    {"bodies.shape.length_m", {"bodies.0.shape=capsule", "bodies.0.length_m=1.0e-6"}},
    {"bodies.shape.extents_m",
     {"bodies.1.semi_axes_m=[1.0e-6, 2.0e-6, 2.5e-6]", "bodies.2.edges_m=[3.0e-6, 4.0e-6, 5.5e-6]"}},
    {"bodies.shape.mesh",
     {"bodies.1={name: egg, shape: mesh, unit_m: 1.0e-6, mass_kg: 1.0e-13, position_m: [40.0e-6, 18.0e-6, 10.0e-6]}",
      other_mesh("bodies.1")}},
    {"bodies.shape.parts.shape.kind", {"bodies.4.parts.0.shape=capsule"}},
    {"bodies.shape.parts.shape.radius_m", {"bodies.4.parts.0.radius_m=1.1e-6"}},
    {"bodies.shape.parts.shape.length_m", {"bodies.4.parts.0.length_m=5.0e-6"}},
    {"bodies.shape.parts.shape.extents_m", {"bodies.4.parts.1.edges_m=[2.0e-6, 5.0e-6, 2.0e-6]"}},
    {"bodies.shape.parts.shape.mesh",
     {"bodies.4.parts.0={shape: mesh, unit_m: 1.0e-6}", other_mesh("bodies.4.parts.0")}},
    {"bodies.shape.parts.position_m",
     {"bodies.4.parts.1.position_m=[0, 0, 7.0e-6]", "bodies.2.center_of_mass_m=[1.0e-7, 2.0e-7, 4.0e-7]"}},
    {"bodies.shape.parts.orientation_wxyz", {"bodies.4.parts.1.orientation_wxyz=[0.8, 0, 0, 0.6]"}},
    {"meshes.vertices_m", {"bodies.3.unit_m=2.1e-6"}},
    {"meshes.triangles", {other_mesh("bodies.3")}},
    {"bodies.inertia_kg_m2", {"bodies.2.inertia_kg_m2=[2.0e-25, 2.1e-25, 2.2e-25, 1.1e-26, 2.0e-26, 3.0e-26]"}},
    {"bodies.mass_kg", {"bodies.0.mass_kg=4.0e-13", "bodies.1.density_kg_per_m3=900"}},
    {"bodies.motion", {"bodies.0.motion=free"}},
    {"bodies.axis", {"bodies.0.axis=[0, 0, 1]"}},
    {"bodies.position_m", {"bodies.0.position_m=[8.0e-6, 25.0e-6, 22.0e-6]"}},
    {"bodies.orientation_wxyz", {"bodies.0.orientation_wxyz=[1, 0, 0, 0]"}},
    {"bodies.velocity_m_per_s", {"bodies.0.velocity_m_per_s=[0, 0, 0.2]"}},
    {"bodies.angular_velocity_rad_per_s", {"bodies.0.angular_velocity_rad_per_s=[0, 4, 0]"}},
    {"springs.body_A", {"springs.0.bodies=[swimmer.B2, ball]"}},
    {"springs.body_B", {"springs.0.bodies=[swimmer.B2, ball]"}},
    {"springs.stiffness_N_per_m", {"springs.0.stiffness_N_per_m=0.2"}},
    {"springs.damping_N_s_per_m", {"springs.0.damping_N_s_per_m=2.0e-8"}},
    {"springs.rest_length_m", {"springs.0.rest_length_m=13.0e-6"}},
    {"springs.anchor_A_m", {"springs.0.anchors_m=[[2.0e-6, 0, 0], [0, 0, -1.0e-6]]"}},
    {"springs.anchor_B_m", {"springs.0.anchors_m=[[1.0e-6, 0, 0], [0, 0, -2.0e-6]]"}},
    {"joints.kind", {"joints.2.kind=slider", "joints.2.axis=[1, 0, 0]", "joints.2.signal=null"}},
    {"joints.stiffness", {"joints.0.stiffness_N_m_per_rad=2.0e-13"}},
    {"joints.damping", {"joints.0.damping_N_m_s_per_rad=2.0e-21"}},
    {"joints.rest", {"joints.3.rest_m=2.0e-7"}},
    {"joints.lowest", {"joints.0.limits_rad=[-0.5, 1.5]"}},
    {"joints.highest", {"joints.3.limits_m=[-2.0e-6, 2.0e-6]"}},
    {"joints.body_A", {"joints.0.bodies=[swimmer.B1, swimmer.B3]"}},
    {"joints.body_B", {"joints.0.bodies=[rotator.C, swimmer.B2]"}},
    {"joints.anchor_A_m", {"joints.0.anchor_m=[21.0e-6, 25.0e-6, 50.0e-6]"}},
    {"joints.anchor_B_m", {"joints.1.anchors_m=[[0, 0, 1.0e-6], [0, 25.0e-6, 89.0e-6]]"}},
    {"joints.axis", {"joints.0.axis=[0, -1, 0]"}},
    {"bends.body_A", {"bends.0.bodies=[swimmer.B3, swimmer.B1, rotator.C]"}},
    {"bends.body_B", {"bends.0.bodies=[swimmer.B2, swimmer.B3, rotator.C]"}},
    {"bends.body_C", {"bends.0.bodies=[rotator.C, swimmer.B1, swimmer.B2]"}},
    {"bends.stiffness_N_m_per_rad", {"bends.0.stiffness_N_m_per_rad=2.0e-13"}},
    {"bends.rest_angle_rad", {"bends.0.rest_angle_rad=null", "bends.0.rest_angle_deg=170"}},
    {"actuators.kind", {"actuators.0.kind=world_force"}},
    {"actuators.body_A", {"actuators.0.body=swimmer.B2"}},
    {"actuators.body_B", {"actuators.1.bodies=[swimmer.B2, swimmer.B1]"}},
    {"actuators.direction", {"actuators.0.direction=[0, 0, 1]"}},
    {"actuators.anchor_A_m", {"actuators.1.anchors_m=[[0, 0, 2.0e-6], [1.0e-6, 0, 0]]"}},
    {"actuators.anchor_B_m", {"actuators.1.anchors_m=[[0, 0, 1.0e-6], [2.0e-6, 0, 0]]"}},
    {"actuators.joint", {"joints.1.signal=null"}},
    {"actuators.control", {"actuators.5.control=other motor"}},
    {"model.text", {"body.model.text=<mujoco></mujoco>"}},
    {"model.length_m", {"body.model.length_m=2.0e-6"}},
    {"model.mass_kg", {"body.model.mass_kg=2.0e-15"}},
    {"model.time_s", {"body.model.time_s=2.0e-6"}},
    {"walls.point_m", {"fluid.domain_cells=[50, 50, 96]"}},
    {"walls.normal", {"fluid.boundaries.x=periodic"}},
    {"walls.velocity_m_per_s", {"fluid.boundaries.y={velocity_m_per_s: [0, 0, 0.4]}"}},
    {"walls.removes_bodies", {removal}},
    {"walls.friction", {"contact.wall_friction=0.4"}},
    {"contact.stiffness_N_per_m", {"contact.stiffness_N_per_m=0.25"}},
    {"contact.restitution", {"contact.restitution=0.7"}},
    {"contact.friction", {"contact.friction=0.4"}},
    {"threads", {"services.body.threads=3"}},
    {"trace_directory", {}},
    {"parameters", {"body.solver={command: body, parameters: {a: 1}}"}},
};

/// Sections whose keys all go to a component, and those of their keys that do not.
const std::vector<std::string> travelling_sections{"fluid.",    "body.",   "bodies.[].", "springs.[].",
                                                   "bends.[].", "gravity", "contact."};
const std::set<std::string> keys_of_the_coupler{"fluid.solver.command", "body.solver", "body.solver.command",
                                                "body.model.file", "bodies.[].file"};

/// Values of every field of a message as text, by path; entries of lists one after the other.
using Leaves = std::map<std::string, std::string>;

void collect(const google::protobuf::Message& message, const std::string& prefix, Leaves& leaves) {
  const auto* reflection = message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const auto* field = message.GetDescriptor()->field(i);
    const std::string path = prefix + field->name();
    const bool holds_messages = field->cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE;
    if (field->is_repeated()) {
      const int size = reflection->FieldSize(message, field);
      if (!holds_messages) leaves[path];  // also of an empty list
      for (int item = 0; item < size; ++item) {
        if (holds_messages) {
          collect(reflection->GetRepeatedMessage(message, field, item), path + ".", leaves);
        } else {
          std::string text;
          google::protobuf::TextFormat::PrintFieldValueToString(message, field, item, &text);
          leaves[path] += text + " ";
        }
      }
    } else if (holds_messages) {
      collect(reflection->GetMessage(message, field), path + ".", leaves);
    } else {
      std::string text;
      google::protobuf::TextFormat::PrintFieldValueToString(message, field, -1, &text);
      leaves[path] += text + " ";
    }
  }
}

FluidSetup read_back(const FluidSetup&, const std::string& bytes) { return conversion::fluid_setup_from_bytes(bytes); }
BodySetup read_back(const BodySetup&, const std::string& bytes) { return conversion::body_setup_from_bytes(bytes); }

template <typename Wire, typename Setup>
Leaves leaves_of(const Setup& setup) {
  const std::string bytes = conversion::to_bytes(setup);
  Wire wire;
  EXPECT_TRUE(wire.ParseFromString(bytes));
  Leaves leaves;
  collect(wire, "", leaves);
  EXPECT_EQ(conversion::to_bytes(read_back(setup, bytes)), bytes) << "message_fields.hpp loses a field";
  return leaves;
}

const std::string every_key = std::string(CONFIG_TESTS) + "/every_key.yaml";

FluidSetup fluid_setup(const LoadedCase& loaded) {
  FluidSetup setup = make_fluid_setup(loaded.content, loaded.assembly, "/run");
  setup.trace_directory = "/run/trace";
  return setup;
}

BodySetup body_setup(const LoadedCase& loaded) {
  BodySetup setup = make_body_setup(loaded.content, loaded.assembly);
  setup.trace_directory = "/run/trace";
  return setup;
}

Leaves leaves_of(const LoadedCase& loaded, bool fluid) {
  return fluid ? leaves_of<v1::FluidSetup>(fluid_setup(loaded)) : leaves_of<v1::BodySetup>(body_setup(loaded));
}

LoadedCase read_again(const LoadedCase& loaded) {
  return load_case_text(to_yaml(resolved(loaded.content)), "case.yaml", {});
}

class KeyTravel : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] bool fluid() const { return GetParam(); }
  [[nodiscard]] const Travels& travels() const { return fluid() ? fluid_travels : body_travels; }
  [[nodiscard]] const char* setup() const { return fluid() ? "FluidSetup." : "BodySetup."; }
};

TEST_P(KeyTravel, EveryFieldOfTheSetupIsListedHere) {
  std::set<std::string> listed;
  for (const auto& [field, overrides] : travels()) listed.insert(field);
  for (const auto& [field, value] : leaves_of(load_case(every_key, {}), fluid())) {
    EXPECT_TRUE(listed.erase(field) == 1) << setup() << field << " is new (which key sets it?). Add a row above.";
  }
  EXPECT_TRUE(listed.empty()) << setup() << *listed.begin() << " is not a field any more. Remove its row.";
}

TEST_P(KeyTravel, EveryFieldIsSetByItsKeyAndSurvivesTheResolvedCase) {
  const LoadedCase unchanged = load_case(every_key, {});
  const Leaves before = leaves_of(unchanged, fluid());
  const Leaves before_again = leaves_of(read_again(unchanged), fluid());
  for (const auto& [field, overrides] : travels()) {
    const std::string what = setup() + field;
    if (overrides.empty()) {
      EXPECT_TRUE(before.at(field).find("UNSPECIFIED") == std::string::npos && before.at(field) != "\"\" ")
          << what << " is never set";
      continue;
    }
    const LoadedCase loaded = load_case(every_key, overrides);
    const Leaves after = leaves_of(loaded, fluid());
    EXPECT_NE(after.at(field), before.at(field))
        << what << " does not follow " << overrides.back() << ": its declaration or message_fields.hpp";
    const LoadedCase again = load_case_text(to_yaml(resolved(loaded.content)), "case.yaml", {});
    EXPECT_EQ(leaves_of(again, fluid()), after) << "the resolved case lacks what sets " << what;
  }
}

TEST(KeysOfTheCoupler, SurviveTheResolvedCase) {
  const LoadedCase loaded = load_case(every_key, {"swimmers.1.phase_deg=30"});
  const LoadedCase again = read_again(loaded);
  ASSERT_EQ(again.assembly.drive.size(), loaded.assembly.drive.size());
  for (std::size_t i = 0; i < loaded.assembly.drive.size(); ++i)
    EXPECT_EQ(again.assembly.drive[i].signal, loaded.assembly.drive[i].signal) << loaded.assembly.signal_paths[i];
  ASSERT_EQ(again.content.actuators.size(), loaded.content.actuators.size());
  for (std::size_t i = 0; i < loaded.content.actuators.size(); ++i)
    EXPECT_EQ(again.content.actuators[i].signal, loaded.content.actuators[i].signal) << i;
  EXPECT_EQ(again.content.swimmers[1].phase_deg, 30.0);
  EXPECT_EQ(again.content.groups[0].period_steps, loaded.content.groups[0].period_steps);
  EXPECT_EQ(again.content.virtual_mass, loaded.content.virtual_mass);
  EXPECT_EQ(again.content.load_averaging, loaded.content.load_averaging);
  EXPECT_EQ(again.content.output.checkpoint_every_steps, loaded.content.output.checkpoint_every_steps);
  EXPECT_EQ(again.content.output.flow_from_step, 400);
  EXPECT_EQ(again.content.services.silence_s, loaded.content.services.silence_s);
  const auto &coefficients = loaded.content.output.coefficients[0], &same = again.content.output.coefficients[0];
  EXPECT_EQ(same.of, "ball");
  EXPECT_EQ(same.speed_m_per_s, coefficients.speed_m_per_s);
  EXPECT_EQ(same.area_m2, coefficients.area_m2);
  EXPECT_EQ(same.length_m, coefficients.length_m);
  EXPECT_EQ(same.drag_axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(same.lift_axis, Eigen::Vector3d::UnitY());
  EXPECT_EQ(same.from_step, 6000);
}

INSTANTIATE_TEST_SUITE_P(Setups, KeyTravel, testing::Values(true, false),
                         [](const auto& role) { return role.param ? "Fluid" : "Body"; });

/// "springs.0.anchors_m=…" is about "springs.[].anchors_m".
std::string key_of(const std::string& override_text) {
  static const std::regex place("\\.[0-9]+(?=\\.|$)");
  return std::regex_replace(override_text.substr(0, override_text.find('=')), place, ".[]");
}

TEST(Keys, OfTheComponentsSectionsAllReachASetup) {
  std::set<std::string> travelling = keys_of_the_coupler;
  for (const auto* travels : {&fluid_travels, &body_travels}) {
    for (const auto& [field, overrides] : *travels) {
      travelling.insert((travels == &fluid_travels ? "fluid." : "body.") + field);  // of one value only
      for (const std::string& override_text : overrides) travelling.insert(key_of(override_text));
    }
  }
  for (const std::string& key : case_keys()) {
    const bool belongs_to_a_component =
        std::any_of(travelling_sections.begin(), travelling_sections.end(),
                    [&](const std::string& section) { return key.starts_with(section); });
    const bool travels = std::any_of(travelling.begin(), travelling.end(), [&](const std::string& known) {
      return key == known || known.starts_with(key + ".") || key.starts_with(known + ".");
    });
    EXPECT_TRUE(!belongs_to_a_component || travels) << key << " changes no field of a setup. Add it to a row above.";
  }
}

}  // namespace
}  // namespace copepod::coupler
