#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "dbc/database.h"
#include "require.h"

namespace fuzz {

/// What every database that was accepted promises, whatever it was read from.
inline void check_database(const dbc::Database& database) {
  const std::array<std::uint8_t, 8> bytes = {0, 1, 2, 0x7F, 0x80, 0xFE, 0xFF, 0x55};
  for (const dbc::Message& message : database.messages()) {
    require(database.find(message.identifier, message.extended) == &message, "every message is found");
    require(dbc::read_signals(message, bytes).size() <= message.signals.size(), "no signal comes twice");
    for (const dbc::Signal& signal : message.signals) {
      require(dbc::lies_in(signal, message.length), "every signal lies in its message");
      require(!signal.chosen_by || signal.chosen_by->multiplexor < message.signals.size(),
              "every multiplexor is a signal of the message");
    }
  }
}

}  // namespace fuzz
