#include "contract/features.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>

#include "contract/words.hpp"
#include "copepod/v1/setup.pb.h"

namespace copepod {
namespace {

using Names = std::set<std::string>;

FluidSetup fluid_setup() {
  FluidSetup setup;
  setup.bodies = {{ShapeKind::sphere, 1e-6, 0.0}};
  return setup;
}

BodySetup body_setup() {
  BodySetup setup;
  setup.bodies.resize(2);
  return setup;
}

TEST(RequiredFeatures, OfAFluidAreWhatItsSetupUses) {
  EXPECT_EQ(required_features(fluid_setup()),
            (Names{"solver:lattice_boltzmann", "collision:bgk", "precision:double", "refill:equilibrium",
                   "moving_boundary:bounce_back", "boundary:no_slip", "shape:sphere"}));
}

TEST(RequiredFeatures, OfBodiesAreWhatTheirSetupUses) {
  EXPECT_EQ(required_features(body_setup()), (Names{"integrator:runge_kutta_4", "shape:sphere", "motion:free"}));
}

TEST(RequiredFeatures, OfNoBodiesAreThoseOfTheIntegratorOnly) {
  BodySetup setup;
  setup.periodic_length_m = {1e-4, 1e-4, 1e-4};
  EXPECT_EQ(required_features(setup), (Names{"integrator:runge_kutta_4"}));
}

TEST(RequiredFeatures, DoNotNameALatticeInStokesFlow) {
  FluidSetup setup = fluid_setup();
  setup.kind = FluidKind::stokes;
  EXPECT_EQ(required_features(setup), (Names{"solver:stokes", "shape:sphere"}));
  setup.kind = FluidKind::vacuum;
  EXPECT_EQ(required_features(setup), (Names{"solver:vacuum"}));
}

/// A field of a setup message, a way of using it, and the feature that must then be required.
template <class Setup>
struct Guard {
  std::function<void(Setup&)> use;
  std::string feature;
};

const std::map<std::string, Guard<FluidSetup>> fluid_guards{
    {"kind", {[](FluidSetup& s) { s.kind = FluidKind::stokes; }, "solver:stokes"}},
    {"boundaries", {[](FluidSetup& s) { s.boundaries[3].kind = BoundaryKind::periodic; }, "boundary:periodic"}},
    {"boundaries.kind", {[](FluidSetup& s) { s.boundaries[3].kind = BoundaryKind::free_slip; }, "boundary:free_slip"}},
    {"boundaries.velocity_m_per_s",
     {[](FluidSetup& s) { s.boundaries[0].kind = BoundaryKind::velocity; }, "boundary:velocity"}},
    {"boundaries.pressure_Pa",
     {[](FluidSetup& s) { s.boundaries[0].kind = BoundaryKind::pressure; }, "boundary:pressure"}},
    {"boundaries.parabolic", {[](FluidSetup& s) { s.boundaries[0].parabolic = true; }, "profile:parabolic"}},
    {"boundaries.profile", {[](FluidSetup& s) { s.boundaries[0].profile = {1.0}; }, "profile:table"}},
    {"boundaries.removes_bodies", {[](FluidSetup& s) { s.boundaries[0].removes_bodies = true; }, "removal"}},
    {"boundaries.signal", {[](FluidSetup& s) { s.boundaries[0].signal = Signal{}; }, "boundary:signal"}},
    {"no_slip_plane", {[](FluidSetup& s) { s.kind = FluidKind::stokes, s.no_slip_plane = 4; }, "no_slip_plane"}},
    {"symmetry_planes", {[](FluidSetup& s) { s.symmetry_planes[1] = true; }, "symmetry_planes"}},
    {"body_force_N_per_m3", {[](FluidSetup& s) { s.body_force_N_per_m3.z() = 1.0; }, "body_force"}},
    {"initial_flow", {[](FluidSetup& s) { s.initial_flow.kind = InitialFlowKind::shear; }, "initial_flow:shear"}},
    {"initial_flow.kind", {[](FluidSetup& s) { s.initial_flow.kind = InitialFlowKind::shear; }, "initial_flow:shear"}},
    {"initial_flow.velocity_m_per_s",
     {[](FluidSetup& s) { s.initial_flow.kind = InitialFlowKind::uniform; }, "initial_flow:uniform"}},
    {"initial_flow.speed_m_per_s",
     {[](FluidSetup& s) { s.initial_flow.kind = InitialFlowKind::taylor_green; }, "initial_flow:taylor_green"}},
    {"initial_flow.file", {[](FluidSetup& s) { s.initial_flow.kind = InitialFlowKind::file; }, "initial_flow:file"}},
    {"initial_flow.group", {[](FluidSetup& s) { s.initial_flow.kind = InitialFlowKind::file; }, "initial_flow:file"}},
    {"collision", {[](FluidSetup& s) { s.collision = CollisionKind::central_moments; }, "collision:central_moments"}},
    {"moving_boundary", {[](FluidSetup&) {}, "moving_boundary:bounce_back"}},
    {"refill", {[](FluidSetup&) {}, "refill:equilibrium"}},
    {"precision", {[](FluidSetup& s) { s.precision = Precision::single_precision; }, "precision:single"}},
    {"film_thickness_m", {[](FluidSetup& s) { s.film_thickness_m = 1e-6; }, "thin_films"}},
    {"jointed", {[](FluidSetup& s) { s.film_thickness_m = 1e-6; }, "thin_films"}},
    {"jointed.body_A", {[](FluidSetup& s) { s.film_thickness_m = 1e-6; }, "thin_films"}},
    {"jointed.body_B", {[](FluidSetup& s) { s.film_thickness_m = 1e-6; }, "thin_films"}},
    {"bodies", {[](FluidSetup&) {}, "shape:sphere"}},
    {"bodies.kind", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::capsule; }, "shape:capsule"}},
    {"bodies.length_m", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::capsule; }, "shape:capsule"}},
    {"bodies.extents_m", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::ellipsoid; }, "shape:ellipsoid"}},
    {"bodies.mesh", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::mesh; }, "shape:mesh"}},
    {"bodies.parts",
     {[](FluidSetup& s) { s.bodies[0].parts.resize(1), s.bodies[0].kind = ShapeKind::compound; }, "shape:compound"}},
    {"bodies.parts.shape", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::compound; }, "shape:compound"}},
    {"bodies.parts.position_m", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::compound; }, "shape:compound"}},
    {"bodies.parts.orientation_wxyz",
     {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::compound; }, "shape:compound"}},
    {"meshes", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::mesh; }, "shape:mesh"}},
    {"meshes.vertices_m", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::mesh; }, "shape:mesh"}},
    {"meshes.triangles", {[](FluidSetup& s) { s.bodies[0].kind = ShapeKind::mesh; }, "shape:mesh"}},
    {"obstacles", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.name", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.loads", {[](FluidSetup& s) { s.obstacles.resize(1), s.obstacles[0].loads = true; }, "obstacle_loads"}},
    {"obstacles.shape", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.position_m", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.orientation_wxyz", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.kind", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.radius_m", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.length_m", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.extents_m", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.mesh", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.parts", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.parts.shape", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.parts.position_m", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"obstacles.shape.parts.orientation_wxyz", {[](FluidSetup& s) { s.obstacles.resize(1); }, "obstacles"}},
    {"fields", {[](FluidSetup& s) { s.fields.every_steps = 10; }, "fields"}},
    {"fields.directory", {[](FluidSetup& s) { s.fields.every_steps = 10; }, "fields"}},
    {"fields.every_steps", {[](FluidSetup& s) { s.fields.every_steps = 10; }, "fields"}},
    {"fields.mean_start", {[](FluidSetup& s) { s.fields.mean_stop = 10; }, "fields"}},
    {"fields.mean_stop", {[](FluidSetup& s) { s.fields.mean_stop = 10; }, "fields"}},
    {"fields.mean_every_steps", {[](FluidSetup& s) { s.fields.mean_stop = 10; }, "fields"}},
    {"fields.quantities",
     {[](FluidSetup& s) { s.fields.every_steps = 10, s.fields.quantities = {FieldQuantity::pressure}; },
      "fields:selection"}},
    {"fields.region_cells",
     {[](FluidSetup& s) { s.fields.every_steps = 10, s.fields.region_cells = {0, 1, 0, 0, 0, 0}; },
      "fields:selection"}},
    {"fields.compression",
     {[](FluidSetup& s) { s.fields.mean_stop = 10, s.fields.compression = 1; }, "fields:selection"}},
    {"flow", {[](FluidSetup& s) { s.flow.every_steps = 10; }, "flow_samples"}},
    {"flow.every_steps", {[](FluidSetup& s) { s.flow.every_steps = 10; }, "flow_samples"}},
    {"flow.totals", {[](FluidSetup& s) { s.flow.every_steps = 10; }, "flow_samples"}},
    {"flow.probes", {[](FluidSetup& s) { s.flow.every_steps = 10; }, "flow_samples"}},
    {"flow.probes.name", {[](FluidSetup& s) { s.flow.every_steps = 10; }, "flow_samples"}},
    {"flow.faces", {[](FluidSetup& s) { s.flow.every_steps = 10, s.flow.faces = {1}; }, "flow_samples:faces"}},
    {"flow.probes.position_m", {[](FluidSetup& s) { s.flow.every_steps = 10; }, "flow_samples"}},
};

