#pragma once

#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod {

/// Number in messages: a person reads four significant digits.
std::string rounded_text(double number);
std::string length_text(double length_m);  ///< with a unit in which it is readable: "1.5 µm"

/// "a, b, c"
std::string listed(const std::vector<std::string>& words, const std::string& separator = ", ");

/// The number that a whole text is, without spaces or a plus sign.
template <typename Number>
std::optional<Number> number_in(std::string_view text) {
  Number number{};
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && stop == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// Word for an enumerator in case files, feature names and messages.
template <typename E>
struct Choice {
  const char* name;  ///< in files and messages
  E value;           ///< the enumerator
};

/// The word for a value; empty if it has none.
template <typename E, std::size_t N>
const char* name_of(const std::array<Choice<E>, N>& choices, E value) {
  for (const Choice<E>& choice : choices)
    if (choice.value == value) return choice.name;
  return "";
}

/// Words of the enumerators in their order, from `first` on.
template <typename E, int first = 0, typename... Names>
constexpr std::array<Choice<E>, sizeof...(Names)> words(Names... names) {
  int value = first;
  return {Choice<E>{names, static_cast<E>(value++)}...};
}

inline constexpr auto fluid_kind_names = words<FluidKind>("lattice_boltzmann", "stokes", "vacuum");
inline constexpr auto collision_names = words<CollisionKind>("bgk", "trt", "central_moments");
inline constexpr auto moving_boundary_names =
    words<MovingBoundary>("bounce_back", "interpolated", "central_linear", "parabolic");
inline constexpr auto refill_names = words<Refill>("equilibrium", "nonequilibrium", "grad");
inline constexpr auto precision_names = words<Precision>("double", "single");
inline constexpr auto boundary_names =
    words<BoundaryKind>("no_slip", "periodic", "free_slip", "velocity", "pressure", "outflow");
inline constexpr auto leaving_names = words<bool>("end", "remove");
inline constexpr auto profile_names = words<bool>("uniform", "parabolic");
inline constexpr auto signal_names = words<SignalKind>("constant", "sinusoid", "square", "trapezoid", "table");
inline constexpr auto initial_flow_names =
    words<InitialFlowKind>("rest", "uniform", "shear", "taylor_green", "taylor_green_3d", "file");
inline constexpr auto quantity_names = words<FieldQuantity>("density", "velocity", "pressure", "vorticity");

/// Levels of FieldOutput::compression.
inline constexpr auto compression_names = words<int>("none", "deflate");

/// Faces by their number in the order of FluidSetup::boundaries.
inline constexpr auto plane_names = words<int, -1>("none", "x_low", "x_high", "y_low", "y_high", "z_low", "z_high");

inline constexpr auto shape_names =
    words<ShapeKind>("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "compound");

/// What a shape is for its user: one that is not around its centre of mass is a compound of one part.
inline const char* word_of(const Shape& shape) {
  return name_of(shape_names, shape.parts.size() == 1 ? shape.parts[0].shape.kind : shape.kind);
}

inline constexpr auto motion_names = words<MotionKind>("free", "fixed", "prescribed", "axis");
inline constexpr auto integrator_names = words<Integrator>("semi_implicit_euler", "runge_kutta_4");
inline constexpr auto joint_names = words<JointKind>("ball", "hinge", "slider", "fixed", "distance", "model");
inline constexpr auto actuator_names = words<ActuatorKind>("pair_force", "body_force", "body_torque", "world_force",
                                                           "world_torque", "joint_motion", "control");

/// Levenshtein's: letters to add, to leave out, or to replace.
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The known word closest to `word`, for "Did you mean …?"; empty if none is close.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

}  // namespace copepod
