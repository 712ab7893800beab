#pragma once

#include <memory>
#include <optional>
#include <string>

#include "transport/dealer.hpp"
#include "transport/keys.hpp"
#include "transport/router.hpp"

namespace copepod::transport {

/// Binds a ROUTER socket. For ipc the path is guarded by a lock file beside it.
/// @param keys  messages are encrypted, and only holders of an admitted key may connect
/// @throws Refused if the address is taken or cannot be bound, CaseError if it is not valid or needs keys, StorageError
///         if the disk is full
std::unique_ptr<Router> bind_router(const std::string& endpoint, const std::optional<CouplerKeys>& keys = std::nullopt);

/// Connects a DEALER socket; the coupler need not be there yet.
/// @param name  name for the coupler's socket, unique among its peers
/// @throws CaseError if the address is not valid or needs keys
std::unique_ptr<Dealer> connect_dealer(const std::string& endpoint, const std::string& name,
                                       const std::optional<ComponentKeys>& keys = std::nullopt);

}  // namespace copepod::transport
