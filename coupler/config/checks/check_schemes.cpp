#include <algorithm>
#include <array>
#include <iterator>
#include <span>

#include <spdlog/fmt/fmt.h>

#include "config/checks/checks.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {
namespace {

enum class Sphere { fixed, driven, heavy, light, lightest };  ///< not turning, turning; free, densities 2, 0.1, 0.01
constexpr std::array sphere_words{
    "the loads on a sphere", "the loads on a turning sphere", "the motion of a sphere of twice its density",
    "the motion of a sphere of a tenth of its density", "the motion of a sphere of a hundredth of its density"};

constexpr std::array radii{2.0, 4.0, 8.0};  // [cells]
constexpr std::array accuracy_percent{10.0, 5.0, 3.0};
constexpr double staircase = 2.4;  ///< so many times less accurate is bounce_back,
constexpr double noise = 2.0;      ///< and everything where hardly anything damps the noise of crossing cells
constexpr std::array relaxation_times{0.51, 0.55, 0.6, 0.667, 0.8, 1.0, 1.5, 2.0, 3.0};

/// Largest deviation from trt with parabolic boundaries, of any refill and precision [%]; 99: at least.
struct SchemeErrors {
  CollisionKind collision;
  MovingBoundary boundary;
  Sphere sphere;
  std::array<std::array<double, relaxation_times.size()>, radii.size()> percent;  ///< by radius, then relaxation time
};
constexpr std::array scheme_errors{
#include "config/checks/scheme_errors.inc"
};

/// Where a value lies between its two neighbours in a sorted table; the ends stand for all beyond them.
struct Between {
  std::size_t high;
  double part;
  Between(std::span<const double> sorted, double value) {
    const auto next = std::ranges::upper_bound(sorted, value) - sorted.begin();
    high = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(next, 1, std::ssize(sorted) - 1));
    part = std::clamp((value - sorted[high - 1]) / (sorted[high] - sorted[high - 1]), 0.0, 1.0);
  }
  [[nodiscard]] double of(std::span<const double> values) const {
    return std::lerp(values[high - 1], values[high], part);
  }
};

double error_percent(const SchemeErrors& errors, double radius_cells, double relaxation_time) {
  const Between time(relaxation_times, relaxation_time);
  std::array<double, radii.size()> by_radius{};
  std::ranges::transform(errors.percent, by_radius.begin(), [&](const auto& percent) { return time.of(percent); });
  return Between(radii, radius_cells).of(by_radius);
}

Sphere sphere_like(const BodySpecification& body, const Case& the_case) {
  if (!moves_under_loads(body)) return body.angular_velocity_rad_per_s.isZero() ? Sphere::fixed : Sphere::driven;
  const double ratio = mass_ratio(body, the_case.fluid);
  if (ratio >= virtual_mass_rule(body, the_case).needed_below) return Sphere::heavy;
  return ratio < 0.1 ? Sphere::lightest : Sphere::light;
}

}  // namespace

void check_schemes(const Case& the_case, const Assembly& assembly, Problems& problems) {
  if (!on_lattice(the_case)) return;
  const FluidCase& fluid = the_case.fluid;
  const double tau = relaxation_time(the_case);
  double worst = 1.0;
  std::string found;
  for (const BodySpecification& body : assembly.bodies) {
    const double radius_cells = body.shape.radius_m / fluid.cell_size_m;
    const double limit = Between(radii, radius_cells).of(accuracy_percent) *
                         (fluid.moving_boundary == MovingBoundary::bounce_back ? staircase : 1.0) *
                         (tau < 0.55 ? noise : 1.0);
    const Sphere sphere = sphere_like(body, the_case);
    for (const SchemeErrors& errors : scheme_errors) {
      if (errors.collision != fluid.collision || errors.boundary != fluid.moving_boundary || errors.sphere != sphere)
        continue;
      const double percent = error_percent(errors, radius_cells, tau);
      if (percent <= worst * limit) continue;
      worst = percent / limit;
      found = fmt::format("{:.0f} %{} error of {}, radius {:.3g} cells", percent, percent >= 99.0 ? " or more" : "",
                          sphere_words[static_cast<std::size_t>(sphere)], radius_cells);
    }
  }
  if (found.empty()) return;
  problems.warning(fluid.relaxation_time ? "fluid.relaxation_time" : "step_s",
                   fmt::format("relaxation_time {} (with collision {} and moving_boundary {}: {}). Use collision: trt "
                               "with moving_boundary: parabolic, another relaxation time, or smaller cells.",
                               rounded_text(tau), name_of(collision_names, fluid.collision),
                               name_of(moving_boundary_names, fluid.moving_boundary), found));
}

}  // namespace copepod::coupler
