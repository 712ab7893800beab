#include "files/shared_file.hpp"

#include <numeric>

#include <gtest/gtest.h>

#include "component/progress.hpp"
#include "temporary_folder.hpp"

namespace copepod::fluid {
namespace {

constexpr Hdf5File::Extent::value_type planes = 5, rows = 1000, columns = 1000;  // 40 MB

/// How often `action` shows that it moves on.
template <class Action>
std::uint64_t signs_of_progress(const Action& action) {
  const std::uint64_t before = progress_counter();
  action();
  return progress_counter() - before;
}

/// A disk that moves so much in the time that the watchdog allows for no progress is not taken for hung.
TEST(SharedFile, ShowsProgressAtLeastEvery16MiBOfWritingSyncingAndReading) {
  const TemporaryFolder folder;
  const std::string path = folder.path("numbers.h5");
  std::vector<double> numbers(planes * rows * columns);
  std::iota(numbers.begin(), numbers.end(), 0.5);
  std::int64_t offset = 0;
  {
    Hdf5File file(path, Hdf5File::Access::create);
    offset = file.make_dataset<double>("numbers", {planes, rows, columns});
    file.close();
  }
  EXPECT_GE(signs_of_progress([&] { reserve_space(path); }), 3U);

  SharedFile shared(path);
  const Hdf5File::Extent all = {planes, rows, columns};
  EXPECT_GE(signs_of_progress([&] { shared.write(offset, all, {0, 0, 0}, all, numbers.data()); }), 3U);
  EXPECT_GE(signs_of_progress([&] { shared.sync(); }), 3U);

  std::vector<double> found(numbers.size());
  Hdf5File file(path, Hdf5File::Access::read);
  EXPECT_GE(signs_of_progress([&] { file.read("numbers", {0, 0, 0}, all, found.data()); }), 3U);
  EXPECT_EQ(found, numbers);
}

TEST(Hdf5File, ReadsAPartOfALargeDatasetAsOneBlock) {
  const TemporaryFolder folder;
  const std::string path = folder.path("numbers.h5");
  const Hdf5File::Extent all = {1, 3, 2'000'000};
  std::vector<double> numbers(6'000'000);
  std::iota(numbers.begin(), numbers.end(), 0.5);
  {
    Hdf5File file(path, Hdf5File::Access::create);
    const std::int64_t offset = file.make_dataset<double>("numbers", all);
    file.close();
    SharedFile(path).write(offset, all, {0, 0, 0}, all, numbers.data());
  }
  std::vector<double> found(2 * 1'999'999);
  Hdf5File(path, Hdf5File::Access::read).read("numbers", {0, 1, 1}, {1, 2, 1'999'999}, found.data());
  EXPECT_EQ(found.front(), 2'000'001.5);
  EXPECT_EQ(found[1'999'998], 3'999'999.5);
  EXPECT_EQ(found[1'999'999], 4'000'001.5);
  EXPECT_EQ(found.back(), 5'999'999.5);
}

}  // namespace
}  // namespace copepod::fluid
