#include "lattice_boltzmann/bodies/placed_shape.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

#include "lattice_boltzmann/bodies/lattice_body.hpp"
#include "ranks/block_partition.hpp"
#include "voxel_shape.hpp"

namespace copepod::fluid {
namespace {

using doubles::is_in_voxels, doubles::voxel_shape;

Shape ellipsoid(const Eigen::Vector3d& semi_axes) {
  return {.kind = ShapeKind::ellipsoid, .radius_m = std::cbrt(semi_axes.prod()), .extents_m = semi_axes};
}

Shape box(const Eigen::Vector3d& edges) { return {.kind = ShapeKind::box, .radius_m = 1.0, .extents_m = edges}; }

Shape compound(std::vector<ShapePart> parts) {
  return {.kind = ShapeKind::compound, .radius_m = 1.0, .parts = std::move(parts)};
}

/// A ball as the projection of the faces of a cube, each cut into n × n squares.
Shape ball_of_triangles(double radius, int n) {
  std::vector<std::array<int, 3>> cells;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) cells.push_back({x, y, z});
  Shape ball = voxel_shape(cells, 1.0, Eigen::Vector3d::Constant(0.5 * n));
  Eigen::Matrix3Xd vertices = ball.mesh->vertices_m;
  for (auto vertex : vertices.colwise()) vertex *= radius / vertex.norm();
  ball.mesh = std::make_shared<TriangleMesh>(vertices, ball.mesh->triangles);
  return ball;
}

/// A place of a body, and which cells it covers.
class Placed {
 public:
  Placed(const Shape& shape, const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation)
      : body(shape, 1.0), orientation_(orientation) {
    body.place(position, orientation);
    std::vector<RowCrossing> crossings;
    add_crossings(body, crossings);
    for (const RowCrossing& crossing : crossings) rows_[{crossing.x, crossing.y}][crossing.z] += crossing.step;
  }
  [[nodiscard]] bool covers(const Cell& cell) const {
    const auto row = rows_.find({cell[0], cell[1]});
    if (row == rows_.end()) return false;
    int depth = 0;
    for (const auto& [z, step] : row->second)
      if (z <= cell[2]) depth += step;
    return depth > 0;
  }
  [[nodiscard]] double entry_from(const Cell& cell, int direction) const {
    return entry(body, centre_of_cell(cell[0], cell[1], cell[2]) - body.position, direction);
  }
  [[nodiscard]] Eigen::Vector3d in_own_frame(const Cell& cell) const {
    return orientation_.conjugate() * (centre_of_cell(cell[0], cell[1], cell[2]) - body.position);
  }
  template <class Visit>
  void for_each_cell(const Visit& visit) const {
    const Eigen::AlignedBox3d bounds = body.bounds().translated(body.position);
    Cell low, high;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = static_cast<std::int64_t>(std::floor(bounds.min()[axis])) - 1;
      high[axis] = static_cast<std::int64_t>(std::floor(bounds.max()[axis])) + 1;
    }
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z) visit(Cell{x, y, z});
  }
  /// visit(cell, direction) for the links into the body.
  template <class Visit>
  void for_each_link(const Visit& visit) const {
    for_each_cell([&](const Cell& cell) {
      if (covers(cell)) return;
      for (int alpha = 1; alpha < d3q19::directions; ++alpha)
        if (covers(end_of(cell, alpha))) visit(cell, alpha);
    });
  }
  static Cell end_of(const Cell& cell, int alpha) {
    const auto& e = d3q19::e[static_cast<std::size_t>(alpha)];
    return {cell[0] + e[0], cell[1] + e[1], cell[2] + e[2]};
  }

  LatticeBody body;

 private:
  Eigen::Quaterniond orientation_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::map<std::int64_t, int>> rows_;
};

