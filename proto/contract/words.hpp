#pragma once

#include <array>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod {

/// Word for an enumerator in case files, feature names and messages.
template <typename E>
struct Choice {
  const char* name;
  E value;
};

template <typename E, std::size_t N>
const char* name_of(const std::array<Choice<E>, N>& choices, E value) {
  for (const Choice<E>& choice : choices) {
    if (choice.value == value) return choice.name;
  }
  return "";
}

inline constexpr std::array fluid_kind_names{Choice<FluidKind>{"lattice_boltzmann", FluidKind::lattice_boltzmann},
                                             Choice<FluidKind>{"stokes", FluidKind::stokes},
                                             Choice<FluidKind>{"vacuum", FluidKind::vacuum}};

inline constexpr std::array collision_names{Choice<CollisionKind>{"bgk", CollisionKind::bgk},
                                            Choice<CollisionKind>{"trt", CollisionKind::trt}};

inline constexpr std::array moving_boundary_names{
    Choice<MovingBoundary>{"bounce_back", MovingBoundary::bounce_back},
    Choice<MovingBoundary>{"interpolated", MovingBoundary::interpolated},
    Choice<MovingBoundary>{"central_linear", MovingBoundary::central_linear},
    Choice<MovingBoundary>{"parabolic", MovingBoundary::parabolic}};

inline constexpr std::array refill_names{Choice<Refill>{"equilibrium", Refill::equilibrium},
                                         Choice<Refill>{"nonequilibrium", Refill::nonequilibrium},
                                         Choice<Refill>{"grad", Refill::grad}};

inline constexpr std::array precision_names{Choice<Precision>{"double", Precision::double_precision},
                                            Choice<Precision>{"single", Precision::single_precision}};

inline constexpr std::array boundary_names{
    Choice<BoundaryKind>{"no_slip", BoundaryKind::no_slip}, Choice<BoundaryKind>{"periodic", BoundaryKind::periodic},
    Choice<BoundaryKind>{"free_slip", BoundaryKind::free_slip},
    Choice<BoundaryKind>{"velocity", BoundaryKind::velocity}, Choice<BoundaryKind>{"pressure", BoundaryKind::pressure}};

inline constexpr std::array initial_flow_names{Choice<InitialFlowKind>{"rest", InitialFlowKind::rest},
                                               Choice<InitialFlowKind>{"uniform", InitialFlowKind::uniform},
                                               Choice<InitialFlowKind>{"shear", InitialFlowKind::shear},
                                               Choice<InitialFlowKind>{"taylor_green", InitialFlowKind::taylor_green}};

inline constexpr std::array quantity_names{Choice<FieldQuantity>{"density", FieldQuantity::density},
                                           Choice<FieldQuantity>{"velocity", FieldQuantity::velocity},
                                           Choice<FieldQuantity>{"pressure", FieldQuantity::pressure},
                                           Choice<FieldQuantity>{"vorticity", FieldQuantity::vorticity}};

/// Levels of FieldOutput::compression.
inline constexpr std::array compression_names{Choice<int>{"none", 0}, Choice<int>{"deflate", 1}};

/// Faces by their number in the order of FluidSetup::boundaries.
inline constexpr std::array plane_names{Choice<int>{"none", -1}, Choice<int>{"x_low", 0},  Choice<int>{"x_high", 1},
                                        Choice<int>{"y_low", 2}, Choice<int>{"y_high", 3}, Choice<int>{"z_low", 4},
                                        Choice<int>{"z_high", 5}};

inline constexpr std::array shape_names{Choice<ShapeKind>{"sphere", ShapeKind::sphere},
                                        Choice<ShapeKind>{"capsule", ShapeKind::capsule},
                                        Choice<ShapeKind>{"ellipsoid", ShapeKind::ellipsoid},
                                        Choice<ShapeKind>{"cylinder", ShapeKind::cylinder},
                                        Choice<ShapeKind>{"box", ShapeKind::box},
                                        Choice<ShapeKind>{"mesh", ShapeKind::mesh},
                                        Choice<ShapeKind>{"compound", ShapeKind::compound}};

inline constexpr std::array motion_names{
    Choice<MotionKind>{"free", MotionKind::free}, Choice<MotionKind>{"fixed", MotionKind::fixed},
    Choice<MotionKind>{"prescribed", MotionKind::prescribed}, Choice<MotionKind>{"axis", MotionKind::axis}};

inline constexpr std::array integrator_names{Choice<Integrator>{"semi_implicit_euler", Integrator::semi_implicit_euler},
                                             Choice<Integrator>{"runge_kutta_4", Integrator::runge_kutta_4}};

inline constexpr std::array joint_names{
    Choice<JointKind>{"ball", JointKind::ball},         Choice<JointKind>{"hinge", JointKind::hinge},
    Choice<JointKind>{"slider", JointKind::slider},     Choice<JointKind>{"fixed", JointKind::fixed},
    Choice<JointKind>{"distance", JointKind::distance}, Choice<JointKind>{"model", JointKind::model}};

inline constexpr std::array actuator_names{Choice<ActuatorKind>{"pair_force", ActuatorKind::pair_force},
                                           Choice<ActuatorKind>{"body_force", ActuatorKind::body_force},
                                           Choice<ActuatorKind>{"body_torque", ActuatorKind::body_torque},
                                           Choice<ActuatorKind>{"world_force", ActuatorKind::world_force},
                                           Choice<ActuatorKind>{"world_torque", ActuatorKind::world_torque},
                                           Choice<ActuatorKind>{"joint_motion", ActuatorKind::joint_motion},
                                           Choice<ActuatorKind>{"control", ActuatorKind::control}};

/// Levenshtein's: letters to add, to leave out, or to replace.
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The known word closest to `word`, for "Did you mean …?"; empty if none is close.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

}  // namespace copepod
