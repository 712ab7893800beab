#pragma once

#include "files/stateless_fluid.hpp"

namespace copepod::fluid {

/// A fluid that is not there: zero loads on every body, no lattice [physics.md §6].
class Vacuum final : public StatelessFluid {
 public:
  Vacuum(const FluidSetup& setup, const Communicator& communicator) : StatelessFluid("vacuum", setup, communicator) {}

 private:
  void add_loads(const Kinematics&, Loads&) override {}
};

}  // namespace copepod::fluid
