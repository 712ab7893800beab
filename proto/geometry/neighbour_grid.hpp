#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "contract/shape.hpp"
#include "geometry/periodic_images.hpp"

namespace copepod {

/// Finds all pairs of balls that intersect, in time linear in their number.
///
/// Balls are sorted by size into levels, each with radii within a factor of two and with a grid of cells,
/// hashed, that are as wide as its largest balls; a ball looks for partners in the 27 cells around it on its
/// own and every coarser level. So a few large balls among many small ones cost little.
class NeighbourGrid {
 public:
  /// @param radius_m           of every ball, positive
  /// @param periodic_length_m  0: that direction is not periodic
  NeighbourGrid(std::vector<double> radius_m, const std::array<double, 3>& periodic_length_m);

  /// @param centre_m  finite, inside or outside the periodic box, shape (3, balls)
  /// @param pairs     overwritten with every pair whose nearest periodic images intersect, each once; their
  ///                  order depends on positions and indices only
  void find_pairs(const Eigen::Matrix3Xd& centre_m, std::vector<BodyPair>& pairs);

  [[nodiscard]] const PeriodicImages& images() const { return images_; }  ///< of the periodic box

 private:
  using Cell = std::array<std::int64_t, 3>;

  struct Level {
    std::vector<int> balls;
    Eigen::Vector3d cell_width_m;
    Cell cells{};  ///< per direction; 0: not periodic, unlimited
    std::vector<std::uint32_t> bucket_start;
    std::vector<std::pair<Cell, int>> entries;  ///< (cell, ball), bucket by bucket
  };

  void add_level(std::vector<int> balls, double largest_radius_m);
  void sort_into_cells(Level& level, const Eigen::Matrix3Xd& centre_m);
  void add_partners(int ball, const Level& level, bool own_level, const Eigen::Matrix3Xd& centre_m,
                    std::vector<BodyPair>& pairs) const;
  [[nodiscard]] Cell cell_of(const Level& level, const Eigen::Vector3d& point_m) const;

  std::vector<double> radius_m_;
  PeriodicImages images_;
  std::vector<Level> levels_;  ///< from fine to coarse
  std::vector<Cell> cell_of_ball_;
  std::vector<std::uint32_t> bucket_of_ball_;
};

}  // namespace copepod