const std::map<std::string, Guard<BodySetup>> body_guards{
    {"integrator",
     {[](BodySetup& s) { s.integrator = Integrator::semi_implicit_euler; }, "integrator:semi_implicit_euler"}},
    {"gravity_m_per_s2", {[](BodySetup& s) { s.gravity_m_per_s2.z() = -9.81; }, "gravity"}},
    {"fluid_density_kg_per_m3", {[](BodySetup& s) { s.gravity_m_per_s2.z() = -9.81; }, "gravity"}},  // buoyancy
    {"periodic_length_m", {[](BodySetup& s) { s.periodic_length_m[2] = 1e-4; }, "periodic"}},
    {"bodies", {[](BodySetup&) {}, "shape:sphere"}},
    {"bodies.shape", {[](BodySetup&) {}, "shape:sphere"}},
    {"bodies.shape.kind", {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::capsule; }, "shape:capsule"}},
    {"bodies.shape.length_m", {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::capsule; }, "shape:capsule"}},
    {"bodies.shape.extents_m",
     {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::ellipsoid; }, "shape:ellipsoid"}},
    {"bodies.shape.mesh", {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::mesh; }, "shape:mesh"}},
    {"bodies.shape.parts",
     {[](BodySetup& s) { s.bodies[1].shape.parts.resize(1), s.bodies[1].shape.kind = ShapeKind::compound; },
      "shape:compound"}},
    {"bodies.shape.parts.shape",
     {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::compound; }, "shape:compound"}},
    {"bodies.shape.parts.position_m",
     {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::compound; }, "shape:compound"}},
    {"bodies.shape.parts.orientation_wxyz",
     {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::compound; }, "shape:compound"}},
    {"bodies.inertia_kg_m2", {[](BodySetup& s) { s.bodies[1].inertia_kg_m2.assign(6, 1.0); }, "inertia"}},
    {"meshes", {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::mesh; }, "shape:mesh"}},
    {"meshes.vertices_m", {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::mesh; }, "shape:mesh"}},
    {"meshes.triangles", {[](BodySetup& s) { s.bodies[1].shape.kind = ShapeKind::mesh; }, "shape:mesh"}},
    {"bodies.motion", {[](BodySetup& s) { s.bodies[1].motion = MotionKind::fixed; }, "motion:fixed"}},
    {"bodies.axis", {[](BodySetup& s) { s.bodies[1].motion = MotionKind::axis; }, "motion:axis"}},
    {"springs", {[](BodySetup& s) { s.springs.resize(1); }, "springs"}},
    {"springs.body_A", {[](BodySetup& s) { s.springs.resize(1); }, "springs"}},
    {"springs.body_B", {[](BodySetup& s) { s.springs.resize(1); }, "springs"}},
    {"springs.stiffness_N_per_m", {[](BodySetup& s) { s.springs.resize(1); }, "springs"}},
    {"springs.damping_N_s_per_m", {[](BodySetup& s) { s.springs.resize(1); }, "springs"}},
    {"springs.rest_length_m", {[](BodySetup& s) { s.springs.resize(1); }, "springs"}},
    {"springs.anchor_A_m", {[](BodySetup& s) { s.springs.resize(1), s.springs[0].anchor_A_m.x() = 1e-6; }, "anchors"}},
    {"springs.anchor_B_m", {[](BodySetup& s) { s.springs.resize(1), s.springs[0].anchor_B_m.x() = 1e-6; }, "anchors"}},
    {"bends", {[](BodySetup& s) { s.bends.resize(1); }, "bends"}},
    {"bends.body_A", {[](BodySetup& s) { s.bends.resize(1); }, "bends"}},
    {"bends.body_B", {[](BodySetup& s) { s.bends.resize(1); }, "bends"}},
    {"bends.body_C", {[](BodySetup& s) { s.bends.resize(1); }, "bends"}},
    {"bends.stiffness_N_m_per_rad", {[](BodySetup& s) { s.bends.resize(1); }, "bends"}},
    {"bends.rest_angle_rad", {[](BodySetup& s) { s.bends.resize(1); }, "bends"}},
    {"joints", {[](BodySetup& s) { s.joints.resize(1); }, "joint:ball"}},
    {"joints.kind",
     {[](BodySetup& s) {
        s.joints = {{JointKind::slider, 0}};
      },
      "joint:slider"}},
    {"joints.body_A", {[](BodySetup& s) { s.joints.resize(1); }, "joint:ball"}},
    {"joints.body_B", {[](BodySetup& s) { s.joints.resize(1); }, "joint:ball"}},
    {"joints.anchor_A_m", {[](BodySetup& s) { s.joints.resize(1); }, "joint:ball"}},
    {"joints.anchor_B_m", {[](BodySetup& s) { s.joints.resize(1); }, "joint:ball"}},
    {"joints.axis",
     {[](BodySetup& s) {
        s.joints = {{JointKind::hinge, 0}};
      },
      "joint:hinge"}},
    {"joints.stiffness", {[](BodySetup& s) { s.joints.resize(1), s.joints[0].stiffness = 1; }, "joint:springs"}},
    {"joints.damping", {[](BodySetup& s) { s.joints.resize(1), s.joints[0].damping = 1; }, "joint:springs"}},
    {"joints.lowest", {[](BodySetup& s) { s.joints.resize(1), s.joints[0].lowest = -1; }, "joint:limits"}},
    {"joints.highest", {[](BodySetup& s) { s.joints.resize(1), s.joints[0].highest = 1; }, "joint:limits"}},
    {"joints.rest",
     {[](BodySetup& s) { s.joints.resize(1), s.joints[0].stiffness = s.joints[0].rest = 1; }, "joint:springs"}},
    {"actuators", {[](BodySetup& s) { s.actuators.resize(1); }, "actuator:pair_force"}},
    {"actuators.kind",
     {[](BodySetup& s) {
        s.actuators = {{ActuatorKind::world_torque, 0}};
      },
      "actuator:world_torque"}},
    {"actuators.body_A", {[](BodySetup& s) { s.actuators.resize(1); }, "actuator:pair_force"}},
    {"actuators.body_B", {[](BodySetup& s) { s.actuators.resize(1); }, "actuator:pair_force"}},
    {"actuators.direction",
     {[](BodySetup& s) {
        s.actuators = {{ActuatorKind::body_force, 0}};
      },
      "actuator:body_force"}},
    {"actuators.anchor_A_m",
     {[](BodySetup& s) { s.actuators.resize(1), s.actuators[0].anchor_A_m.x() = 1e-6; }, "anchors"}},
    {"actuators.anchor_B_m",
     {[](BodySetup& s) { s.actuators.resize(1), s.actuators[0].anchor_B_m.x() = 1e-6; }, "anchors"}},
    {"actuators.joint",
     {[](BodySetup& s) {
        s.actuators = {{ActuatorKind::joint_motion, 0}};
      },
      "actuator:joint_motion"}},
    {"actuators.control",
     {[](BodySetup& s) {
        s.actuators = {{ActuatorKind::control, 0}};
      },
      "actuator:control"}},
    {"model", {[](BodySetup& s) { s.model.text = "<mujoco/>"; }, "model:mjcf"}},
    {"model.text", {[](BodySetup& s) { s.model.text = "<mujoco/>"; }, "model:mjcf"}},
    {"model.length_m", {[](BodySetup& s) { s.model.text = "<mujoco/>"; }, "model:mjcf"}},
    {"model.mass_kg", {[](BodySetup& s) { s.model.text = "<mujoco/>"; }, "model:mjcf"}},
    {"model.time_s", {[](BodySetup& s) { s.model.text = "<mujoco/>"; }, "model:mjcf"}},
    {"walls", {[](BodySetup& s) { s.walls.resize(1); }, "walls"}},
    {"walls.point_m", {[](BodySetup& s) { s.walls.resize(1); }, "walls"}},
    {"walls.normal", {[](BodySetup& s) { s.walls.resize(1); }, "walls"}},
    {"walls.velocity_m_per_s", {[](BodySetup& s) { s.walls.resize(1); }, "walls"}},
    {"walls.removes_bodies", {[](BodySetup& s) { s.walls.resize(1), s.walls[0].removes_bodies = true; }, "removal"}},
    {"walls.friction",
     {[](BodySetup& s) { s.contact.stiffness_N_per_m = 1.0, s.walls.resize(1), s.walls[0].friction = 0.3; },
      "contact:friction"}},
    {"contact", {[](BodySetup& s) { s.contact.stiffness_N_per_m = 1.0; }, "contact"}},
    {"contact.stiffness_N_per_m", {[](BodySetup& s) { s.contact.stiffness_N_per_m = 1.0; }, "contact"}},
    {"contact.restitution", {[](BodySetup& s) { s.contact.stiffness_N_per_m = 1.0; }, "contact"}},
    {"contact.friction",
     {[](BodySetup& s) { s.contact.stiffness_N_per_m = 1.0, s.contact.friction = 0.3; }, "contact:friction"}},
};

