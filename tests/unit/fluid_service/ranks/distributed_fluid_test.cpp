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
  void sum_to_leader(std::span<std::int64_t>) override {}
  void sum_to_all(std::span<std::int64_t>) override {}
  void max_to_all(std::span<std::int64_t>) override {}
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

class CommandChannelTest : public testing::Test {
 protected:
  std::deque<std::vector<std::byte>> tape_;
  SolverContext context_;
  Tape leader_{context_, tape_, 0};
  Tape follower_{context_, tape_, 1};
  CommandChannel sender_{leader_};
  CommandChannel receiver_{follower_};
  Command received_;
};

TEST_F(CommandChannelTest, SendsAStepInOneSmallMessage) {
  Command sent;
  sent.order = Order::exchange_advance;
  sent.step = 123456789012;
  sender_.send(sent);
  ASSERT_EQ(tape_.size(), 1U);
  EXPECT_LE(tape_.front().size(), 256U);
  receiver_.receive(received_);
  EXPECT_EQ(received_.order, Order::exchange_advance);
  EXPECT_EQ(received_.step, sent.step);
}

TEST_F(CommandChannelTest, CrossesTheLimitBetweenOneAndTwoMessagesWithoutLoss) {
  Command sent;
  sent.order = Order::save;
  bool one = false;
  bool two = false;
  for (std::size_t length = 200; length <= 260; ++length) {
    sent.path.assign(length, 'a');
    sent.path.back() = 'z';
    sender_.send(sent);
    (tape_.size() == 1 ? one : two) = true;
    receiver_.receive(received_);
    EXPECT_EQ(received_.path, sent.path);
    EXPECT_TRUE(tape_.empty());
  }
  EXPECT_TRUE(one && two);
}

TEST_F(CommandChannelTest, SendsASetup) {
  Command sent;
  sent.order = Order::construct;
  sent.setup.step_s = 1.5;
  sent.setup.domain_cells = {5, 6, 7};
  sent.setup.bodies = {{ShapeKind::sphere, 15, 0}, {ShapeKind::capsule, 16, 17}};
  sent.setup.fields.directory = "/a/folder";
  sender_.send(sent);
  receiver_.receive(received_);
  EXPECT_EQ(received_.order, Order::construct);
  EXPECT_EQ(received_.setup.step_s, 1.5);
  EXPECT_EQ(received_.setup.domain_cells, sent.setup.domain_cells);
  ASSERT_EQ(received_.setup.bodies.size(), 2U);
  EXPECT_EQ(received_.setup.bodies[1].length_m, 17);
  EXPECT_EQ(received_.setup.fields.directory, "/a/folder");
}

TEST_F(CommandChannelTest, SendsThePathOfACheckpoint) {
  Command sent;
  sent.order = Order::restore;
  sent.path = "/runs/a/checkpoints/step_000001000/fluid.h5";
  sender_.send(sent);
  receiver_.receive(received_);
  EXPECT_EQ(received_.order, Order::restore);
  EXPECT_EQ(received_.path, sent.path);
}

TEST(CommandUnpacking, RefusesATruncatedMessage) {
  std::vector<std::byte> message;
  Command sent;
  sent.order = Order::save;
  sent.path = "/runs/a";
  pack(sent, message);
  message.resize(message.size() - 1);
  Command command;
  EXPECT_THROW(unpack(message, command), std::logic_error);
}

}  // namespace
}  // namespace copepod::fluid
