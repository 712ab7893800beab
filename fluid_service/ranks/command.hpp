#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// What rank 0 tells the other ranks to do.
enum class Order : std::uint32_t {
  construct,         ///< make a solver
  exchange_advance,  ///< exchange, and advance right after: the coupler never asks for one without the other
  save,
  restore,
  summarise,
  stop,  ///< leave the loop
};

/// An order and what belongs to it.
struct Command {
  Order order = Order::stop;
  FluidSetup setup;       ///< of construct
  Kinematics kinematics;  ///< of exchange_advance
  std::string path;       ///< of save and restore
};

/// Broadcasts commands in one small message where they fit (19 bodies), in two where they do not; reuses its
/// buffers.
class CommandChannel {
 public:
  explicit CommandChannel(Communicator& communicator) : communicator_(communicator) {}

  void send(const Command& command);        ///< on rank 0
  void send(const Kinematics& kinematics);  ///< on rank 0: exchange_advance without a copy of the arrays
  void receive(Command& command);           ///< on all other ranks

 private:
  void broadcast_message();

  Communicator& communicator_;
  std::vector<std::byte> message_;
  std::vector<std::byte> first_part_;
};

/// A command as bytes, and back.
void pack(const Command& command, std::vector<std::byte>& message);
void pack(const Kinematics& kinematics, std::vector<std::byte>& message);
void unpack(const std::vector<std::byte>& message, Command& command);

}  // namespace copepod::fluid