/// Fields that every solver of the role must read, so that no feature guards them; a source of our service or
/// of the kit reads each of them under its name in the contract.
const Names fluid_essentials{"step_s",       "cell_size_m",     "density_kg_per_m3", "kinematic_viscosity_m2_per_s",
                             "domain_cells", "bodies.radius_m", "wall_overlap_m",    "trace_directory"};
const Names body_essentials{"step_s",
                            "bodies.name",
                            "bodies.shape.radius_m",
                            "bodies.mass_kg",
                            "bodies.position_m",
                            "bodies.orientation_wxyz",
                            "bodies.velocity_m_per_s",
                            "bodies.angular_velocity_rad_per_s",
                            "threads",
                            "trace_directory"};

/// Paths of all fields of a message, those of its nested messages included, but for a message within itself, or one
/// that may be absent, which is guarded as a whole.
void add_fields(const google::protobuf::Descriptor& message, const std::string& prefix, Names& paths,
                std::vector<const google::protobuf::Descriptor*> around = {}) {
  if (std::ranges::find(around, &message) != around.end()) return;
  around.push_back(&message);
  for (int i = 0; i < message.field_count(); ++i) {
    const auto& field = *message.field(i);
    const std::string path = prefix + field.name();
    paths.insert(path);
    if (field.message_type() != nullptr && !field.has_optional_keyword())
      add_fields(*field.message_type(), path + ".", paths, around);
  }
}

