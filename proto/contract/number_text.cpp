#include "contract/number_text.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace copepod {

std::string rounded_text(double number) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4g", number);
  return buffer.data();
}

std::string length_text(double length_m) {
  constexpr std::array<std::pair<double, const char*>, 3> units{{{1.0, " m"}, {1e-3, " mm"}, {1e-6, " µm"}}};
  for (const auto& [unit_m, name] : units)
    if (std::abs(length_m) > 0.9999 * unit_m) return rounded_text(length_m / unit_m) + name;
  return rounded_text(length_m / 1e-9) + " nm";
}

}  // namespace copepod
