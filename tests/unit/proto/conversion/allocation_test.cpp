// Counts calls of operator new: the exchange of a step must not allocate once its buffers have grown.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "conversion/codec.hpp"
#include "samples.hpp"

namespace {
std::atomic<long> allocations{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
// Kept out of line: where only one of the pair is inlined, gcc takes them for mismatched.
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace copepod::conversion {
namespace {

using session::Header;

/// One exchange of every kind, as both ends do it.
struct BothEnds {
  Encoder to_fluid, from_fluid, to_body, from_body;
  Decoder at_fluid, at_coupler_fluid, at_body, at_coupler_body;
  Kinematics kinematics;
  Loads loads;
  AppliedLoads applied;

  void exchange(const Kinematics& k, const Loads& l, const AppliedLoads& a, Eigen::Index bodies) {
    at_fluid.parse(to_fluid.encode(Header{}, k));
    at_fluid.read(kinematics, bodies);
    at_coupler_fluid.parse(from_fluid.encode(Header{}, l));
    at_coupler_fluid.read(loads, bodies);
    at_body.parse(to_body.encode(Header{}, a));
    at_body.read(applied, bodies, bodies, 3);
    at_coupler_body.parse(from_body.encode(Header{}, k));
    at_coupler_body.read(kinematics, bodies);
  }
};

TEST(Allocation, ExchangeAllocatesNothingAfterTheFirstSteps) {
  for (const Eigen::Index bodies : {3, 5000}) {
    BothEnds ends;
    const Kinematics kinematics = sample_kinematics(bodies);
    const Loads loads = sample_loads(bodies);
    const AppliedLoads applied = sample_applied_loads(bodies, bodies, 3);
    for (int step = 0; step < 3; ++step) ends.exchange(kinematics, loads, applied, bodies);
    const long before = allocations.load();
    for (int step = 0; step < 100; ++step) ends.exchange(kinematics, loads, applied, bodies);
    EXPECT_EQ(allocations.load() - before, 0) << bodies << " bodies";
  }
}

}  // namespace
}  // namespace copepod::conversion
