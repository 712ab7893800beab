#include "ranks/distributed_fluid.hpp"

#include <cstring>
#include <deque>
#include <stdexcept>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

/// Rank 0 and rank 1 in one process: what one broadcasts, the other receives.
class Tape final : public Communicator {
 public:
  Tape(SolverContext& context, std::deque<std::vector<std::byte>>& tape, int rank)
      : Communicator(context), tape_(tape), rank_(rank) {}
  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return 2; }
  void broadcast(std::span<std::byte> data) override {
    if (rank_ == 0) {
      tape_.emplace_back(data.begin(), data.end());
      return;
    }
    ASSERT_FALSE(tape_.empty());
    ASSERT_EQ(tape_.front().size(), data.size());
    std::memcpy(data.data(), tape_.front().data(), data.size());
    tape_.pop_front();
  }
  void reduce_to_leader(std::span<std::int64_t>, Reduction) override {}
  [[nodiscard]] std::function<void()> start_exchange(std::span<const Message>) override {
    return [] {};
  }
  [[nodiscard]] std::function<void()> start_send(int, std::span<const std::byte>) override {
    return [] {};
  }
  void receive(int, std::vector<std::byte>&) override {}
  void report_failure(const FailureReport&) override {}

 private:
  std::deque<std::vector<std::byte>>& tape_;
  int rank_;
};

class Commands : public testing::Test {
 protected:
  std::deque<std::vector<std::byte>> tape_;
  SolverContext context_;
  Tape leader_{context_, tape_, 0};
  Tape follower_{context_, tape_, 1};
  Command received_;
};

TEST_F(Commands, OfAStepAreOneSmallMessage) {
  Command sent;
  sent.order = Order::exchange_advance;
  sent.step = 123456789012;
  send(leader_, sent);
  ASSERT_EQ(tape_.size(), 1U);
  EXPECT_LE(tape_.front().size(), 24U);
  receive(follower_, received_);
  EXPECT_EQ(received_.order, Order::exchange_advance);
  EXPECT_EQ(received_.step, sent.step);
}

TEST_F(Commands, HoldASetup) {
  Command sent;
  sent.order = Order::construct;
  sent.setup.step_s = 1.5;
  sent.setup.domain_cells = {5, 6, 7};
  sent.setup.bodies = {{ShapeKind::sphere, 15, 0}, {ShapeKind::capsule, 16, 17}};
  sent.setup.fields.directory = "/a/folder";
  send(leader_, sent);
  receive(follower_, received_);
  EXPECT_EQ(received_.order, Order::construct);
  EXPECT_EQ(received_.setup.step_s, 1.5);
  EXPECT_EQ(received_.setup.domain_cells, sent.setup.domain_cells);
  ASSERT_EQ(received_.setup.bodies.size(), 2U);
  EXPECT_EQ(received_.setup.bodies[1].length_m, 17);
  EXPECT_EQ(received_.setup.fields.directory, "/a/folder");
}

TEST_F(Commands, HoldThePathOfACheckpoint) {
  Command sent;
  sent.order = Order::restore;
  sent.path = "/runs/a/checkpoints/step_000001000/fluid.h5";
  send(leader_, sent);
  receive(follower_, received_);
  EXPECT_EQ(received_.order, Order::restore);
  EXPECT_EQ(received_.path, sent.path);
  EXPECT_TRUE(tape_.empty());
  sent = {.order = Order::summarise};
  send(leader_, sent);
  receive(follower_, received_);
  EXPECT_EQ(received_.order, Order::summarise);
  EXPECT_TRUE(received_.path.empty());
}

}  // namespace
}  // namespace copepod::fluid
