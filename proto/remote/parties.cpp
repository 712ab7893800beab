#include "remote/parties.hpp"

namespace copepod::remote {

std::string Party::description(int rank) const {
  const std::int64_t step = std::max(session.step, liveness.pong.step);
  const std::string process = rank == 0 ? ", process " + std::to_string(hello.pid) : "";
  return "The " + std::string(name_of(session.role)) + " component on host " + hello.host + " (rank " +
         std::to_string(rank) + process + ") at step " + std::to_string(step);
}

Parties::Parties() {
  of(session::Role::fluid).session.role = session::Role::fluid;
  of(session::Role::body).session.role = session::Role::body;
}

Party* Parties::by_data_peer(const std::string& peer) {
  for (Party& party : parties_) {
    if (party.data_peer == peer) return &party;
  }
  return nullptr;
}

Party* Parties::by_control_peer(const std::string& peer) {
  for (Party& party : parties_) {
    if (party.control_peer == peer) return &party;
  }
  return nullptr;
}

std::string Parties::missing() const {
  std::string list;
  for (const Party& party : parties_) {
    if (party.is_complete()) continue;
    if (!list.empty()) list += " and ";
    list += name_of(party.session.role);
  }
  return list;
}

}  // namespace copepod::remote
