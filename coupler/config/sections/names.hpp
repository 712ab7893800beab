#pragma once

#include <array>
#include <string>

#include "config/sections/case.hpp"
#include "config/yaml/reader.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {

// The words of the case file for the coupler's own enumerators; those of the contract are in
// contract/words.hpp.

inline constexpr std::array solver_names{
    Choice<FluidSolverChoice>{"lattice_boltzmann", FluidSolverChoice::lattice_boltzmann},
    Choice<FluidSolverChoice>{"stokes", FluidSolverChoice::stokes},
    Choice<FluidSolverChoice>{"vacuum", FluidSolverChoice::vacuum},
    Choice<FluidSolverChoice>{"external", FluidSolverChoice::external}};

inline constexpr std::array body_solver_names{
    Choice<BodySolverChoice>{"own", BodySolverChoice::own},
    Choice<BodySolverChoice>{"bullet", BodySolverChoice::bullet},
    Choice<BodySolverChoice>{"external", BodySolverChoice::external}};

inline constexpr std::array orientation_names{
    Choice<BeadOrientation>{"parallel", BeadOrientation::parallel},
    Choice<BeadOrientation>{"perpendicular", BeadOrientation::perpendicular}};

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