class Random {
 public:
  explicit Random(unsigned seed) : random_(seed) {}
  double operator()(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  int integer(int end) { return static_cast<int>(operator()(0.0, end)); }
  Eigen::Vector3d place() { return {operator()(-20.0, 20.0), operator()(-20.0, 20.0), operator()(-20.0, 20.0)}; }
  Eigen::Quaterniond orientation() {
    std::normal_distribution<double> normal;
    return Eigen::Quaterniond{normal(random_), normal(random_), normal(random_), normal(random_)}.normalized();
  }

 private:
  std::mt19937 random_;
};

/// A position by which a shape's vertices come to lie on cell centres, edges and corners, and a turn by quarters.
std::pair<Eigen::Vector3d, Eigen::Quaterniond> pose_with_ties(Random& random) {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    constexpr double half_root = std::numbers::sqrt2 / 2;
    const Eigen::Quaterniond quarter(half_root, axis == 0 ? half_root : 0.0, axis == 1 ? half_root : 0.0,
                                     axis == 2 ? half_root : 0.0);
    for (int times = random.integer(4); times > 0; --times) turn = turn * quarter;
  }
  return {0.5 * Eigen::Vector3d(random.integer(7) - 3, random.integer(7) - 3, random.integer(7) - 3), turn};
}

// Two arms at a right angle and a ring through which one can look: concave, with links that leave and enter again.
const std::vector<std::array<int, 3>> corner = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}};
const std::vector<std::array<int, 3>> ring = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0},
                                              {2, 1, 0}, {0, 2, 0}, {1, 2, 0}, {2, 2, 0}};

/// The body covers the cells inside, by a formula of their place in its own frame, unless they are within `margin` of
/// the surface.
void expect_cells_inside(const Placed& placed, const std::function<bool(const Eigen::Vector3d&)>& contains,
                         double margin) {
  placed.for_each_cell([&](const Cell& cell) {
    const Eigen::Vector3d p = placed.in_own_frame(cell);
    const bool inside = contains(p);
    for (int axis = 0; axis < 3; ++axis)
      for (const double shift : {-margin, margin})
        if (contains(p + shift * Eigen::Vector3d::Unit(axis)) != inside) return;
    ASSERT_EQ(placed.covers(cell), inside) << cell[0] << " " << cell[1] << " " << cell[2];
  });
}

/// Each link into the body meets the surface where the points of the link begin to be inside.
void expect_entries_where_inside_begins(const Placed& placed,
                                        const std::function<bool(const Eigen::Vector3d&)>& contains, double margin) {
  placed.for_each_link([&](const Cell& cell, int alpha) {
    const double q = placed.entry_from(cell, alpha);
    const Eigen::Vector3d from = placed.in_own_frame(cell);
    const Eigen::Vector3d way = placed.in_own_frame(Placed::end_of(cell, alpha)) - from;
    ASSERT_TRUE(contains(from + (q + margin) * way));
    for (const double before : {q - margin, 0.5 * q, 0.0}) ASSERT_FALSE(contains(from + before * way));
  });
}

/// Links into the body meet its surface, and both ways along a link agree on whether it does.
void expect_rows_and_links_to_agree(const Placed& placed) {
  placed.for_each_cell([&](const Cell& cell) {
    for (int alpha = 1; alpha < d3q19::directions; ++alpha) {
      const Cell end = Placed::end_of(cell, alpha);
      const double q = placed.entry_from(cell, alpha);
      const bool meets = std::isfinite(q);
      ASSERT_TRUE(!meets || (q >= 0.0 && q <= 1.0));
      const bool from = placed.covers(cell);
      const bool to = placed.covers(end);
      ASSERT_TRUE(meets || from || !to);
      ASSERT_TRUE(from != to || meets == std::isfinite(placed.entry_from(end, d3q19::opposite(alpha))));
    }
  });
}

TEST(PlacedMesh, CoversWhatIsInsideAndIsClosedToLinks) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const auto& cells = i % 2 == 0 ? corner : ring;
    const double size = random(0.3, 4.0);
    const Eigen::Vector3d centre(1.3, 1.2, 0.4);
    const Placed placed(voxel_shape(cells, size, centre), random.place(), random.orientation());
    SCOPED_TRACE(i);
    expect_cells_inside(
        placed, [&](const auto& p) { return is_in_voxels(cells, p / size + centre); }, 1e-5);
    expect_rows_and_links_to_agree(placed);
  }
}

TEST(PlacedMesh, IsClosedWhereVerticesAndEdgesLieOnCellCentres) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const auto [position, turn] = pose_with_ties(random);
    const double size = 1 + random.integer(3);
    SCOPED_TRACE(i);
    const Placed placed(voxel_shape(i % 2 == 0 ? corner : ring, size, {1.0, 0.5, 1.5}), position, turn);
    expect_rows_and_links_to_agree(placed);
    std::int64_t covered = 0;
    placed.for_each_cell([&](const Cell& cell) { covered += placed.covers(cell) ? 1 : 0; });
    EXPECT_EQ(static_cast<double>(covered), (i % 2 == 0 ? 5 : 8) * size * size * size);
  }
}

