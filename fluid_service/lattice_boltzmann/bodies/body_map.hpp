#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lattice_boltzmann/bodies/lattice_body.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/huge_array.hpp"

namespace copepod::fluid {

/// Which cells of a block and its ghost layer are covered by which body: a cell belongs to a body if its
/// centre lies inside [paper, section 2.3], and where bodies overlap to the first of them. So the owners follow from
/// the present places alone; what is kept between updates only saves time.
///
/// A body is kept as intervals of cells, one per row or, of placed shapes, any number; from step to step only their
/// ends differ, so that an update touches only cells that change. For a sphere it costs a square root per row, and is
/// left out until the surface can have reached the next cell centre.
class BodyMap {
 public:
  static constexpr std::int32_t fluid = 0;
  static constexpr std::int32_t fresh = -1;  ///< uncovered in this step, populations not yet refilled

  /// A cell of the block or its ghost layer, in 16 bytes: at first there is one for each cell that bodies cover.
  struct ChangedCell {
    ChangedCell(const Cell& cell, std::int32_t of_body)
        : indices{static_cast<std::int32_t>(cell[0]), static_cast<std::int32_t>(cell[1]),
                  static_cast<std::int32_t>(cell[2])},
          body(of_body) {}

    std::array<std::int32_t, 3> indices;  ///< in the domain
    std::int32_t body;                    ///< index of the body that covers or covered it

    [[nodiscard]] Cell cell() const { return {indices[0], indices[1], indices[2]}; }
    bool operator==(const ChangedCell&) const = default;
  };

  /// @param obstacles  the last ones of `bodies`: they may reach beyond the faces, and no other may meet them
  BodyMap(const Domain& domain, const PopulationLayout& layout, std::vector<LatticeBody> bodies,
          std::vector<std::string> obstacles = {});

  /// Maps bodies at their present positions; call after changing `bodies()`.
  /// @param bodies  ascending: all that cover cells of the block or its ghosts, or did in the last update
  /// @return whether any cell of the block or its ghosts changed hands
  /// Bodies wholly beyond an outflow that removes them cover no cells.
  /// @throws SolverError if a centre left the domain through a face that is not periodic, a moving body runs into one,
  /// or a body meets an obstacle: has a cell in common with it. Bodies at rest may intersect a wall from the start.
  bool update(std::span<const std::int32_t> bodies);
  /// Turns fresh cells into fluid ones.
  void accept_fresh_cells();

  [[nodiscard]] const Domain& domain() const { return domain_; }
  [[nodiscard]] std::vector<LatticeBody>& bodies() { return bodies_; }
  [[nodiscard]] const std::vector<LatticeBody>& bodies() const { return bodies_; }
  [[nodiscard]] bool is_obstacle(std::int32_t body) const {
    return body >= static_cast<std::int32_t>(bodies_.size() - obstacles_.size());
  }
  /// 0 fluid, 1 + body index, or `fresh`; beyond walls 0.
  [[nodiscard]] std::int32_t owner(std::int64_t cell) const { return owner_[cell]; }
  [[nodiscard]] const std::vector<ChangedCell>& uncovered() const { return uncovered_; }
  /// Cells that a body took from the fluid in the last update; none in the first one, which displaces no fluid.
  [[nodiscard]] const std::vector<ChangedCell>& covered() const { return covered_; }
  /// Cells that a body lost or took in the last update.
  [[nodiscard]] const std::vector<ChangedCell>& changed() const { return changed_; }

 private:
  /// How far a sphere may move with the same rows: in any direction, and along its velocity, of which it may deviate by
  /// a part of its way. Cells whose centres are nearly in the plane normal to the velocity do not limit the latter.
  struct FreeWay {
    static constexpr double deviation = 1.0 / 256.0;

    double anywhere = 0.0;
    double ahead = 0.0;
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();

    [[nodiscard]] bool contains(const Eigen::Vector3d& way) const {
      const double length = way.norm();
      return length <= anywhere ||
             (length <= ahead && (way - way.dot(direction) * direction).norm() <= deviation * length);
    }
  };

  /// Rows of one body, around its centre, in cells counted without wrapping.
  struct Footprint {
    LatticeBody state;  ///< when the rows were made
    FreeWay free_way;
    std::int64_t x = 0;  ///< of the first row
    std::int64_t y = 0;
    std::int64_t lines = 0;             ///< rows along x
    std::int64_t width = 0;             ///< rows along y; 0: never mapped
    std::vector<RowInterval> rows;      ///< shape (x, y), or those of one row after those of another
    std::vector<std::uint32_t> starts;  ///< of each row in `rows`, and the end; none: there is one interval per row

    [[nodiscard]] std::span<const RowInterval> row(std::size_t number) const {
      if (starts.empty()) return {&rows[number], 1};
      return std::span(rows).subspan(starts[number], starts[number + 1] - starts[number]);
    }
    [[nodiscard]] std::span<const RowInterval> row(std::int64_t at_x, std::int64_t at_y) const {
      const std::int64_t i = at_x - x;
      const std::int64_t j = at_y - y;
      if (j < 0 || j >= width || i < 0 || i >= lines) return {};
      return row(i * width + j);
    }
    void set_rows(const std::vector<RowCrossing>& crossings);
    [[nodiscard]] Footprint without_cells(const LatticeBody& body) const;
  };

  [[nodiscard]] static Footprint footprint(const LatticeBody& body);
  [[nodiscard]] static FreeWay free_way(const Footprint& sphere);
  [[nodiscard]] bool near_block(const LatticeBody& body) const;
  void compare(const Footprint& before, const Footprint& after, std::int32_t body);
  void compare_rows(std::span<const RowInterval> before, std::span<const RowInterval> after, Cell row,
                    std::int32_t body);
  /// visit(cell) for every cell of the block and its ghosts that `unwrapped` stands for.
  template <class Visit>
  void for_each_image(const Cell& unwrapped, const Visit& visit) const;
  void give_up(const Cell& cell, std::int32_t body);
  void hand_over();
  void check_apart(std::int32_t body, std::int32_t other) const;
  /// Whether it is wholly beyond a face that removes bodies.
  [[nodiscard]] bool is_removed(const LatticeBody& body) const;
  void check_inside(const LatticeBody& body, std::size_t index) const;
  void check_clear_of_faces(const LatticeBody& body, std::size_t index) const;
  /// How far the body's surface is beyond a face.
  [[nodiscard]] double beyond(const LatticeBody& body, int axis, bool high) const;

  const Domain& domain_;
  const PopulationLayout& layout_;
  std::vector<LatticeBody> bodies_;
  std::vector<std::string> obstacles_;
  std::vector<Footprint> mapped_;
  HugeVector<std::int32_t> owner_;
  std::vector<ChangedCell> uncovered_;
  bool has_started_ = false;  ///< bodies that changed their place since then move
  /// Cells with the bodies that cover them beside the owner: the owner itself where two of its images do.
  std::multiset<std::pair<std::int64_t, std::int32_t>> behind_;
  std::vector<ChangedCell> changed_;
  std::vector<ChangedCell> given_up_;  ///< by their owners, in this update
  std::vector<ChangedCell> claimed_;   ///< by bodies that have come to cover them, in this update
  std::vector<ChangedCell> covered_;
};

}  // namespace copepod::fluid
