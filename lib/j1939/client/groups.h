#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "dbc/database.h"
#include "j1939/identifier.h"

/// Signals of J1939 by name: groups of a file, whose identifiers stand for any priority, source and
/// destination. Allocates; main thread.
namespace j1939::client {

/// The messages of a file by their groups.
class Groups {
 public:
  Groups() = default;
  explicit Groups(dbc::Database database);

  const dbc::Database& database() const noexcept { return database_; }
  /// What the file says of a group.
  struct Found {
    const dbc::Message* message = nullptr;  ///< lives as long as the Groups; null: it has none
    std::size_t others = 0;  ///< messages of the group that it could be as well; of them all it is the first
  };
  /// Of several messages of a group that for this destination, then that of this source. Addresses 254 and 255 in the
  /// file stand for any.
  Found find(Pgn pgn, Address source, Address destination) const noexcept;

 private:
  struct Group {
    Pgn pgn = 0;
    Address source = 0;
    Address destination = kGlobalAddress;
    std::size_t message = 0;  ///< place among the messages of the file
  };

  dbc::Database database_;
  std::vector<Group> groups_;  ///< by rising group, those of one group in the order of the file
};

/// What a raw value says in the place of a value (SAE J1939-71): "not available", "error", "reserved" or "parameter
/// specific"; empty: it is a value.
std::string_view state_of(const dbc::Signal& signal, std::uint64_t raw);
/// The signal with the words "not available" and "error" for the raw values that say so, as far as the file has them not.
dbc::Signal with_states(dbc::Signal signal);

/// As dbc::read_signals. What is no value by SAE J1939-71 and has no other name has the name "not available", "error",
/// "reserved" or "parameter specific", and not a number as its value.
std::vector<dbc::Reading> read_group(const dbc::Message& message, std::span<const std::uint8_t> data);

}  // namespace j1939::client