TEST(PlacedMesh, OfManyTrianglesIsNearlyABall) {
  Random random(3);
  const Shape sphere{ShapeKind::sphere, 5.2};
  double error_before = 0.0;
  for (const int n : {8, 16, 32}) {
    const Shape ball = ball_of_triangles(5.2, n);
    double largest = 0.0;
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector3d position = random.place();
      const Placed placed(ball, position, random.orientation());
      placed.for_each_link([&](const Cell& cell, int alpha) {
        const auto& e = d3q19::velocity[static_cast<std::size_t>(alpha)];
        const Eigen::Vector3d r = centre_of_cell(cell[0], cell[1], cell[2]) - position;
        const Eigen::Vector3d at = r + placed.entry_from(cell, alpha) * Eigen::Vector3d(e[0], e[1], e[2]);
        largest = std::max(largest, 5.2 - at.norm());
        ASSERT_LT(at.norm(), 5.2 + 2e-6);
      });
    }
    EXPECT_TRUE(n == 8 || std::abs(error_before / largest - 4.0) < 1.0) << error_before << " " << largest;
    error_before = largest;
  }
}

TEST(PlacedMesh, OverlappingPartsCountAsOne) {
  const Shape one = voxel_shape({{0, 0, 0}}, 5.0, {0.5, 0.5, 0.5});
  Eigen::Matrix3Xd vertices(3, 2 * one.mesh->vertices_m.cols());
  vertices << one.mesh->vertices_m, one.mesh->vertices_m.colwise() + Eigen::Vector3d(2.0, 1.0, 3.0);
  TriangleMesh::Triangles triangles(3, 2 * one.mesh->triangles.cols());
  triangles << one.mesh->triangles,
      one.mesh->triangles.array() + static_cast<std::int32_t>(one.mesh->vertices_m.cols());
  Shape both = one;
  both.mesh = std::make_shared<TriangleMesh>(vertices, triangles);
  const auto contains = [](const Eigen::Vector3d& p) {
    return p.cwiseAbs().maxCoeff() < 2.5 || (p - Eigen::Vector3d(2.0, 1.0, 3.0)).cwiseAbs().maxCoeff() < 2.5;
  };
  const Placed placed(both, {0.31, 0.42, 0.23}, Eigen::Quaterniond(0.36, 0.48, 0.64, 0.48));
  expect_cells_inside(placed, contains, 1e-5);
  expect_entries_where_inside_begins(placed, contains, 1e-5);
}

TEST(PlacedSolid, EllipsoidCoversWhatIsInsideAndIsMetOnItsSurface) {
  Random random(4);
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d axes{random(0.5, 6.0), random(0.5, 6.0), random(0.5, 6.0)};
    const Placed placed(ellipsoid(axes), random.place(), random.orientation());
    const auto radius = [&](const Eigen::Vector3d& p) { return p.cwiseQuotient(axes).norm(); };
    expect_cells_inside(
        placed, [&](const Eigen::Vector3d& p) { return radius(p) < 1.0; }, 1e-12);
    placed.for_each_link([&](const Cell& cell, int alpha) {
      const double q = placed.entry_from(cell, alpha);
      const Eigen::Vector3d from = placed.in_own_frame(cell);
      const Eigen::Vector3d to = placed.in_own_frame(Placed::end_of(cell, alpha));
      ASSERT_TRUE(q >= 0.0 && q <= 1.0);
      ASSERT_NEAR(radius(from + q * (to - from)), 1.0, 1e-13 * axes.cwiseInverse().maxCoeff() * 6.0);
    });
  }
}

TEST(PlacedSolid, CylinderCoversWhatIsInsideAndIsMetOnItsSurface) {
  Random random(5);
  for (int i = 0; i < 30; ++i) {
    const Shape shape{ShapeKind::cylinder, random(0.6, 5.0), random(0.8, 9.0)};
    const Placed placed(shape, random.place(), random.orientation());
    const auto beyond = [&](const Eigen::Vector3d& p) {
      return std::max(p.head<2>().norm() - shape.radius_m, std::abs(p[2]) - 0.5 * shape.length_m);
    };
    expect_cells_inside(
        placed, [&](const Eigen::Vector3d& p) { return beyond(p) < 0.0; }, 1e-12);
    placed.for_each_link([&](const Cell& cell, int alpha) {
      const double q = placed.entry_from(cell, alpha);
      const Eigen::Vector3d from = placed.in_own_frame(cell);
      const Eigen::Vector3d to = placed.in_own_frame(Placed::end_of(cell, alpha));
      ASSERT_TRUE(q >= 0.0 && q <= 1.0);
      ASSERT_NEAR(beyond(from + q * (to - from)), 0.0, 1e-13);
    });
  }
}

