#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon_config/daemon_config.h"
#include "j1939/address_claim.h"
#include "j1939/name.h"
#include "j1939/node.h"
#include "j1939/pgn_filter.h"

/// The whole configuration of a bus of J1939: plain values. `file.h` reads it from a TOML file. Not for the
/// realtime thread.
namespace cansyncd {

/// Sending.
struct MessageSendConfig {
  std::uint16_t queue = 64;                 ///< messages that may wait at the realtime thread, 1..64
  std::chrono::milliseconds timeout{1250};  ///< monitoring time of requests that name none, 1..3'600'000
};

/// Messages in packets.
struct MessageTransportConfig {
  std::uint8_t window = 16;                ///< packets of a connection asked for at once, 1..255
  std::uint32_t most_bytes = 65'536;       ///< of a message, 1785..1'048'576
  std::chrono::milliseconds interval{50};  ///< between two packets of a broadcast, 10..200
};

/// A simulated node; looked at only with `BusKind::simulated`.
struct SimEcuConfig {
  unsigned number = 0;       ///< 0..31
  std::uint8_t address = 0;  ///< 0..253
  j1939::NameFields name;
  j1939::Pgn group = 0xFEF1;
  std::uint8_t priority = 6;            ///< 0..7
  std::uint8_t destination = 255;       ///< 0..253, or 255
  std::vector<std::uint8_t> data;       ///< 0..1785 bytes
  std::chrono::milliseconds period{0};  ///< 0: on request alone
  bool counts = true;                   ///< the first byte counts its periodic messages
};

/// Everything.
struct J1939Config : DaemonConfig {
  /// What no option of a file says otherwise.
  J1939Config() {
    bus.bits_per_second = 250'000;
    bus.sample_point = 875;  // J1939-11 and J1939-15
    // Frames of other nodes begin at any time: in one-shot mode the weaker is lost.
    bus.one_shot = OneShot::ignore;
    // Whoever gives no NAME takes nobody's address: the weakest there is.
    name = j1939::fields_of(j1939::kWeakestName);
  }

  std::optional<j1939::Address> preferred;  ///< 0..253; nothing: it listens only
  j1939::Address first_other = 128;         ///< 0..253
  j1939::Address last_other = 247;          ///< at least `first_other`
  bool takes_commands = true;
  bool contest = false;  ///< claims without a look at who has the address
  bool between_others = false;
  j1939::NameFields name;
  std::vector<j1939::PgnRange> receive;  ///< by number, at most PgnFilter::kMostRanges
  MessageSendConfig send;
  MessageTransportConfig transport;
  std::vector<j1939::Provided> provided;
  std::vector<SimEcuConfig> ecus;  ///< by number, each once
};

}  // namespace cansyncd