/// All sources below a folder, in one text.
std::string sources_of(const std::string& folder) {
  std::ostringstream text;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(SOURCES "/" + folder)) {
    if (entry.path().extension() == ".cpp" || entry.path().extension() == ".hpp")
      text << std::ifstream(entry.path()).rdbuf();
  }
  return text.str();
}

template <class Setup>
void expect_every_field_to_be_guarded(const google::protobuf::Descriptor& message, const Setup& plain,
                                      const std::map<std::string, Guard<Setup>>& guards, const Names& essentials,
                                      const std::string& service) {
  const std::string sources = sources_of(service) + sources_of("proto/component");
  Names fields;
  add_fields(message, "", fields);
  fields.erase("parameters");  // of components that replace ours alone: check refuses others
  for (const std::string& field : fields) {
    EXPECT_NE(guards.contains(field), essentials.contains(field))
        << field << " must either be guarded by a feature (proto/contract/features.cpp) or be essential";
  }
  for (const auto& [field, guard] : guards) {
    EXPECT_TRUE(fields.contains(field)) << field;
    Setup setup = plain;
    guard.use(setup);
    EXPECT_TRUE(required_features(setup).contains(guard.feature)) << field;
  }
  for (const std::string& field : essentials) {
    EXPECT_TRUE(fields.contains(field)) << field;
    const std::string name = field.substr(field.rfind('.') + 1);
    EXPECT_TRUE(std::regex_search(sources, std::regex("\\." + name + "\\b"))) << service << " does not read " << field;
  }
}

