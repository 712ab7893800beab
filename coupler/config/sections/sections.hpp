#pragma once

#include "config/sections/case.hpp"
#include "config/yaml/reader.hpp"

namespace copepod::coupler {

// One pair of functions per section of the case. `read_…` reads its keys and reports what it cannot use to
// the reader's problems; `resolved_…` beside it writes the section with every default spelled out. Reading
// what was written gives the same section, bit for bit.

FluidCase read_fluid(Reader fluid);
nlohmann::ordered_json resolved_fluid(const FluidCase& fluid);

Shape read_shape(Reader& reader);
void add_shape(nlohmann::ordered_json& section, const Shape& shape);

/// Times given in seconds or as angles become steps of `step_s`, here and in the sections below; 0 where the step
/// cannot be used, which is reported elsewhere.
Swimmer read_swimmer(Reader swimmer, double step_s);
nlohmann::ordered_json resolved_swimmer(const Swimmer& swimmer);

/// Everything of a swimmer but its centre.
Swimmer read_template(Reader& swimmer, double step_s);

/// Adds the swimmers that section `swarm` places: around the other swimmers and the bodies, which have been read.
void read_swarm(Reader swarm, Case& the_case);

/// The shorthand's own keys: beads B2, B1, B3 in a row along z, B1 at the origin.
void read_three_beads(Reader& swimmer, Swimmer& result);
void add_three_beads(nlohmann::ordered_json& section, const Swimmer& swimmer);

PublishedFigures read_published(Reader published);
nlohmann::ordered_json resolved_published(const PublishedFigures& figures);

/// γ as given, or from the damping ratio D = γ / (2 √(m k))   [paper, eq. (11)]
/// @param mass_kg  of each body, where they differ twice the reduced mass
double read_damping(Reader& spring, double stiffness_N_per_m, double mass_kg);

SingleBody read_body(Reader body, double step_s);
nlohmann::ordered_json resolved_body(const SingleBody& body);

/// Key `model` of section `body`: the text of the model, or the file that holds it.
void read_model(Reader& body, BodyCase& result);
nlohmann::ordered_json resolved_model(const ModelSpecification& model);

/// Adds what the body component makes of the model: its spheres and capsules as bodies, and as joints which of them may
/// overlap. Starts the component's program (`--bodies`).
void read_bodies_of_model(Case& the_case, Problems& problems);

NamedSpring read_spring(Reader spring);
nlohmann::ordered_json resolved_spring(const NamedSpring& spring);

NamedBend read_named_bend(Reader bend);
nlohmann::ordered_json resolved_named_bend(const NamedBend& bend);

NamedJoint read_joint(Reader joint, double step_s);
nlohmann::ordered_json resolved_joint(const NamedJoint& joint);

/// Everything of a bend but its bodies.
void read_bend(Reader& bend, BendSpecification& result);
void add_bend(nlohmann::ordered_json& section, const BendSpecification& bend);

NamedActuator read_actuator(Reader actuator, double step_s);
nlohmann::ordered_json resolved_actuator(const NamedActuator& actuator);

/// Key of the amplitude of a signal that is a factor.
inline constexpr const char* factor_key = "amplitude";

/// @param amplitude  key of the amplitude, with its unit
Signal read_signal(Reader signal, double step_s, const std::string& amplitude);
nlohmann::ordered_json resolved_signal(const Signal& signal, const char* amplitude);

Drive read_drive(Reader drive, double step_s);
nlohmann::ordered_json resolved_drive(const Drive& drive);

ContactCase read_contact(Reader contact);
nlohmann::ordered_json resolved_contact(const ContactCase& contact);

NamedGroup read_group(Reader group);
nlohmann::ordered_json resolved_group(const NamedGroup& group);

/// Reads the whole case from its root.
Case read_case(Reader top);
/// A parameter set that was chosen stays as a label only: its values are written where they belong.
nlohmann::ordered_json resolved(const Case& the_case);

/// The resolved case without length of the run, output, services and published figures.
nlohmann::ordered_json physics_of(Case the_case);
/// What makes two runs the same physics: its digest.
std::string case_key(const Case& the_case);

/// Unit quaternion `orientation_wxyz`, no rotation if absent; reports one that is far from unit length.
Eigen::Vector4d read_orientation(Reader& reader);

/// Shortest rotation that takes the z axis to the unit vector `direction`.
///   q = (q_w, z × d / (2 q_w)),  q_w = √((1 + c)/2) = |z × d| / √(2 (1 − c)),  c = z · d
/// The second form of q_w loses no digits near −z.
Eigen::Vector4d rotation_from_z(const Eigen::Vector3d& direction);

/// Unit vector along the given direction; reports a zero vector. Without `otherwise` the key is required.
Eigen::Vector3d read_direction(Reader& reader, const std::string& key,
                               const std::optional<Eigen::VectorXd>& otherwise = {});

/// A list of `count` names; reports any other number of them and returns empty names.
/// @param remedy  "(why). What to do."
std::vector<std::string> read_names(Reader& reader, const std::string& key, std::size_t count,
                                    const std::string& remedy);

/// Key `anchors_m`: points on two bodies, in their frames; their centres if absent.
std::pair<Eigen::Vector3d, Eigen::Vector3d> read_anchors(Reader& reader);
nlohmann::ordered_json resolved_anchors(const Eigen::Vector3d& anchor_A_m, const Eigen::Vector3d& anchor_B_m);

/// Reads the `solver` of a section: one of `names`, or `{command: …}`, a component of the user's own.
/// @param command  set to the words of that command, left alone otherwise
/// @return E::external for a component of the user's own
template <typename E, std::size_t N>
E read_solver(Reader& section, const std::array<Choice<E>, N>& names, std::optional<E> otherwise,
              std::vector<std::string>& command) {
  const Value* value = section.raw("solver");
  if (value == nullptr || value->kind != Value::Kind::mapping) return section.choice("solver", names, otherwise);
  Reader solver = section.section("solver");
  command = solver.command("command");
  if (command.empty() && !solver.problems().any_under(solver.path_of("command"))) {
    solver.reject("command",
                  "is missing (a solver is a name, or the command of a component). Write {command: \"program "
                  "argument …\"}.");
  }
  return E::external;
}

ServicesCase read_services(Reader services);
nlohmann::ordered_json resolved_services(const ServicesCase& services);

}  // namespace copepod::coupler
