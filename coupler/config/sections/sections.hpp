#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "config/sections/case.hpp"
#include "config/yaml/document.hpp"
#include "config/yaml/keys.hpp"
#include "contract/body_setup.hpp"
#include "contract/words.hpp"
#include "driving/driving_protocol.hpp"

namespace copepod::coupler {

// Each section of the case is a function that declares its keys (config/yaml/keys.hpp). What was written is read again
// as the same section, bit for bit. Times given in seconds or as angles become steps of `step_s`, which is 0 where the
// step cannot be used: that is reported elsewhere.

/// @param given_step_s  by the case
void declare(Keys& keys, FluidCase& fluid, std::optional<double> given_step_s);
void declare(Keys& keys, Shape& shape);
/// Mass or density, after the shape.
void declare_mass(Keys& keys, GivenBody& body);
void declare(Keys& keys, SingleBody& body, double step_s);
void declare(Keys& keys, NamedGroup& group);
void declare(Keys& keys, NamedSpring& spring);
void declare(Keys& keys, NamedBend& bend);
void declare(Keys& keys, BendSpecification& bend);  ///< everything but its bodies
void declare(Keys& keys, NamedJoint& joint, double step_s);
void declare(Keys& keys, NamedActuator& actuator, double step_s);
void declare(Keys& keys, ControllerCase& controller);
void declare(Keys& keys, Drive& drive, double step_s);
void declare(Keys& keys, OutputCase& output, const FluidCase& fluid, std::int64_t steps);
void declare(Keys& keys, ServicesCase& services);
void declare(Keys& keys, Swimmer& swimmer, double step_s, bool has_center);

struct DescribedKey {
  const char* name;
  const char* description;
};

/// The key of a signal's amplitude, with its unit.
struct Amplitude {
  const char* key = "";
  const char* description = "";
  bool applies = true;
  bool is_factor = false;  ///< 1 by default
  [[nodiscard]] constexpr Amplitude where(bool condition) const { return {key, description, condition, is_factor}; }
};

inline constexpr Amplitude factor_of_velocities{"amplitude", "Factor A of the velocities.", true, true};

/// @param amplitudes  of which one applies
void declare(Keys& keys, Signal& signal, double step_s, std::initializer_list<Amplitude> amplitudes);

/// Section `swarm`; adds the swimmers that it places: around the other swimmers and the bodies, which have been read.
void declare_swarm(Keys& keys, Case& the_case);

/// Key `model` of section `body`: the text of the model, or the file that holds it.
void declare_model(Keys& keys, BodyCase& body);

/// Adds what the body component makes of the model: its spheres and capsules as bodies, and as joints which of them may
/// overlap. Starts the component's program (`--bodies`).
void read_bodies_of_model(Case& the_case, Problems& problems);

/// Reads the whole case from its root.
Case read_case(const Document& document, Problems& problems);
/// The case with every default spelled out. A parameter set that was chosen stays as a label only: its values are
/// written where they belong.
nlohmann::ordered_json resolved(Case the_case);
/// JSON schema of a case file.
nlohmann::ordered_json case_schema();
/// Paths of all keys, with [] for the items of lists.
const std::vector<std::string>& case_keys();

/// The resolved case without length of the run, output but for the coefficients, services and published figures.
nlohmann::ordered_json physics_of(Case the_case);
/// What makes two runs the same physics: its digest.
std::string case_key(const Case& the_case);

/// Unit quaternion; reports one that is far from unit length.
void declare_orientation(Keys& keys, Eigen::Vector4d& orientation_wxyz, const char* description);

/// Shortest rotation that takes the z axis to the unit vector `direction`.
///   q = (q_w, z × d / (2 q_w)),  q_w = √((1 + c)/2) = |z × d| / √(2 (1 − c)),  c = z · d
/// The second form of q_w loses no digits near −z.
Eigen::Vector4d rotation_from_z(const Eigen::Vector3d& direction);

/// Unit vector along the given direction; reports a zero vector.
void declare_direction(Keys& keys, const Key& key, Eigen::Vector3d& direction, const char* description);

/// A list of `count` names; reports any other number of them and returns empty names.
/// @param remedy  "why). What to do."
void declare_names(Keys& keys, const Key& key, std::vector<std::string>& names, std::size_t count,
                   const std::string& remedy, const char* description);

/// Key `anchors_m`: points on two bodies, in their frames; their centres if absent.
void declare_anchors(Keys& keys, Eigen::Vector3d& anchor_A_m, Eigen::Vector3d& anchor_B_m, const char* description);

/// Key `parameters`: what a component of the user's own receives, any values by name, as JSON.
void declare_parameters(Keys& keys, std::string& parameters);

/// The key `solver`: one of `names`, or `{command: …}`, a component of the user's own (E::external).
/// @param command, parameters  of that component; left alone otherwise
template <typename E, std::size_t N>
void declare_solver(Keys& keys, const Key& key, E& solver, const std::array<Choice<E>, N>& names,
                    std::vector<std::string>& command, std::string& parameters, const char* description) {
  const Value* value = keys.raw(key.name);
  const bool is_section = value != nullptr && value->kind == Value::Kind::mapping;
  if (keys.when(!is_section)) keys.choice(key, solver, names, description);
  if (!keys.when(is_section)) return;
  solver = keys.describes() ? solver : E::external;
  keys.either(key, [&](Keys& own) {
    own.command(required("command"), command,
                "Command that starts the component, as one text or a list of words. Relative paths in it start at the "
                "directory in which `copepod run` is called.");
    declare_parameters(own, parameters);
    own.reject_if(
        command.empty() && !own.has_errors("command"), "command",
        "is missing (a solver is a name, or the command of a component). Write {command: \"program argument …\"}.");
  });
}

/// All bodies, springs, bends, joints and actuators of a case: swimmers expanded, names turned into positions in
/// `bodies`. Bodies of swimmers come first, bead by bead.
struct Assembly {
  std::vector<BodySpecification> bodies;
  std::vector<std::string> body_paths;   ///< key path in the case that each body came from
  std::vector<int> first_bodies;         ///< of each swimmer: the body of its first bead; the others follow
  std::vector<std::vector<int>> groups;  ///< bodies of each group of the case
  std::vector<PrescribedBody> prescribed;
  std::vector<SpringSpecification> springs;
  std::vector<std::string> spring_paths;
  std::vector<BendSpecification> bends;
  std::vector<std::string> bend_paths;
  std::vector<JointSpecification> joints;  ///< in the order of the case
  std::vector<DrivenActuator> drive;
  /// Key path that each actuator came from: that of the actuator, of the arm, or of the stroke; then those of
  /// prescribed bodies.
  std::vector<std::string> drive_paths;
  std::vector<std::string> signal_paths;  ///< of the actuators' signals
  std::vector<int> drive_springs;         ///< number of the spring whose rest length each varies; −1: none
};

/// Names that do not exist give body −1; `check_names` reports them.
Assembly assemble(const Case& the_case);

enum class SweepScale { linear, logarithmic };
enum class SweepCombination { grid, zip };

inline constexpr auto scale_names = words<SweepScale>("linear", "logarithmic");
inline constexpr auto combination_names = words<SweepCombination>("grid", "zip");

/// A key of the case that takes several values.
struct SweptKey {
  std::string key;                        ///< key path
  SweepScale scale = SweepScale::linear;  ///< of the range that the values come from
  std::vector<Value> values;
};

/// Keys of the case that take several values: a run for each combination (grid), or for each place in their lists
/// (zip). Members are numbered from 0; in a grid the last key varies fastest.
struct Sweep {
  std::vector<SweptKey> parameters;
  SweepCombination combination = SweepCombination::grid;
};

std::size_t member_count(const Sweep& sweep);

/// What makes a member of the case: a value for each swept key, in their order, and no sweep.
std::vector<Value::Entry> assignments_of(const Sweep& sweep, std::size_t member);

/// A member in a message: «amplitude_N=1e-05, lag_deg=30».
std::string member_text(const Sweep& sweep, std::size_t member);

/// An assignment as after --set.
std::string setting_text(const Value::Entry& assignment);

/// The values of a range. Its ends are those that are written; the others are rounded to a thousandth of the distance
/// between neighbours, so that they read as a person would write them.
///   linear       vᵢ = a + (b − a) i / (n − 1)
///   logarithmic  vᵢ = a (b/a)^(i / (n − 1))
/// @param count  n, at least 2
/// @return decimal texts
std::vector<std::string> range_texts(double from, double to, std::size_t count, SweepScale scale);

/// The sweep of a case, or nothing.
/// @throws CaseInvalid with every error found in it
std::optional<Sweep> read_sweep(const Document& document);
/// Adds the section `sweep` to the schema of the case.
void describe_sweep(Keys& keys);

}  // namespace copepod::coupler