TEST(EveryField, OfAFluidSetupIsGuardedByAFeatureOrReadByTheSolver) {
  expect_every_field_to_be_guarded(*v1::FluidSetup::descriptor(), fluid_setup(), fluid_guards, fluid_essentials,
                                   "fluid_service");
}

TEST(EveryField, OfABodySetupIsGuardedByAFeatureOrReadByTheSolver) {
  expect_every_field_to_be_guarded(*v1::BodySetup::descriptor(), body_setup(), body_guards, body_essentials,
                                   "body_service");
}

template <typename E, std::size_t N>
void expect_known(const std::string& group, const std::array<Choice<E>, N>& words) {
  for (const Choice<E>& word : words) {
    const auto comparison = compare_features({}, {group + ":" + word.name});
    EXPECT_TRUE(comparison.unknown.empty()) << group << ":" << word.name;
  }
}

TEST(KnownFeatures, HoldEveryWordOfTheContract) {
  expect_known("solver", fluid_kind_names);
  expect_known("collision", collision_names);
  expect_known("moving_boundary", moving_boundary_names);
  expect_known("refill", refill_names);
  expect_known("precision", precision_names);
  expect_known("boundary", boundary_names);
  expect_known("shape", shape_names);
  expect_known("motion", motion_names);
  expect_known("actuator", actuator_names);
  expect_known("integrator", integrator_names);
}

