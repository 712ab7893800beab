#pragma once

#include <array>
#include <string>

#include "config/case.hpp"
#include "config/reader.hpp"

namespace copepod::coupler {

// The words of the case file for our enumerators; capabilities use the same ones.

inline constexpr std::array solver_names{
    Choice<FluidSolverChoice>{"lattice_boltzmann", FluidSolverChoice::lattice_boltzmann},
    Choice<FluidSolverChoice>{"stokes", FluidSolverChoice::stokes},
    Choice<FluidSolverChoice>{"vacuum", FluidSolverChoice::vacuum},
    Choice<FluidSolverChoice>{"external", FluidSolverChoice::external}};

inline constexpr std::array body_solver_names{
    Choice<BodySolverChoice>{"own", BodySolverChoice::own},
    Choice<BodySolverChoice>{"bullet", BodySolverChoice::bullet},
    Choice<BodySolverChoice>{"external", BodySolverChoice::external}};

inline constexpr std::array collision_names{Choice<CollisionKind>{"bgk", CollisionKind::bgk},
                                            Choice<CollisionKind>{"trt", CollisionKind::trt}};

inline constexpr std::array moving_boundary_names{
    Choice<MovingBoundary>{"bounce_back", MovingBoundary::bounce_back}};

inline constexpr std::array refill_names{Choice<Refill>{"equilibrium", Refill::equilibrium}};

inline constexpr std::array precision_names{Choice<Precision>{"double", Precision::double_precision},
                                            Choice<Precision>{"single", Precision::single_precision}};

inline constexpr std::array boundary_names{Choice<BoundaryKind>{"no_slip", BoundaryKind::no_slip},
                                           Choice<BoundaryKind>{"periodic", BoundaryKind::periodic},
                                           Choice<BoundaryKind>{"free_slip", BoundaryKind::free_slip},
                                           Choice<BoundaryKind>{"velocity", BoundaryKind::velocity},
                                           Choice<BoundaryKind>{"pressure", BoundaryKind::pressure}};

/// Faces by their number in the order of FluidSetup::boundaries.
inline constexpr std::array plane_names{
    Choice<int>{"none", -1},  Choice<int>{"x_low", 0}, Choice<int>{"x_high", 1}, Choice<int>{"y_low", 2},
    Choice<int>{"y_high", 3}, Choice<int>{"z_low", 4}, Choice<int>{"z_high", 5}};

inline constexpr std::array shape_names{Choice<ShapeKind>{"sphere", ShapeKind::sphere},
                                        Choice<ShapeKind>{"capsule", ShapeKind::capsule}};

inline constexpr std::array orientation_names{
    Choice<BeadOrientation>{"parallel", BeadOrientation::parallel},
    Choice<BeadOrientation>{"perpendicular", BeadOrientation::perpendicular}};

inline constexpr std::array motion_names{
    Choice<MotionKind>{"free", MotionKind::free}, Choice<MotionKind>{"fixed", MotionKind::fixed},
    Choice<MotionKind>{"prescribed", MotionKind::prescribed}, Choice<MotionKind>{"axis", MotionKind::axis}};

inline constexpr std::array integrator_names{
    Choice<Integrator>{"semi_implicit_euler", Integrator::semi_implicit_euler},
    Choice<Integrator>{"runge_kutta_4", Integrator::runge_kutta_4}};

inline constexpr std::array averaging_names{Choice<LoadAveraging>{"none", LoadAveraging::none},
                                            Choice<LoadAveraging>{"two_step", LoadAveraging::two_step}};

enum class SchemeKind { serial_explicit };
inline constexpr std::array scheme_names{Choice<SchemeKind>{"serial_explicit", SchemeKind::serial_explicit}};

inline constexpr std::array switch_names{Choice<bool>{"true", true}, Choice<bool>{"false", false}};

inline constexpr std::array axis_names{"x", "y", "z"};

/// Key path of a face by its number in the order of FluidSetup::boundaries.
inline std::string face_path(std::size_t face) {
  return std::string("fluid.boundaries.") + axis_names[face / 2] + (face % 2 == 0 ? ".low" : ".high");
}

}  // namespace copepod::coupler
