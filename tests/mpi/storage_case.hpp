#pragma once

#include <array>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/output/fields.hpp"
#include "ranks/block_partition.hpp"
#include "ranks/mpi_communicator.hpp"

namespace copepod::fluid {

/// A folder that all ranks share and rank 0 removes at the end.
class SharedFolder {
 public:
  explicit SharedFolder(Communicator& ranks) : ranks_(ranks) {
    if (ranks.rank() == 0) {
      const std::string pattern = (std::filesystem::temp_directory_path() / "copepod_storage_XXXXXX").string();
      pattern.copy(name_.data(), name_.size() - 1);
      if (mkdtemp(name_.data()) == nullptr) std::abort();
    }
    ranks.broadcast(std::as_writable_bytes(std::span(name_)));
  }
  SharedFolder(const SharedFolder&) = delete;
  SharedFolder& operator=(const SharedFolder&) = delete;
  ~SharedFolder() {
    if (std::getenv("COPEPOD_KEEP_TEST_FOLDERS") != nullptr) return;
    barrier();
    if (ranks_.rank() == 0) std::filesystem::remove_all(name_.data());
  }
  [[nodiscard]] std::string path() const { return name_.data(); }
  /// Until all ranks are here.
  void barrier() {
    std::array<std::int64_t, 1> one = {1};
    ranks_.sum_to_all(one);
  }

 private:
  Communicator& ranks_;
  std::array<char, 256> name_{};
};

/// Values that depend on the cell only: density 1000 + index, velocity (x, y, z) + 1/2, body x % 2.
inline FieldBlock numbered_fields(const Box& box) {
  FieldBlock block;
  block.box = box;
  for (std::int64_t x = box.low[0]; x < box.high[0]; ++x)
    for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
      for (std::int64_t z = box.low[2]; z < box.high[2]; ++z) {
        const std::array<double, 3> velocity = {static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5,
                                                static_cast<double>(z) + 0.5};
        block.density_kg_per_m3.push_back(1000.0 + static_cast<double>(10000 * x + 100 * y + z));
        block.velocity_m_per_s.insert(block.velocity_m_per_s.end(), velocity.begin(), velocity.end());
        block.body.push_back(static_cast<std::int32_t>(x % 2));
      }
  return block;
}

}  // namespace copepod::fluid
