#include "ranks/command.hpp"

#include <algorithm>
#include <cstring>

#include "ranks/fluid_setup_packing.hpp"
#include "ranks/packing.hpp"

namespace copepod::fluid {

namespace {

/// Size of the first, usually only, broadcast: below the size at which MPI starts to ask the receiver first.
constexpr std::size_t first_part_bytes = 2048;

template <class Archive, class K>
void describe(Archive& archive, K& kinematics) {
  archive(kinematics.step);
  archive(kinematics.position_m);
  archive(kinematics.orientation_wxyz);
  archive(kinematics.velocity_m_per_s);
  archive(kinematics.angular_velocity_rad_per_s);
}

}  // namespace

void pack(const Kinematics& kinematics, std::vector<std::byte>& message) {
  message.clear();
  Packer packer(message);
  packer(Order::exchange_advance);
  describe(packer, kinematics);
}

void pack(const Command& command, std::vector<std::byte>& message) {
  if (command.order == Order::exchange_advance) return pack(command.kinematics, message);
  message.clear();
  Packer packer(message);
  packer(command.order);
  if (command.order == Order::construct) {
    packer(command.setup.bodies.size());
    describe_physics(packer, command.setup);
    describe_output(packer, command.setup);
  }
  if (command.order == Order::save || command.order == Order::restore) packer(command.path);
}

void unpack(const std::vector<std::byte>& message, Command& command) {
  Unpacker unpacker(message);
  unpacker(command.order);
  if (command.order == Order::exchange_advance) describe(unpacker, command.kinematics);
  if (command.order == Order::construct) {
    std::size_t bodies = 0;
    unpacker(bodies);
    command.setup.bodies.resize(bodies);
    describe_physics(unpacker, command.setup);
    describe_output(unpacker, command.setup);
  }
  if (command.order == Order::save || command.order == Order::restore) unpacker(command.path);
}

void CommandChannel::send(const Command& command) {
  pack(command, message_);
  broadcast_message();
}

void CommandChannel::send(const Kinematics& kinematics) {
  pack(kinematics, message_);
  broadcast_message();
}

void CommandChannel::broadcast_message() {
  if (communicator_.size() == 1) return;
  const std::uint64_t size = message_.size();
  const std::size_t inline_size = std::min(message_.size(), first_part_bytes - sizeof(size));
  first_part_.resize(first_part_bytes);
  std::memcpy(first_part_.data(), &size, sizeof(size));
  std::memcpy(first_part_.data() + sizeof(size), message_.data(), inline_size);
  communicator_.broadcast(first_part_);
  if (inline_size < message_.size()) communicator_.broadcast(std::span(message_).subspan(inline_size));
}

void CommandChannel::receive(Command& command) {
  first_part_.resize(first_part_bytes);
  communicator_.broadcast(first_part_);
  std::uint64_t size = 0;
  std::memcpy(&size, first_part_.data(), sizeof(size));
  message_.resize(size);
  const std::size_t inline_size = std::min(message_.size(), first_part_bytes - sizeof(size));
  std::memcpy(message_.data(), first_part_.data() + sizeof(size), inline_size);
  if (inline_size < message_.size()) communicator_.broadcast(std::span(message_).subspan(inline_size));
  unpack(message_, command);
}

}  // namespace copepod::fluid
