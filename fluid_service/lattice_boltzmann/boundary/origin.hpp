#pragma once

#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

namespace copepod::fluid {

/// Where populations enter the cells on the faces of a block from: another rank's come from ghost cells, at
/// periodic faces from the other end, at mirrors from the cell's own plane, at walls and pressure faces from
/// the cell itself. What a moving wall adds and a pressure face exchanges is left to GhostExchange.
OriginRule origin_rule(const Domain& domain, const Box& block);

}  // namespace copepod::fluid
