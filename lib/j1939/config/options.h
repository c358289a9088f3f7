#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "config/print.h"
#include "config/rows.h"
#include "j1939/config/config.h"

/// The options of a bus of J1939. Main thread.
namespace cansyncd {

/// Value of `bus.protocol`.
inline constexpr std::string_view kJ1939Protocol = "j1939";

/// Configuration while it is being read.
struct J1939Draft {
  /// One [[receive]].
  struct Range {
    bool given = false;
    std::optional<j1939::Pgn> first;
    std::optional<j1939::Pgn> last;
    std::optional<j1939::Address> source;
  };
  /// One [[provide]].
  struct Offer {
    bool given = false;
    j1939::Provided provided;
  };
  /// One [[ecu]].
  struct Ecu {
    bool given = false;
    std::optional<std::uint32_t> identity;
    SimEcuConfig ecu;
  };

  J1939Config config;
  std::array<Range, j1939::PgnFilter::kMostRanges> ranges = {};
  std::array<Offer, 32> provided = {};
  std::array<Ecu, 32> ecus = {};
  unsigned number = 0;  ///< of the section an option belongs to

  /// The settings that follow are of the section with this number.
  void begin(unsigned section) { number = section; }
};

/// Every row: the daemon's, but for the SYNC line, and those of J1939.
const config::Rows<J1939Draft>& j1939_option_rows();

/// The table of the rows.
const config::Table& j1939_options();

/// What its documents begin with.
extern const config::DocumentHeads j1939_document_heads;

}  // namespace cansyncd