TEST(CompareFeatures, NamesWhatIsMissing) {
  const auto comparison = compare_features({"shape:capsule", "shape:sphere", "springs"}, {"shape:sphere"});
  EXPECT_EQ(comparison.missing, (std::vector<std::string>{"shape:capsule", "springs"}));
  EXPECT_TRUE(comparison.neglected.empty());
}

TEST(CompareFeatures, WaivesMethodsButNotPhysicsForAnExternalSolver) {
  const auto comparison = compare_features(
      {"solver:lattice_boltzmann", "collision:trt", "refill:equilibrium", "shape:capsule", "body_force"},
      {"solver:external", "shape:sphere"});
  EXPECT_EQ(comparison.missing, (std::vector<std::string>{"body_force", "shape:capsule"}));
}

TEST(CompareFeatures, ReportsWhatAComponentNeglects) {
  const auto comparison = compare_features({"boundary:no_slip", "boundary:velocity", "body_force", "symmetry_planes"},
                                           {"solver:external", "neglects:boundary", "neglects:symmetry_planes"});
  EXPECT_EQ(comparison.neglected,
            (std::vector<std::string>{"boundary:no_slip", "boundary:velocity", "symmetry_planes"}));
  EXPECT_EQ(comparison.missing, (std::vector<std::string>{"body_force"}));
  EXPECT_TRUE(comparison.unknown.empty());
}

TEST(CompareFeatures, ReportsUnknownNamesWithTheNearestOne) {
  const auto comparison = compare_features({"springs"}, {"springz", "levitation"});
  EXPECT_EQ(comparison.missing, (std::vector<std::string>{"springs"}));
  ASSERT_EQ(comparison.unknown.size(), 2U);
  EXPECT_EQ(comparison.unknown[0].name, "levitation");
  EXPECT_EQ(comparison.unknown[0].nearest, "");
  EXPECT_EQ(comparison.unknown[1].name, "springz");
  EXPECT_EQ(comparison.unknown[1].nearest, "springs");
}

}  // namespace
}  // namespace copepod
