#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "lattice_boltzmann/bodies/placed_shape.hpp"
#include "lattice_boltzmann/lattice/d3q19.hpp"

namespace copepod::fluid {

namespace {

__extension__ using Wide = __int128;
template <class Number>
using Three = std::array<Number, 3>;
using Whole = Three<std::int64_t>;  ///< in 2⁻²⁰ cells, or cells, from the centre of the cell that holds the position

constexpr int fraction_bits = 20;
constexpr std::int64_t one_cell = std::int64_t{1} << fraction_bits;

std::int64_t floor_of_cells(std::int64_t coordinate) { return coordinate >> fraction_bits; }
std::int64_t ceiling_of_cells(std::int64_t coordinate) { return -(-coordinate >> fraction_bits); }

template <class Number>
int sign(Number value) {
  return (value > 0) - (value < 0);
}

/// Of a·δ for the displacement δ = (ε, ε², ε³).
template <class Number>
int sign_of_displacement(const Three<Number>& a) {
  return a[0] != 0 ? sign(a[0]) : a[1] != 0 ? sign(a[1]) : sign(a[2]);
}

Whole difference(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

template <class Number>
Three<Number> cross(const Whole& a, const Whole& b) {
  return {Number{a[1]} * b[2] - Number{a[2]} * b[1], Number{a[2]} * b[0] - Number{a[0]} * b[2],
          Number{a[0]} * b[1] - Number{a[1]} * b[0]};
}

/// The sight along a direction e: (u, v) of a point, so that e·(a × b) = u_a v_b − v_a u_b.
struct Sight {
  explicit constexpr Sight(int alpha)
      : direction(alpha),
        e{d3q19::e[alpha][0], d3q19::e[alpha][1], d3q19::e[alpha][2]},
        across(e[0] == 0   ? 0
               : e[1] == 0 ? 1
                           : 2) {}

  [[nodiscard]] constexpr std::int64_t u(const Whole& a) const { return e[i] * a[j] - e[j] * a[i]; }
  [[nodiscard]] constexpr std::int64_t v(const Whole& a) const { return a[across]; }
  /// The point with this u and v whose place along e is that of another.
  [[nodiscard]] Whole point(std::int64_t at_u, std::int64_t at_v, const Whole& beside) const {
    Whole a;
    a[across] = at_v;
    a[i] = e[i] != 0 ? beside[i] : -e[j] * at_u;
    a[j] = e[i] != 0 ? e[i] * (at_u + e[j] * beside[i]) : beside[j];
    return a;
  }

  int direction;
  Whole e;
  std::size_t across;
  std::size_t i = (across + 1) % 3;
  std::size_t j = (across + 2) % 3;
};

/// Rows and columns of cell centres, from the first to the last one in a range.
struct Centres {
  std::int64_t first = 0;
  std::int64_t last = 0;

  Centres(std::int64_t a, std::int64_t b, std::int64_t c)
      : first(ceiling_of_cells(std::min(a, std::min(b, c)))), last(floor_of_cells(std::max(a, std::max(b, c)))) {}
  [[nodiscard]] bool empty() const { return first > last; }
};

std::uint64_t number_of_link(const Whole& cell, int direction) {
  constexpr std::int64_t middle = std::int64_t{1} << 18;
  std::uint64_t number = 0;
  for (const std::int64_t index : cell) number = number << 19 | static_cast<std::uint64_t>(index + middle);
  return number << 5 | static_cast<std::uint64_t>(direction);
}

/// A closed mesh on the lattice. Its vertices are rounded to a grid of 2⁻²⁰ cells in which cell centres lie, and from
/// there on all decisions are exact: on which side of an edge a line of cell centres passes, and between which two of
/// them it meets a triangle. Centres on an edge or a triangle count as displaced by (ε, ε², ε³), ε → 0. So rows and
/// links of all directions agree on what is inside, and every link that leads in meets a triangle.
class PlacedMesh final : public PlacedShape {
 public:
  PlacedMesh(const TriangleMesh& mesh, const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation,
             double cell_m)
      : PlacedShape(position, orientation), cell_(position.array().floor()), offset_((position - cell_).array() - 0.5) {
    const Eigen::Matrix3d R = orientation.toRotationMatrix() / cell_m;
    std::vector<Whole> vertices;
    vertices.reserve(mesh.vertices_m.cols());
    for (const auto& vertex : mesh.vertices_m.colwise()) {
      const Eigen::Vector3d r = R * vertex;
      bounds_.extend(r);
      Whole& point = vertices.emplace_back();
      for (int axis = 0; axis < 3; ++axis) point[axis] = std::llround((r[axis] + offset_[axis]) * one_cell);
    }
    bounds_.min().array() -= 1.0 / one_cell;
    bounds_.max().array() += 1.0 / one_cell;
    std::vector<LinkEntry> entries;
    for (const auto& triangle : mesh.triangles.colwise()) {
      const auto corner = [&](int i) { return vertices[triangle[i]]; };
      const Triangle corners = {corner(0), corner(1), corner(2)};
      std::int64_t extent = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (const Whole& other : corners) extent = std::max(extent, std::abs(other[axis] - corners[0][axis]));
      if (extent < 256 * one_cell)
        find_entries<std::int64_t>(corners, entries);
      else
        find_entries<Wide>(corners, entries);
    }
    table_.resize(std::bit_ceil(2 * entries.size() + 1));
    for (const LinkEntry& entry : entries) {
      LinkEntry& known = table_[place_of(entry.link)];
      known = {entry.link, known.link == 0 ? entry.q : std::min(known.q, entry.q)};
    }
  }

  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return bounds_; }

  void add_crossings(std::vector<RowCrossing>& crossings) const override {
    crossings.insert(crossings.end(), rows_.begin(), rows_.end());
  }

  [[nodiscard]] double entry(const Eigen::Vector3d& r, int direction) const override {
    Whole cell;
    for (int axis = 0; axis < 3; ++axis) cell[axis] = std::llround(r[axis] + offset_[axis]);
    const LinkEntry& found = table_[place_of(number_of_link(cell, direction))];
    return found.link == 0 ? std::numeric_limits<double>::infinity() : found.q;
  }

 private:
  using Triangle = std::array<Whole, 3>;
  struct LinkEntry {
    std::uint64_t link = 0;  ///< cell and direction
    double q = 0.0;
  };

  /// A line p + t e passes through a triangle where it is on one side of all its edges, and from front to back, or from
  /// back to front, where t = N·(a − p)/N·e, N the normal with N·e > 0.
  template <class Number>
  void find_entries(const Triangle& corners, std::vector<LinkEntry>& entries) {
    const auto pass = [&](const Sight& sight, const Whole& us, const Whole& vs, std::int64_t u, std::int64_t v) {
      Number n_dot_e = 0;
      int sides = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = i < 2 ? i + 1 : 0;
        const Number turn = Number{us[i] - u} * (vs[next] - vs[i]) - Number{vs[i] - v} * (us[next] - us[i]);
        n_dot_e += turn;
        sides += turn != 0 ? sign(turn)
                           : sign_of_displacement(cross<std::int64_t>(sight.e, difference(corners[next], corners[i])));
      }
      if (sides != 3 && sides != -3) return;
      const bool enters = sides < 0;
      Three<Number> N = cross<Number>(difference(corners[1], corners[0]), difference(corners[2], corners[0]));
      if (enters)
        for (Number& component : N) component = -component;
      const Whole p =
          sight.point(u, v, {corners[0][0] & -one_cell, corners[0][1] & -one_cell, corners[0][2] & -one_cell});
      const int above = sign_of_displacement(N) > 0 ? 1 : 0;  // whether a centre on the triangle is
      const Wide rise = Wide{enters ? -n_dot_e : n_dot_e} * one_cell;
      Wide rest = -above;
      double quotient = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t away = corners[0][axis] - p[axis];
        rest += Wide{N[axis]} * away;
        quotient += static_cast<double>(N[axis]) * static_cast<double>(away);
      }
      const double whole = std::abs(static_cast<double>(n_dot_e)) * one_cell;
      auto steps = static_cast<std::int64_t>(std::floor(quotient / whole));
      rest -= steps * rise;  // what is rounded in the quotient is made good
      for (; rest < 0; rest += rise) --steps;
      for (; rest >= rise; rest -= rise) ++steps;
      Whole cell;  // the last centre before the triangle
      for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] = floor_of_cells(p[axis]) + steps * sight.e[axis];
      if (sight.direction == d3q19::index_of({0, 0, 1}))
        rows_.push_back({cell[0] + static_cast<std::int64_t>(cell_[0]), cell[1] + static_cast<std::int64_t>(cell_[1]),
                         cell[2] + 1 + static_cast<std::int64_t>(cell_[2]), enters ? 1 : -1});
      if (enters) {
        entries.push_back({number_of_link(cell, sight.direction), static_cast<double>(rest + above) / whole});
      } else {
        for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] += sight.e[axis];
        entries.push_back(
            {number_of_link(cell, d3q19::opposite(sight.direction)), static_cast<double>(rise - rest - above) / whole});
      }
    };
    const auto look_along = [&]<int direction>(std::integral_constant<int, direction>) {
      constexpr Sight sight(direction);
      const Whole us = {sight.u(corners[0]), sight.u(corners[1]), sight.u(corners[2])};
      const Whole vs = {sight.v(corners[0]), sight.v(corners[1]), sight.v(corners[2])};
      const Centres along_u(us[0], us[1], us[2]);
      const Centres along_v(vs[0], vs[1], vs[2]);
      if (along_u.empty() || along_v.empty()) return;
      for (std::int64_t u = along_u.first; u <= along_u.last; ++u)
        for (std::int64_t v = along_v.first; v <= along_v.last; ++v) pass(sight, us, vs, u * one_cell, v * one_cell);
    };
    [&]<int... n>(std::integer_sequence<int, n...>) { (look_along(std::integral_constant<int, 2 * n + 1>()), ...); }
    (std::make_integer_sequence<int, 9>());
  }

  /// Where in `table_` a link is, or belongs: links of cells that follow each other in a row are near each other.
  [[nodiscard]] std::size_t place_of(std::uint64_t link) const {
    const std::size_t mask = table_.size() - 1;
    const std::uint64_t in_row = link & ((std::uint64_t{1} << 24) - 1);
    const std::uint64_t row = link >> 24;
    std::size_t place = static_cast<std::size_t>(((row * 0x9e3779b97f4a7c15U) >> 32) + in_row) & mask;
    while (table_[place].link != 0 && table_[place].link != link) place = (place + 1) & mask;
    return place;
  }

  Eigen::Vector3d cell_;    ///< that holds the position
  Eigen::Vector3d offset_;  ///< of the position, from that cell's centre
  Eigen::AlignedBox3d bounds_;
  std::vector<RowCrossing> rows_;  ///< as add_crossings has them
  std::vector<LinkEntry> table_;   ///< by a hash of the link, or behind that; link 0: free
};

}  // namespace

std::shared_ptr<const PlacedShape> place(const TriangleMesh& mesh, const Eigen::Vector3d& position,
                                         const Eigen::Quaterniond& orientation, double cell_m) {
  return std::make_shared<PlacedMesh>(mesh, position, orientation, cell_m);
}

}  // namespace copepod::fluid
