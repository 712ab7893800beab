#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "config/yaml/document.hpp"
#include "config/yaml/keys.hpp"
#include "config/yaml/value.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {

enum class SweepScale { linear, logarithmic };
enum class SweepCombination { grid, zip };

inline constexpr std::array scale_names{Choice<SweepScale>{"linear", SweepScale::linear},
                                        Choice<SweepScale>{"logarithmic", SweepScale::logarithmic}};
inline constexpr std::array combination_names{Choice<SweepCombination>{"grid", SweepCombination::grid},
                                              Choice<SweepCombination>{"zip", SweepCombination::zip}};

/// A key of the case that takes several values.
struct SweptKey {
  std::string key;                        ///< key path
  SweepScale scale = SweepScale::linear;  ///< of the range that the values come from
  std::vector<Value> values;
};

/// Keys of the case that take several values: a run for each combination (grid), or for each place in their lists
/// (zip). Members are numbered from 0; in a grid the last key varies fastest.
struct Sweep {
  std::vector<SweptKey> parameters;
  SweepCombination combination = SweepCombination::grid;
};

std::size_t member_count(const Sweep& sweep);

/// What makes a member of the case: a value for each swept key, in their order, and no sweep.
std::vector<Value::Entry> assignments_of(const Sweep& sweep, std::size_t member);

/// A member in a message: «amplitude_N=1e-05, lag_deg=30».
std::string member_text(const Sweep& sweep, std::size_t member);

/// An assignment as after --set.
std::string setting_text(const Value::Entry& assignment);

/// The values of a range. Its ends are those that are written; the others are rounded to a thousandth of the distance
/// between neighbours, so that they read as a person would write them.
///   linear       vᵢ = a + (b − a) i / (n − 1)
///   logarithmic  vᵢ = a (b/a)^(i / (n − 1))
/// @param count  n, at least 2
/// @return decimal texts
std::vector<std::string> range_texts(double from, double to, std::size_t count, SweepScale scale);

/// The sweep of a case, or nothing.
/// @throws CaseInvalid with every error found in it
std::optional<Sweep> read_sweep(const Document& document);
/// Adds the section `sweep` to the schema of the case.
void describe_sweep(Keys& keys);

}  // namespace copepod::coupler
