#include "files/hdf5_file.hpp"

#include <array>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "temporary_folder.hpp"

namespace copepod::fluid {
namespace {

TEST(Hdf5File, ServesThreadsOneAfterTheOther) {
  const TemporaryFolder folder;
  const auto write_and_read = [&](std::int64_t own) {
    const std::string path = folder.path(std::to_string(own) + ".h5");
    SolverContext context;
    for (std::int64_t round = 0; round < 200; ++round) {
      {
        Hdf5File file(path, Hdf5File::Access::create, context);
        file.make_group("/group");
        file.write_attribute("/group", "number", 1000 * own + round);
        file.close();
      }
      Hdf5File file(path, Hdf5File::Access::read, context);
      EXPECT_EQ(file.read_attribute<std::int64_t>("/group", "number"), 1000 * own + round);
    }
  };
  std::vector<std::thread> threads;
  for (std::int64_t thread = 0; thread < 4; ++thread) threads.emplace_back(write_and_read, thread);
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace copepod::fluid
