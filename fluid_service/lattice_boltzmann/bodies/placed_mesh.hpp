#pragma once

#include <array>

#include "lattice_boltzmann/bodies/placed_shape.hpp"

namespace copepod::fluid {

/// A closed mesh on the lattice. Its vertices are rounded to a grid of 2⁻²⁰ cells in which cell centres lie, and from
/// there on all decisions are exact: on which side of an edge a line of cell centres passes, and between which two of
/// them it meets a triangle. Centres on an edge or a triangle count as displaced by (ε, ε², ε³), ε → 0. So rows and
/// links of all directions agree on what is inside, and every link that leads in meets a triangle.
class PlacedMesh final : public PlacedShape {
 public:
  PlacedMesh(const TriangleMesh& mesh, const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation,
             double cell_m);

  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return bounds_; }
  void add_crossings(std::vector<RowCrossing>& crossings) const override;
  [[nodiscard]] double entry(const Eigen::Vector3d& r, int direction) const override;

 private:
  using Point = std::array<std::int64_t, 3>;  ///< in 2⁻²⁰ cells, or cells, from the centre of the position's cell
  using Triangle = std::array<Point, 3>;
  struct LinkEntry {
    std::uint64_t link = 0;  ///< cell and direction
    double q = 0.0;
  };

  template <class Number>
  void find_entries(const Triangle& corners, std::vector<LinkEntry>& entries);
  /// Where in `table_` a link is, or belongs.
  [[nodiscard]] std::size_t place_of(std::uint64_t link) const;

  Eigen::Vector3d cell_;    ///< that holds the position
  Eigen::Vector3d offset_;  ///< of the position, from that cell's centre
  Eigen::AlignedBox3d bounds_;
  std::vector<RowCrossing> rows_;  ///< as add_crossings has them
  std::vector<LinkEntry> table_;   ///< by a hash of the link, or behind that; link 0: free
};

}  // namespace copepod::fluid
