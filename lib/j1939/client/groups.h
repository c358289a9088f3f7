#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dbc/database.h"

/// Signals of J1939 by name: groups of a file, whose identifiers stand for any priority, source and
/// destination. Allocates; main thread.
namespace j1939::client {

/// The messages of a file by their groups.
class Groups {
 public:
  Groups() = default;
  explicit Groups(dbc::Database database);

  const dbc::Database& database() const noexcept { return database_; }
  /// The message of a group: of several that of this source, else that of address 254, which stands for any,
  /// else the first; null: there is none. It lives as long as this object.
  const dbc::Message* find(std::uint32_t pgn, std::uint8_t source) const noexcept;

 private:
  struct Group {
    std::uint32_t pgn = 0;
    std::uint8_t source = 0;
    std::size_t message = 0;  ///< place among the messages of the file
  };

  dbc::Database database_;
  std::vector<Group> groups_;  ///< by rising group, those of one group in the order of the file
};

/// As dbc::read_signals; what says "not available" or "error" (SAE J1939-71) and has no other name is named
/// so.
std::vector<dbc::Reading> read_group(const dbc::Message& message, std::span<const std::uint8_t> data);

}  // namespace j1939::client
