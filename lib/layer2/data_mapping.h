#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "can/frame.h"
#include "layer2/message_objects.h"
#include "layer2/timers.h"

namespace layer2 {

/// Some bytes of a frame, and where they stand in the process image.
struct MappedBytes {
  std::uint32_t identifier = 0;  ///< of the frame, of the mapping's width
  std::uint8_t offset = 0;       ///< first byte in the frame, 0..7
  std::uint16_t address = 0;     ///< first byte in the image of its direction, 0..1023
  std::uint8_t size = 1;         ///< bytes, 1..8; offset + size at most 8
  bool output = false;           ///< sent; false: received
};

/// What a data mapping does besides.
struct MappingSettings {
  MaskRule rule = {
      .identifier = 0, .mask = 0, .extended = false};  ///< frames that belong to it; its width holds for all
  bool table_alone = false;  ///< of the rule the width alone counts: identifiers of the table belong to it
  Time interval = std::chrono::milliseconds(10);  ///< between two times of sending, over 0
  bool on_change = false;    ///< only telegrams are sent whose bytes are others than those sent last
  bool first_always = true;  ///< with `on_change`: each telegram is sent once at the start
};

/// What can be wrong with a mapping.
enum class MappingProblem : std::uint8_t {
  none,
  identifier,     ///< too large for the width
  not_in_rule,    ///< an input whose identifier the rule does not take: it would never come
  bytes,          ///< offset and size do not lie in a frame of 8 bytes
  address,        ///< address and size do not lie in the image
  address_taken,  ///< an input byte of the image that another entry fills, too
  bytes_taken,    ///< a byte of a telegram that has two places in the image
  messages,       ///< more telegrams of a direction than there is room for
  interval,       ///< not over 0
};

/// Where it is wrong.
struct MappingFault {
  MappingProblem problem = MappingProblem::none;
  std::size_t entry = 0;  ///< position in the table; of `interval` 0
};

/// The cyclic exchange between frames and a process image (Saia 3.4, 4.2.4): 1024 bytes and 128 telegrams in,
/// and as many out.
///
/// A telegram that is received is written into the image at once; a second one before anybody looked takes
/// the place of the first. Bytes beyond those mapped are ignored, places of bytes that did not come keep
/// their value. Every `interval` the telegrams out are sent one after the other, as long as their highest
/// mapped byte says, with 0 where nothing is mapped. A round that an interval was too short for goes on where
/// it ended. A table begins with images that are all 0, and sends nothing until `set_sending`. Memory is
/// allocated by `configure` alone; the rest is realtime safe. One thread.
class DataMapping {
 public:
  static constexpr std::size_t kBytes = 1024;    ///< of the image of each direction
  static constexpr std::size_t kMessages = 128;  ///< of each direction

  /// Looks at a table alone; pure, allocates.
  static MappingFault check(const MappingSettings& settings, std::span<const MappedBytes> table);

  /// Takes a table that `check` has nothing against; it stands still until `start`.
  void configure(const MappingSettings& settings, std::span<const MappedBytes> table);

  /// Takes the table of another mapping, which gets that of this one; what was counted of all telegrams stays.
  /// It stands still until `start`. Allocates nothing.
  void swap_table(DataMapping& other) noexcept;
  /// Tables taken from others so far.
  std::uint32_t table() const noexcept { return table_; }

  /// What its telegrams out take of the bus, as `can::share_of_bus`; nothing when they are sent on change.
  std::int64_t share_of_bus(std::uint32_t bits_per_second) const noexcept;

  /// The exchange begins: the first telegrams are due `now`. Without telegrams nothing happens.
  void start(Time now) noexcept;
  /// The exchange ends; what waits is not sent. The images keep their bytes.
  void stop() noexcept;
  /// With false telegrams are taken, and none is sent; with true those of the next interval are.
  void set_sending(bool sending) noexcept;
  /// Telegrams are sent.
  bool sending() const noexcept { return sending_; }
  /// The exchange goes on.
  bool runs() const noexcept { return runs_; }

  /// True: the frame belongs to the mapping, and was taken or, without an entry, dropped. Remote frames do
  /// not belong to it, and no frame does without telegrams in.
  bool receive(const can::Frame& frame) noexcept;

  /// It is `now`: telegrams become due.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max(): the exchange stands still.
  Time next_deadline() const noexcept;
  /// The telegram out that goes next, 0..kMessages-1, in the order of the table, after the one sent last as
  /// long as the round of an earlier interval goes on; nothing: none is due.
  std::optional<std::uint8_t> next() const noexcept;
  /// What it sends, of the image as it is.
  can::Frame frame(std::uint8_t telegram) const noexcept;
  /// A telegram (any number) that was handed over may never have been on the bus: it goes once more.
  void lost(std::uint8_t telegram) noexcept;
  /// What was handed over may never have been on the bus: each telegram goes once more.
  void controller_emptied() noexcept;
  /// The bus took it as it was.
  void handed_over(std::uint8_t telegram, const can::Frame& frame) noexcept;

  /// The images. Bytes that nothing is mapped to are 0 in, and of no effect out.
  std::span<const std::uint8_t, kBytes> inputs() const noexcept { return inputs_; }
  /// What goes out; written by whoever has the values.
  std::span<std::uint8_t, kBytes> outputs() noexcept { return outputs_; }
  std::span<const std::uint8_t, kBytes> outputs() const noexcept { return outputs_; }
  /// Telegrams taken, dropped for want of an entry, and handed over, since the start.
  std::uint64_t received() const noexcept { return received_; }
  /// Telegrams dropped for want of an entry, since the start.
  std::uint64_t dropped() const noexcept { return dropped_; }
  /// Telegrams handed over since the start.
  std::uint64_t sent() const noexcept { return sent_; }
  /// A telegram out whose interval passed without it: no place on the bus.
  struct LeftOut {
    std::uint32_t identifier = 0;  ///< of the mapping's width
    std::uint32_t times = 0;       ///< since the table was taken
  };
  /// Telegrams out of the table, 0..kMessages.
  std::size_t telegrams() const noexcept { return out_.size(); }
  /// How often one was left out; `telegram` below `telegrams()`.
  LeftOut left_out(std::size_t telegram) const noexcept {
    return {out_[telegram].identifier, out_[telegram].left_out};
  }
  /// How often any was left out, since the start.
  std::uint64_t left_out() const noexcept { return left_out_; }

 private:
  static constexpr std::uint16_t kUnmapped = 0xFFFF;
  struct Telegram {
    std::uint32_t identifier = 0;
    std::uint8_t length = 0;  ///< highest mapped byte + 1
    std::array<std::uint16_t, 8> address = {};
    bool due = false;
    bool sent = false;  ///< at least once since `start`
    bool lost = false;  ///< handed over, and perhaps never on the bus
    can::Frame last;    ///< handed over; of a table that has just begun all 0
    std::uint32_t left_out = 0;
  };

  static Telegram* find(std::vector<Telegram>& telegrams, std::uint32_t identifier) noexcept;
  static void add(std::vector<Telegram>& telegrams, const MappedBytes& bytes);

  MappingSettings settings_;
  std::vector<Telegram> in_;   ///< by identifier
  std::vector<Telegram> out_;  ///< in the order of the table
  std::array<std::uint8_t, kBytes> inputs_ = {};
  std::array<std::uint8_t, kBytes> outputs_ = {};
  Time next_{0};
  std::size_t turn_ = 0;  ///< first telegram that is asked whether it is due
  std::uint32_t table_ = 0;
  bool runs_ = false;
  bool sending_ = false;
  std::uint64_t received_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint64_t sent_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace layer2