void expect_equal_cells(const Placed& a, const Placed& b) {
  a.for_each_cell([&](const Cell& cell) { ASSERT_EQ(a.covers(cell), b.covers(cell)); });
}

TEST(PlacedCompound, OfTwoBoxesIsABox) {
  Random random(6);
  const Shape whole = box({6.0, 3.0, 4.0});
  const Shape half = box({3.0, 3.0, 4.0});
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  const Shape two = compound({{half, {-1.5, 0.0, 0.0}, {1, 0, 0, 0}},
                              {box({3.0, 3.0, 4.0}), {1.5, 0.0, 0.0}, {quarter.w(), 0, 0, quarter.z()}}});
  for (int i = 0; i < 40; ++i) {
    const auto [position, turn] = i % 2 == 0 ? pose_with_ties(random) : std::pair{random.place(), random.orientation()};
    const Placed placed(two, position, turn);
    expect_equal_cells(Placed(whole, position, turn), placed);
    placed.for_each_link([&](const Cell& cell, int alpha) {
      const Eigen::Vector3d from = placed.in_own_frame(cell);
      const Eigen::Vector3d to = placed.in_own_frame(Placed::end_of(cell, alpha));
      const Eigen::Vector3d at = from + placed.entry_from(cell, alpha) * (to - from);
      // Vertices are rounded to 2⁻²⁰ of a cell; a link along the surface meets it far from where it would unrounded.
      ASSERT_NEAR((at.cwiseAbs() - 0.5 * whole.extents_m).maxCoeff(), 0.0, 4e-6);
    });
  }
}

TEST(PlacedCompound, OfOneSphereIsThatSphere) {
  Random random(7);
  const Shape sphere{ShapeKind::sphere, 3.3};
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d position = random.place();
    const Eigen::Quaterniond turn = random.orientation();
    const Placed alone(sphere, position, turn);
    const Placed part(compound({{sphere}}), position, turn);
    expect_equal_cells(alone, part);
    alone.for_each_link(
        [&](const Cell& cell, int alpha) { ASSERT_EQ(alone.entry_from(cell, alpha), part.entry_from(cell, alpha)); });
  }
}

TEST(PlacedCompound, OverlappingPartsAreEnteredOnce) {
  Random random(8);
  const Eigen::Vector3d axes(2.0, 3.0, 4.0);
  const Shape shape =
      compound({{ellipsoid(axes)}, {{ShapeKind::capsule, 1.5, 4.0}, {2.0, 0.0, 1.0}, {0.6, 0.8, 0, 0}}});
  const Eigen::Quaterniond turned(0.6, 0.8, 0.0, 0.0);
  const auto contains = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d r = turned.conjugate() * (p - Eigen::Vector3d(2.0, 0.0, 1.0));
    return p.cwiseQuotient(axes).norm() < 1.0 ||
           (r - std::clamp(r[2], -2.0, 2.0) * Eigen::Vector3d::UnitZ()).norm() < 1.5;
  };
  for (int i = 0; i < 20; ++i) {
    const Placed placed(shape, random.place(), random.orientation());
    expect_cells_inside(placed, contains, 1e-12);
    expect_entries_where_inside_begins(placed, contains, 1e-9);
  }
}

TEST(PlacedShape, StaysWhatItIsWhileItsPlaceDoes) {
  LatticeBody body(ellipsoid({1.0, 2.0, 3.0}), 1.0);
  body.place({1.0, 2.0, 3.0}, Eigen::Quaterniond::Identity());
  const LatticeBody before = body;
  body.place({1.0, 2.0, 3.0}, Eigen::Quaterniond::Identity());
  EXPECT_TRUE(body.is_turned_as(before));
  body.place({1.0, 2.0, 3.0}, Eigen::Quaterniond(0.6, 0.0, 0.0, 0.8));
  EXPECT_FALSE(body.is_turned_as(before));  // about its axis
}

}  // namespace
}  // namespace copepod::fluid
