#include <algorithm>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "analysis/cycle_observer.hpp"
#include "analysis/made_up_motion.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

TEST(CycleTable, HasARowPerCycleAndContinuesWithoutDoubleRows) {
  const TemporaryFolder folder;
  const std::string path = folder.path("cycles.csv");
  const Case the_case = case_of(three_spheres());
  const auto lines = [&] {
    std::vector<std::string> found;
    std::ifstream stream(path);
    for (std::string line; std::getline(stream, line);) found.push_back(line);
    return found;
  };
  const auto play_from = [&](std::int64_t start, std::int64_t stop, const std::optional<TableEnd>& end,
                             const CycleObserver* before) {
    CycleObserver observer(groups_of(the_case));
    CycleTable table(path, observer.groups(), the_case.fluid, step_s, end);
    observer.write_to(&table);
    if (before != nullptr) observer.restore(before->sums(), start, 0);
    play(observer, MadeUpMotion{}, constant_forces(0, 0, 0), stop, start);
    return table.sync();
  };
  play_from(0, 3 * period + 1, {}, nullptr);
  const auto whole = lines();
  ASSERT_EQ(whole.size(), 4U);
  EXPECT_TRUE(
      whole[0].ends_with("Re,arm0_mean_m,arm0_amplitude_m,arm0_phase_rad,arm1_mean_m,arm1_amplitude_m,"
                         "arm1_phase_rad"));
  EXPECT_TRUE(whole[1].starts_with("swimmer,0,0,0,"));
  EXPECT_TRUE(whole[3].starts_with("swimmer,2,800,"));
  for (const std::string& line : whole)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(whole[0].begin(), whole[0].end(), ','));
  // A run that ended later than its checkpoint has left rows that will be computed again. The cycle that ends at step T
  // is measured in that step, after the checkpoint of step T.
  for (const std::int64_t cut : {period - 1, period, period + 1, 2 * period + 5}) {
    CycleObserver before(groups_of(the_case));
    play(before, MadeUpMotion{}, constant_forces(0, 0, 0), cut);
    const TableEnd end = play_from(0, cut, {}, nullptr);
    std::ofstream(path, std::ios::app) << "a row that will be computed again\n";
    play_from(cut, 3 * period + 1, end, &before);
    EXPECT_EQ(lines(), whole) << cut;
  }
}

}  // namespace
}  // namespace copepod::coupler
