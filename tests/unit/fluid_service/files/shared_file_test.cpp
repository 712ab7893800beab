#include <numeric>

#include <gtest/gtest.h>

#include "files/hdf5_file.hpp"
#include "ranks/thread_ranks.hpp"
#include "temporary_folder.hpp"

namespace copepod::fluid {
namespace {

constexpr Hdf5File::Extent::value_type planes = 5, rows = 1000, columns = 1000;  // 40 MB

/// How often `action` shows that it moves on.
template <class Action>
std::uint64_t signs_of_progress(const SolverContext& context, const Action& action) {
  const std::uint64_t before = context.progress();
  action();
  return context.progress() - before;
}

/// A disk that moves so much in the time that the watchdog allows for no progress is not taken for hung.
TEST(SharedFile, ShowsProgressAtLeastEvery16MiBOfWritingSyncingAndReading) {
  SolverContext context;
  const TemporaryFolder folder;
  const std::string path = folder.path("numbers.h5");
  std::vector<double> numbers(planes * rows * columns);
  std::iota(numbers.begin(), numbers.end(), 0.5);
  std::int64_t offset = 0;
  {
    Hdf5File file(path, Hdf5File::Access::create, context);
    offset = file.make_dataset<double>("numbers", {planes, rows, columns});
    file.close();
  }
  EXPECT_GE(signs_of_progress(context, [&] { reserve_space(path, context); }), 3U);

  SharedFile shared(path, context);
  const Hdf5File::Extent all = {planes, rows, columns};
  EXPECT_GE(signs_of_progress(context, [&] { shared.write(offset, all, {0, 0, 0}, all, numbers.data()); }), 3U);
  EXPECT_GE(signs_of_progress(context, [&] { shared.sync(); }), 3U);

  std::vector<double> found(numbers.size());
  Hdf5File file(path, Hdf5File::Access::read, context);
  EXPECT_GE(signs_of_progress(context, [&] { file.read("numbers", {0, 0, 0}, all, found.data()); }), 3U);
  EXPECT_EQ(found, numbers);
}

TEST(SharedFile, LackOfMemoryIsReportedInASentence) {
  SolverContext context;
  ThreadRanks ranks(1, context, [](Communicator&) {});
  try {
    on_every_rank(ranks.leader(), [] { throw std::bad_alloc(); });
    FAIL() << "nothing was thrown";
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("out of memory ("), std::string::npos) << error.what();
  }
}

TEST(Hdf5File, ReadsAPartOfALargeDatasetAsOneBlock) {
  SolverContext context;
  const TemporaryFolder folder;
  const std::string path = folder.path("numbers.h5");
  const Hdf5File::Extent all = {1, 3, 2'000'000};
  std::vector<double> numbers(6'000'000);
  std::iota(numbers.begin(), numbers.end(), 0.5);
  {
    Hdf5File file(path, Hdf5File::Access::create, context);
    const std::int64_t offset = file.make_dataset<double>("numbers", all);
    file.close();
    SharedFile(path, context).write(offset, all, {0, 0, 0}, all, numbers.data());
  }
  std::vector<double> found(2 * 1'999'999);
  Hdf5File(path, Hdf5File::Access::read, context).read("numbers", {0, 1, 1}, {1, 2, 1'999'999}, found.data());
  EXPECT_EQ(found.front(), 2'000'001.5);
  EXPECT_EQ(found[1'999'998], 3'999'999.5);
  EXPECT_EQ(found[1'999'999], 4'000'001.5);
  EXPECT_EQ(found.back(), 5'999'999.5);
}

}  // namespace
}  // namespace copepod::fluid
