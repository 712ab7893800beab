#pragma once

#include <nlohmann/json.hpp>

#include "contract/errors.hpp"

namespace copepod::coupler {

/// An integer of a checkpoint. A number of another kind is none: its value need not fit, and converting it
/// anyway is undefined behaviour.
/// @throws StorageError
template <class Integer>
Integer whole_number(const nlohmann::ordered_json& json) {
  if (!json.is_number_integer())
    throw StorageError("a checkpoint has " +
                       json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
                       " for a whole number (damaged). Use another one.");
  return json.get<Integer>();
}

}  // namespace copepod::coupler
