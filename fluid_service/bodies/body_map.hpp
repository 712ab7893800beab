#pragma once

#include <cstdint>
#include <vector>

#include "bodies/lattice_body.hpp"
#include "boundary/domain.hpp"
#include "lattice/population_layout.hpp"

namespace copepod::fluid {

/// Which cells of a block and its ghost layer are covered by which body: a cell belongs to a body if its
/// centre lies inside [paper, section 2.3]. Updated incrementally: a body is looked at again only when it has
/// moved further than the cell centre nearest to its surface was away from it.
class BodyMap {
 public:
  static constexpr std::int32_t fluid = 0;
  static constexpr std::int32_t fresh = -1;  ///< uncovered in this step, populations not yet refilled

  struct ChangedCell {
    Cell cell{};
    std::int32_t body = 0;  ///< index of the body that covers or covered it
  };

  BodyMap(const Domain& domain, const PopulationLayout& layout, std::vector<LatticeBody> bodies);

  /// Maps the bodies at their present positions; call after changing `bodies()`.
  /// @return whether any cell of the block or its ghosts changed hands
  /// @throws SolverError if a centre left the domain through a face that is not periodic
  bool update();
  /// Turns fresh cells into fluid ones.
  void accept_fresh_cells();

  [[nodiscard]] std::vector<LatticeBody>& bodies() { return bodies_; }
  [[nodiscard]] const std::vector<LatticeBody>& bodies() const { return bodies_; }
  /// 0 fluid, 1 + body index, or `fresh`; beyond walls 0.
  [[nodiscard]] std::int32_t owner(std::int64_t cell) const { return owner_[static_cast<std::size_t>(cell)]; }
  [[nodiscard]] const std::vector<ChangedCell>& uncovered() const { return uncovered_; }
  /// Boxes, in domain cells, around every cell that changed in the last update; one box per changed body and
  /// image.
  [[nodiscard]] const std::vector<Box>& changed() const { return changed_; }
  /// Boxes of block and ghost cells that body b and its images can cover, with a margin of one cell.
  [[nodiscard]] std::vector<Box> reach(const LatticeBody& body) const;

 private:
  struct Mapped {
    LatticeBody state;
    double slack = -1.0;  ///< distance that the surface may move before any cell can change; −1: never mapped
  };

  [[nodiscard]] double moved(const LatticeBody& from, const LatticeBody& to) const;
  void map_box(std::int32_t body, const Box& box, double& slack, bool& any);
  void cover_cells();
  void check_inside(const LatticeBody& body, std::size_t index) const;

  const Domain& domain_;
  const PopulationLayout& layout_;
  std::vector<LatticeBody> bodies_;
  std::vector<Mapped> mapped_;
  std::vector<std::int32_t> owner_;
  std::vector<ChangedCell> uncovered_;
  std::vector<ChangedCell> covered_;  ///< taken when every body has given up its cells
  std::vector<Box> changed_;
};

}  // namespace copepod::fluid
