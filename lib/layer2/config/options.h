#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "config/print.h"
#include "config/rows.h"
#include "layer2/config/config.h"

/// The options of a bus of general frames. Main thread.
namespace cansyncd {

/// Value of `bus.protocol`.
inline constexpr std::string_view kLayer2Protocol = "layer2";

/// Configuration while it is being read.
struct Layer2Draft {
  /// One [[receive]].
  struct Range {
    bool given = false;
    std::optional<std::uint32_t> first;
    std::optional<std::uint32_t> last;
    bool extended = false;
    layer2::FrameKinds kinds = layer2::FrameKinds::data_and_remote;
    bool high_priority = false;
  };
  /// One [[timer]].
  struct Timer {
    bool given = false;
    TimerConfig timer;
  };
  /// One [[object]].
  struct Object {
    bool given = false;
    layer2::ObjectSettings settings;
  };
  /// One [[mapped]].
  struct Mapped {
    bool given = false;
    layer2::MappedBytes bytes;
  };
  static constexpr std::size_t kMostMapped = 512;
  /// One [[node]].
  struct Node {
    bool given = false;
    SimNodeConfig node;
  };

  Layer2Config config;
  std::array<Range, layer2::RangeFilter::kMostRanges> ranges = {};
  std::array<Node, 32> nodes = {};
  std::array<Timer, layer2::Timers::kMost + 1> timers = {};
  std::array<Object, layer2::MessageObjects::kMost> objects = {};
  std::array<Mapped, kMostMapped> mapped = {};
  std::optional<std::uint32_t> mapping_identifier;
  std::optional<std::uint32_t> mapping_mask;
  unsigned number = 0;  ///< of the section an option belongs to

  /// The settings that follow are of the section with this number.
  void begin(unsigned section) { number = section; }
};

/// Every row: the daemon's, but for the SYNC line, and those of general frames.
const config::Rows<Layer2Draft>& layer2_option_rows();

/// The table of the rows.
const config::Table& layer2_options();

/// What its documents begin with.
extern const config::DocumentHeads layer2_document_heads;

}  // namespace cansyncd
