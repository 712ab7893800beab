#pragma once

#include "engine/engine_body_solver.hpp"

namespace copepod::body {

/// The engine of the test program that the tests of all engines are linked into.
MakeEngineWorld engine_under_test();

inline EngineBodySolver engine_solver(const BodySetup& setup) {
  return EngineBodySolver("engine", engine_under_test(), setup);
}

}  // namespace copepod::body
