#pragma once

#include <cstdint>
#include <span>

#include "component/progress.hpp"
#include "contract/digest.hpp"
#include "contract/exchange.hpp"
#include "lattice_boltzmann/output/mean_field.hpp"
#include "ranks/box.hpp"

namespace copepod::fluid {

/// Sum modulo 2^64 of one digest per cell of `box`: seed is the cell's index in the domain, then its 19
/// populations. Adding the sums of all ranks gives the same number for every decomposition. Shows progress.
template <class T>
std::uint64_t digest_of_populations(const Cell& cells, const Box& box, std::span<const T> populations) {
  std::uint64_t sum = 0;
  std::size_t value = 0;
  for (std::int64_t x = box.low[0]; x < box.high[0]; ++x) {
    for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
      for (std::int64_t z = box.low[2]; z < box.high[2]; ++z) {
        Digest digest(static_cast<std::uint64_t>((x * cells[1] + y) * cells[2] + z));
        for (int alpha = 0; alpha < 19; ++alpha) digest.add(populations[value++]);
        sum += digest.value();
      }
    report_progress();
  }
  return sum;
}

/// The same for the sums of a mean field; 0 without samples.
std::uint64_t digest_of_mean(const Cell& cells, const MeanField& mean);

std::uint64_t digest_of_kinematics(const Kinematics& kinematics);

}  // namespace copepod::fluid
