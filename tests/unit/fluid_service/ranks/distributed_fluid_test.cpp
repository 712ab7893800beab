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

Kinematics moving_bodies(Eigen::Index bodies) {
  Kinematics kinematics;
  kinematics.step = 123456789012;
  kinematics.resize(bodies);
  kinematics.position_m.setRandom();
  kinematics.orientation_wxyz.setRandom();
  kinematics.velocity_m_per_s.setRandom();
  kinematics.angular_velocity_rad_per_s.setRandom();
  return kinematics;
}

void expect_equal(const Kinematics& a, const Kinematics& b) {
  EXPECT_EQ(a.step, b.step);
  EXPECT_EQ(a.position_m, b.position_m);
  EXPECT_EQ(a.orientation_wxyz, b.orientation_wxyz);
  EXPECT_EQ(a.velocity_m_per_s, b.velocity_m_per_s);
  EXPECT_EQ(a.angular_velocity_rad_per_s, b.angular_velocity_rad_per_s);
}

TEST_F(CommandChannelTest, SendsTheKinematicsOfASwimmerInOneMessage) {
  const Kinematics sent = moving_bodies(3);
  sender_.send(sent);
  EXPECT_EQ(tape_.size(), 1U);
  receiver_.receive(received_);
  EXPECT_EQ(received_.order, Order::exchange_advance);
  expect_equal(received_.kinematics, sent);
}

TEST_F(CommandChannelTest, SendsManyBodiesInTwoMessages) {
  const Kinematics sent = moving_bodies(1000);
  sender_.send(sent);
  EXPECT_EQ(tape_.size(), 2U);
  receiver_.receive(received_);
  expect_equal(received_.kinematics, sent);
}

TEST_F(CommandChannelTest, CrossesTheLimitBetweenOneAndTwoMessagesWithoutLoss) {
  for (Eigen::Index bodies = 17; bodies <= 22; ++bodies) {
    const Kinematics sent = moving_bodies(bodies);
    sender_.send(sent);
    receiver_.receive(received_);
    expect_equal(received_.kinematics, sent);
  }
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
  pack(moving_bodies(4), message);
  message.resize(message.size() - 1);
  Command command;
  EXPECT_THROW(unpack(message, command), std::logic_error);
}

}  // namespace
}  // namespace copepod::fluid
