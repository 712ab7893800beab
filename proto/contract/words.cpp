#include "contract/words.hpp"

#include <algorithm>
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

std::string listed(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min(std::min(row[j], row[j - 1]) + 1, replaced);
    }
  }
  return row[b.size()];
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    // A key without its unit, or with another one, is the most likely slip.
    const bool prefix = candidate.starts_with(word + "_") || word.starts_with(candidate + "_");
    const std::size_t least = std::max(word.size(), candidate.size()) - std::min(word.size(), candidate.size());
    if (!prefix && least >= best_distance) continue;  // at least this many letters differ
    const std::size_t distance = prefix ? 1 : edit_distance(word, candidate);
    if (distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace copepod
