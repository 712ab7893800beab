#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/shape.hpp"
#include "geometry/neighbour_grid.hpp"

namespace copepod {

/// Bodies that have a joint with each other, which may overlap: ascending, each with the lower body first.
std::vector<BodyPair> jointed_pairs(const std::vector<JointSpecification>& joints);

/// The pairs of bodies that are near each other.
///
/// Pairs are looked up in a grid only when a body has moved by more than a margin since the last time; in
/// between the list still holds every pair that is near.
class NearPairs {
 public:
  /// @param reach_m            between surfaces: how far apart bodies may be to count as near
  /// @param periodic_length_m  0: that direction is not periodic
  /// @param except             pairs that are never listed: ascending, each with the lower body first
  NearPairs(const std::vector<Shape>& shapes, double reach_m, const std::array<double, 3>& periodic_length_m,
            std::vector<BodyPair> except = {});

  /// Every pair of bodies whose bounding balls are less than the reach apart, nearest periodic images taken, and a
  /// few that are further apart. Ascending: bodies that are neighbours in the setup are neighbours in memory.
  /// @param position_m  finite, shape (3, bodies)
  const std::vector<BodyPair>& at(const Eigen::Matrix3Xd& position_m) {
    if (!hold(position_m, 0, margin_m_.size())) list(position_m);
    return pairs_;
  }

  /// The same for callers that share the test of all bodies among threads: the pairs listed last, which hold unless one
  /// of the bodies has moved beyond its margin.
  [[nodiscard]] const std::vector<BodyPair>& listed() const { return pairs_; }
  /// Whether they do, as far as the bodies in [first, last) are concerned.
  [[nodiscard]] bool hold(const Eigen::Matrix3Xd& position_m, std::size_t first, std::size_t last) const;
  void list(const Eigen::Matrix3Xd& position_m);  ///< lists the pairs anew

  /// How often pairs have been listed: the list is the same while this is.
  [[nodiscard]] std::uint64_t listing() const { return listing_; }

  /// Bodies that are longer than the periodic box and may meet their own image.
  [[nodiscard]] const std::vector<int>& longer_than_the_box() const { return longer_than_the_box_; }

  /// Where the bodies of a pair meet.
  [[nodiscard]] const PeriodicImages& images() const { return grid_.images(); }

 private:
  std::vector<double> margin_m_;  ///< by which a body may move before the pairs are listed anew
  NeighbourGrid grid_;
  std::vector<BodyPair> found_;  ///< in the order of the grid
  std::vector<BodyPair> pairs_;
  std::vector<BodyPair> except_;  ///< lower body first, ascending
  std::uint64_t listing_ = 0;
  std::vector<int> longer_than_the_box_;
  Eigen::Matrix3Xd listed_position_m_;  ///< when the pairs were listed; no columns: never
};

}  // namespace copepod
