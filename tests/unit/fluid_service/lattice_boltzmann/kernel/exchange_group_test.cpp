#include "lattice_boltzmann/kernel/exchange_group.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "lattice_boltzmann/bodies/lattice_body.hpp"

namespace copepod::fluid {
namespace {

template <class T>
class ExchangeGroups : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ExchangeGroups, Precisions);

TYPED_TEST(ExchangeGroups, HaveTheSameBitsWithEveryInstructionSet) {
  using T = TypeParam;
  CellGroup group;
  group.links = 3;
  group.used = 7;
  BoundaryValues<T> with_second_cells;
  BoundaryValues<T> without;
  constexpr std::size_t head = d3q19::directions;
  constexpr std::size_t large = head + 3 * surface_lanes;
  constexpr std::size_t links = large + 3;
  for (BoundaryValues<T>* const values : {&without, &with_second_cells}) {
    const bool second_cells = values == &with_second_cells;
    values->by_link.resize(links * values->per_link(second_cells));
    values->by_cell.resize((1 + surface_lanes) * values->per_cell(second_cells));
    if (!second_cells) values->by_link[large] = T(0.2);
    for (std::size_t lane = 0; lane < 7; ++lane) {
      const auto x = static_cast<double>(lane);
      const std::size_t place = (3 * lane) % 7;
      group.moments[lane] = static_cast<std::uint32_t>(1 + place);
      group.first_link[lane] = static_cast<std::uint32_t>(head + 3 * place);
      group.directions[lane] = (1U << (1 + lane)) | (1U << (9 + lane)) | (1U << 17);
      group.second_cells[lane] = group.directions[lane];
      double* const of_cell = values->by_cell.data() + values->per_cell(second_cells) * group.moments[lane];
      of_cell[values->excess_density] = 0.001 * std::cos(x);
      for (std::size_t axis = 0; axis < 3 && second_cells; ++axis)
        of_cell[values->momentum + axis] = 0.01 * std::sin(x + static_cast<double>(axis));
      for (std::size_t j = 0; j < 3; ++j) {
        const double y = x + 10.0 * static_cast<double>(j);
        T* const of_link = values->by_link.data() + values->per_link(second_cells) * (group.first_link[lane] + j);
        of_link[values->crossing] = static_cast<T>(0.01 * std::sin(y));
        if (!second_cells) continue;
        of_link[values->inward] = static_cast<T>(0.01 * std::cos(y));
        of_link[values->behind] = static_cast<T>(0.01 * std::sin(2.0 * y));
      }
    }
  }
  std::iota(group.cell[0].begin(), group.cell[0].end(), 2);
  group.cell[1].fill(5);
  group.cell[2].fill(4);
  BodyInBlock sphere;
  for (int axis = 0; axis < 3; ++axis) {
    sphere.first_cell[axis] = 0.5;
    sphere.position[axis] = 5.1 - axis;
    sphere.velocity[axis] = 0.01 * (1 + axis);
    sphere.angular_velocity[axis] = 0.003 * (2 - axis);
  }
  sphere.radius = 2.3;
  sphere.returned = 1e-4;
  FilmsBeside films{.cell_m = 2.0, .low_m = 1.0, .high_m = 9.0};
  sphere.films = &films;
  CellGroup one_by_one = group;  // its second cells are not fluid, or populations too large
  one_by_one.second_cells.fill(0);
  one_by_one.first_link.fill(large);
  std::array<const CellGroup*, 2 + 2 * groups_ahead> groups{};
  groups.fill(&one_by_one);
  groups[0] = &group;
  const auto outcome = [&](const auto& exchange, const auto& formula) {
    const bool second_cells = formula.uses_second_cell;
    BoundaryValues<T> values = second_cells ? with_second_cells : without;
    LaneSums sums;
    for (FilmBeside& film : films.surfaces) film.sums = {};
    EXPECT_EQ(exchange(formula, sphere, groups.data(), 2, values, sums), 1);
    const auto end_of_head = values.by_link.begin() + static_cast<std::ptrdiff_t>(head * values.per_link(second_cells));
    EXPECT_EQ(std::count(values.by_link.begin(), end_of_head, T(0)),
              end_of_head - values.by_link.begin());  // free lane
    std::vector<std::array<Lanes<std::int64_t>, FilmBeside::components>> on_others;
    for (const FilmBeside& film : films.surfaces) on_others.push_back(film.sums);
    return std::tuple(values.by_link, sums.sums, on_others);
  };
  const auto all = [&](const fluid::ExchangeGroups<T>& groups) {
    const auto constants = collision_constants<T>(CollisionKind::trt, 0.6, Eigen::Vector3d(1e-5, 2e-5, 0.0));
    return std::tuple(outcome(std::get<0>(groups), BounceBack()), outcome(std::get<1>(groups), Interpolated()),
                      outcome(std::get<2>(groups), CentralLinear()),
                      outcome(std::get<3>(groups), Parabolic(constants)));
  };
  auto expected = all(baseline_kernels<T>().exchange_groups);
  EXPECT_NE(std::get<0>(expected), std::get<3>(expected));
  const auto expect_the_same_of_all = [&] {
    for (const Kernels<T>& kernels : {baseline_kernels<T>(), avx2_kernels<T>(), avx512_kernels<T>()}) {
      if (!kernels.stream_collide) continue;
      EXPECT_EQ(all(kernels.exchange_groups), expected) << kernels.instruction_set;
    }
  };
  expect_the_same_of_all();
  constexpr double z[] = {0.0, 0.0, 1.0}, back[] = {-1.0, 0.0, 0.0}, centre_m[] = {8.0, 9.0, 1.0},
                   half_m[] = {0.0, 0.5, 2.0}, x[] = {1.0, 0.0, 0.0}, other_centre_m[] = {-6.0, 2.0, 3.0},
                   inverse_per_m2[] = {0.1, 0.01, -0.02, 0.01, 0.2, 0.01, -0.02, 0.01, 0.3};
  films.surfaces = {
      {.normal = z, .distance_of_centre_m = 1.0, .far_m = 9.0},  // a wall, a capsule and an ellipsoid
      {.other = 0,
       .centre_m = centre_m,
       .half_m = half_m,
       .radius_m = 2.0,
       .normal = back,
       .distance_of_centre_m = -4.0,
       .far_m = 9.0},
      {.other = 1, .centre_m = other_centre_m, .inverse_per_m2 = inverse_per_m2, .normal = x, .far_m = 9.0}};
  const auto without_films = std::exchange(expected, all(baseline_kernels<T>().exchange_groups));
  EXPECT_EQ(std::get<0>(std::get<3>(without_films)), std::get<0>(std::get<3>(expected))) << "the flow is the same";
  EXPECT_NE(std::get<1>(std::get<0>(without_films)), std::get<1>(std::get<0>(expected)));
  for (const FilmBeside& film : films.surfaces) EXPECT_EQ(film.sums != decltype(film.sums){}, film.other >= 0);
  expect_the_same_of_all();
  constexpr double far_m[] = {8.0e3, 9.0, 1.0};  // about which the torques of these forces are too large
  films.surfaces[1].centre_m = far_m;
  films.surfaces[1].radius_m = 8.1e3;
  LaneSums sums;
  BoundaryValues<T> values = without;
  EXPECT_EQ(std::get<0>(baseline_kernels<T>().exchange_groups)({}, sphere, groups.data(), 2, values, sums), 0);
  films.surfaces.clear();
  expected = without_films;
  // As another body, whose surface happens to be where that of the sphere or ellipsoid is.
  std::vector<double> distances(2 * BodyInBlock::distances_per_group, 1.0);
  const auto expect_the_same_with_distances = [&](std::ptrdiff_t crossing, const auto& entry) {
    for (std::size_t lane = 0; lane < 7; ++lane) {
      Eigen::Vector3d r;
      for (std::size_t axis = 0; axis < 3; ++axis) r[axis] = group.cell[axis][lane] + 0.5 - sphere.position[axis];
      double* distance = distances.data() + lane;
      for (std::uint32_t bits = group.directions[lane]; bits != 0; bits &= bits - 1, distance += surface_lanes) {
        const auto& e = d3q19::velocity[static_cast<std::size_t>(std::countr_zero(bits))];
        *distance = std::min(entry(r, Eigen::Vector3d(e[0], e[1], e[2])), 1.0);
      }
    }
    EXPECT_EQ(std::ssize(distances) - std::ranges::count(distances, 1.0), crossing);
    sphere.wall_distances = distances.data();
    expect_the_same_of_all();
    distances[surface_lanes + 3] *= 0.5;
    EXPECT_NE(all(baseline_kernels<T>().exchange_groups), expected);
    sphere.wall_distances = nullptr;
  };
  expect_the_same_with_distances(1,
                                 [&](const auto& r, const auto& e) { return entry_into_sphere(r, e, sphere.radius); });
  const Eigen::Matrix3d form{{0.03, 0.01, -0.01}, {0.01, 0.3, -0.05}, {-0.01, -0.05, 0.4}};
  sphere.form = form.data();
  const auto of_sphere = std::exchange(expected, all(baseline_kernels<T>().exchange_groups));
  EXPECT_NE(std::get<3>(of_sphere), std::get<3>(expected));
  expect_the_same_of_all();
  expect_the_same_with_distances(5, [&](const auto& r, const auto& e) { return entry_into_ellipsoid(form, r, e); });
}

TEST(Film, IsTheThinnestWhereALinkCrossesTheSurface) {
  constexpr double up[] = {0.0, 0.0, 1.0};
  FilmsBeside films{.cell_m = 2.0, .low_m = 1.0, .high_m = 9.0};
  films.surfaces = {{.normal = up, .distance_of_centre_m = 10.0, .far_m = 9.0},
                    {.other = 3, .normal = up, .distance_of_centre_m = 8.0, .far_m = 9.0}};
  const std::array down = {0.0, 1.0, -1.0};
  const Film<double> film(films, {0.0, 0.0, -1.0}, 0.25, down);  // at z = −2.5 m
  EXPECT_EQ(film.number, 1);
  EXPECT_DOUBLE_EQ(film.resolved, (5.5 - 1.0) / 8.0);
  const Film<double> none(films, {0.0, 0.0, 2.0}, 0.25, down);  // at z = 3.5 m
  EXPECT_EQ(none.number, -1);
  EXPECT_EQ(none.resolved, 1.0);
}

}  // namespace
}  // namespace copepod::fluid
