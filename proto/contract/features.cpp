#include "contract/features.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <sstream>

#include "contract/words.hpp"

namespace copepod {
namespace {

using enum FeatureKind;

/// "boundary" of "boundary:velocity"; a name without a colon is its own group.
std::string group_of(const std::string& name) { return name.substr(0, name.find(':')); }

template <typename E, std::size_t N>
std::string feature(const char* group, const std::array<Choice<E>, N>& names, E value) {
  return std::string(group) + ":" + name_of(names, value);
}

/// Every name that may be announced, the neglected ones included.
const std::set<std::string>& announceable_names() {
  static const std::set<std::string> names = [] {
    std::set<std::string> result;
    for (const Feature& feature : known_features()) {
      result.insert(feature.name);
      if (feature.kind != physics && feature.kind != run) continue;
      result.insert("neglects:" + feature.name);
      result.insert("neglects:" + group_of(feature.name));
    }
    return result;
  }();
  return names;
}

bool is_method(const std::string& name) {
  const Feature* known = find_feature(name);
  return known != nullptr && known->kind == method;
}

void require_shape(const Shape& shape, std::set<std::string>& required) {
  required.insert(feature("shape", shape_names, shape.kind));
  for (const ShapePart& part : shape.parts) require_shape(part.shape, required);
}

void require_lattice_features(const FluidSetup& setup, std::set<std::string>& required) {
  required.insert(feature("collision", collision_names, setup.collision));
  required.insert(feature("precision", precision_names, setup.precision));
  if (!setup.bodies.empty()) {
    required.insert(feature("moving_boundary", moving_boundary_names, setup.moving_boundary));
    required.insert(feature("refill", refill_names, setup.refill));
  }
  for (const Boundary& boundary : setup.boundaries) {
    required.insert(feature("boundary", boundary_names, boundary.kind));
    if (boundary.parabolic) required.insert("profile:parabolic");
    if (boundary.signal) required.insert("boundary:signal");
    if (!boundary.profile.empty()) required.insert("profile:table");
    if (boundary.removes_bodies) required.insert("removal");
  }
  if (setup.flow.every_steps > 0) required.insert("flow_samples");
  if (setup.flow.every_steps > 0 && !setup.flow.faces.empty()) required.insert("flow_samples:faces");
  if (std::ranges::count(setup.symmetry_planes, true) > 0) required.insert("symmetry_planes");
  if (!setup.body_force_N_per_m3.isZero(0.0)) required.insert("body_force");
  if (setup.film_thickness_m > 0.0) required.insert("thin_films");
  if (setup.initial_flow.kind != InitialFlowKind::rest)
    required.insert(feature("initial_flow", initial_flow_names, setup.initial_flow.kind));
  if (setup.fields.every_steps == 0 && setup.fields.mean_stop == 0) return;
  required.insert("fields");
  const std::vector<FieldQuantity> usual{FieldQuantity::density, FieldQuantity::velocity};
  const bool usual_quantities = setup.fields.quantities.empty() || setup.fields.quantities == usual;
  if (!usual_quantities || !setup.fields.region_cells.empty() || setup.fields.compression > 0)
    required.insert("fields:selection");
}

}  // namespace

const std::vector<Feature>& known_features() {
  static const std::vector<Feature> features{
      {"solver:lattice_boltzmann", method, "flow of finite inertia in a domain of cells"},
      {"solver:stokes", method, "flow without inertia, unbounded or above one plane"},
      {"solver:vacuum", method, "no fluid: all loads are zero"},
      {"solver:external", remark, "replaces the solver named in the case: nothing of kind method is required"},
      {"collision:bgk", method, "one relaxation time"},
      {"collision:trt", method, "two relaxation times"},
      {"collision:central_moments", method, "central moments, for low viscosity"},
      {"precision:double", method, "populations in double precision"},
      {"precision:single", method, "populations in single precision"},
      {"moving_boundary:bounce_back", method, "bodies act on the fluid by halfway bounce-back"},
      {"moving_boundary:interpolated", method, "by linear interpolation before or after the reflection"},
      {"moving_boundary:central_linear", method, "by central linear interpolation"},
      {"moving_boundary:parabolic", method, "by parabolic interpolation"},
      {"refill:equilibrium", method, "uncovered cells start from the equilibrium"},
      {"refill:nonequilibrium", method, "from the equilibrium and the neighbours' non-equilibrium part"},
      {"refill:grad", method, "from the equilibrium and the neighbours' stress"},
      {"thin_films", physics, "loads leave out what thin films between surfaces exert, which the coupler adds"},
      {"boundary:no_slip", physics, "a face of the domain is a wall at rest"},
      {"boundary:periodic", physics, "opposite faces are connected"},
      {"boundary:free_slip", physics, "a face is a wall without friction"},
      {"boundary:velocity", physics, "a face is a wall moving in its plane, or an inlet"},
      {"boundary:pressure", physics, "a face is open at a given pressure"},
      {"boundary:outflow", physics, "fluid and sound leave through a face"},
      {"boundary:signal", physics, "the velocity of a face varies in time"},
      {"profile:parabolic", physics, "fluid comes in with a parabolic profile"},
      {"profile:table", physics, "fluid comes in with a profile that is given for each cell"},
      {"no_slip_plane", physics, "one wall in Stokes flow"},
      {"symmetry_planes", physics, "the flow is mirrored about planes through the middle of the domain"},
      {"body_force", physics, "a constant force per volume drives the fluid"},
      {"initial_flow:uniform", physics, "the fluid starts with one velocity"},
      {"initial_flow:shear", physics, "the fluid starts in linear shear between two walls"},
      {"initial_flow:taylor_green", physics, "the fluid starts as a Taylor-Green vortex"},
      {"initial_flow:taylor_green_3d", physics, "the fluid starts as a Taylor-Green vortex in three dimensions"},
      {"initial_flow:file", physics, "the fluid starts with the flow that a file holds"},
      {"shape:sphere", physics, "bodies that are spheres"},
      {"shape:capsule", physics, "bodies that are capsules"},
      {"shape:ellipsoid", physics, "bodies that are ellipsoids"},
      {"shape:cylinder", physics, "bodies that are cylinders with flat ends"},
      {"shape:box", physics, "bodies that are boxes"},
      {"shape:mesh", physics, "bodies within closed surfaces of triangles"},
      {"shape:compound", physics, "bodies that are the union of several shapes"},
      {"inertia", physics, "bodies of a given inertia tensor"},
      {"obstacles", physics, "solid parts of the domain that never move"},
      {"obstacle_loads", physics, "loads on obstacles that ask for them"},
      {"motion:free", physics, "bodies with six degrees of freedom"},
      {"motion:fixed", physics, "bodies that never move"},
      {"motion:prescribed", physics, "bodies that keep their given velocities"},
      {"motion:axis", physics, "bodies that move along, and rotate about, one axis"},
      {"springs", physics, "springs with dampers between bodies"},
      {"anchors", physics, "springs and pair forces attached away from the centres of their bodies"},
      {"bends", physics, "angular springs between the arms from one body to two others"},
      {"joint:ball", physics, "bodies that keep one point in common"},
      {"joint:hinge", physics, "bodies that keep a point and the direction of an axis in common"},
      {"joint:slider", physics, "bodies that move along an axis of each other without turning"},
      {"joint:fixed", physics, "bodies without relative motion"},
      {"joint:distance", physics, "points of two bodies that keep their distance"},
      {"joint:model", physics, "joints that body.model holds"},
      {"joint:springs", physics, "springs and dampers in hinges and sliders"},
      {"joint:limits", physics, "hinges and sliders that move no further than a limit"},
      {"actuator:pair_force", physics, "drives that push two bodies apart along the current line between them"},
      {"actuator:body_force", physics, "driving forces that turn with their body"},
      {"actuator:body_torque", physics, "driving torques that turn with their body"},
      {"actuator:world_force", physics, "driving forces of fixed direction"},
      {"actuator:world_torque", physics, "driving torques of fixed direction"},
      {"actuator:joint_motion", physics, "hinges, sliders and rods whose motion is given"},
      {"actuator:control", physics, "inputs of actuators that body.model holds"},
      {"model:mjcf", physics, "bodies given as a model of MuJoCo; --bodies prints them"},
      {"gravity", physics, "weight and buoyancy of the bodies"},
      {"contact", physics, "bodies that meet rebound with a given restitution"},
      {"contact:friction", physics, "bodies that meet have Coulomb friction"},
      {"walls", physics, "bodies meet plane walls"},
      {"removal", physics, "bodies leave through an outflow"},
      {"periodic", physics, "bodies near opposite periodic faces are neighbours"},
      {"integrator:semi_implicit_euler", method, "first order in the step"},
      {"integrator:runge_kutta_4", method, "fourth order in the step"},
      {"checkpoint", run, "saves its state and resumes from it"},
      {"snapshots", run, "begins anew with another setup between two steps"},
      {"fields", run, "writes fields.h5 with its XDMF files"},
      {"fields:selection", run, "writes chosen quantities and regions, compressed if requested"},
      {"flow_samples", run, "returns totals of the flow, and velocity and pressure at probes"},
      {"flow_samples:faces", run, "returns what flows through faces of the domain, and the force on them"},
      {"mpi", remark, "runs as several MPI processes"},
      {"estimate", remark, "--estimate: computes the memory for a setup before a run starts"},
      {"contacts", remark, "bodies that touch push each other apart"},
      {"imposes:flow", remark, "the fluid is not at rest at the start"},
      {"neglects:loads", remark, "exerts no loads on bodies, or ignores them"},
      {"neglects:torques", remark, "exerts no torques on bodies, or ignores them"},
  };
  return features;
}

const Feature* find_feature(const std::string& name) {
  const auto& features = known_features();
  const auto found = std::ranges::find(features, name, &Feature::name);
  return found == features.end() ? nullptr : &*found;
}

const char* name_of(FeatureKind kind) {
  constexpr std::array names{"physics", "method", "run", "remark"};
  return names[static_cast<std::size_t>(kind)];
}

std::set<std::string> features_in(const std::string& names) {
  std::istringstream words(names);
  return {std::istream_iterator<std::string>(words), {}};
}

std::set<std::string> required_features(const FluidSetup& setup) {
  std::set<std::string> required{feature("solver", fluid_kind_names, setup.kind)};
  if (setup.kind == FluidKind::vacuum) return required;
  for (const Shape& shape : setup.bodies) require_shape(shape, required);
  for (const ObstacleSpecification& obstacle : setup.obstacles) require_shape(obstacle.shape, required);
  if (!setup.obstacles.empty()) required.insert("obstacles");
  if (std::ranges::any_of(setup.obstacles, &ObstacleSpecification::loads)) required.insert("obstacle_loads");
  if (setup.kind == FluidKind::stokes && setup.no_slip_plane >= 0) required.insert("no_slip_plane");
  if (setup.kind == FluidKind::lattice_boltzmann) require_lattice_features(setup, required);
  return required;
}

std::set<std::string> required_features(const BodySetup& setup) {
  std::set<std::string> required{feature("integrator", integrator_names, setup.integrator)};
  for (const BodySpecification& body : setup.bodies) {
    require_shape(body.shape, required);
    if (!body.inertia_kg_m2.empty()) required.insert("inertia");
    required.insert(feature("motion", motion_names, body.motion));
  }
  for (const SpringSpecification& spring : setup.springs) {
    required.insert("springs");
    if (!spring.anchor_A_m.isZero(0.0) || !spring.anchor_B_m.isZero(0.0)) required.insert("anchors");
  }
  if (!setup.bends.empty()) required.insert("bends");
  for (const JointSpecification& joint : setup.joints) {
    required.insert(feature("joint", joint_names, joint.kind));
    if (joint.stiffness != 0.0 || joint.damping != 0.0) required.insert("joint:springs");
    if (joint.has_limits()) required.insert("joint:limits");
  }
  for (const ActuatorSpecification& actuator : setup.actuators) {
    required.insert(feature("actuator", actuator_names, actuator.kind));
    if (!actuator.anchor_A_m.isZero(0.0) || !actuator.anchor_B_m.isZero(0.0)) required.insert("anchors");
  }
  if (!setup.model.text.empty()) required.insert("model:mjcf");
  if (!setup.gravity_m_per_s2.isZero(0.0)) required.insert("gravity");
  if (setup.contact.stiffness_N_per_m > 0.0) {
    required.insert("contact");
    if (setup.contact.friction > 0.0 ||
        std::ranges::any_of(setup.walls, [](const auto& wall) { return wall.friction > 0; }))
      required.insert("contact:friction");
  }
  for (const WallSpecification& wall : setup.walls) required.insert(wall.removes_bodies ? "removal" : "walls");
  for (const double length_m : setup.periodic_length_m)
    if (length_m != 0.0 && !setup.bodies.empty()) required.insert("periodic");
  return required;
}

std::set<std::string> without_methods(std::set<std::string> required) {
  std::erase_if(required, is_method);
  return required;
}

std::set<std::string> accepted_for(const std::string& feature) {
  std::set<std::string> accepted{feature, "neglects:" + feature, "neglects:" + group_of(feature)};
  if (is_method(feature)) accepted.insert("solver:external");
  return accepted;
}

FeatureComparison compare_features(const std::set<std::string>& required, const std::set<std::string>& announced) {
  FeatureComparison comparison;
  const bool replaces_solver = announced.contains("solver:external");
  for (const std::string& name : required) {
    if (announced.contains(name) || (replaces_solver && is_method(name))) continue;
    const bool neglected =
        std::ranges::any_of(accepted_for(name), [&](const auto& it) { return announced.contains(it); });
    (neglected ? comparison.neglected : comparison.missing).push_back(name);
  }
  const std::set<std::string>& known = announceable_names();
  for (const std::string& name : announced)
    if (!known.contains(name)) comparison.unknown.push_back({name, nearest_word(name, {known.begin(), known.end()})});
  return comparison;
}

}  // namespace copepod
