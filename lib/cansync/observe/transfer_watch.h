#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "cansync/observe/line_clock.h"
#include "cansync/observe/observation.h"

namespace cansync::observe {

/// Puts the blocks of uploads and downloads together.
class TransferWatch {
 public:
  /// Fills `out`, which must outlive it.
  explicit TransferWatch(Observation& out) noexcept : out_(out) {}

  /// `again`: the same telegram as before, which was not answered or answered busy.
  void command(const Telegram& telegram, bool again, Duration since_first, Instant at);
  /// The answer, no busy one, to `asked`.
  void reply(const Telegram& asked, const TransferReply& reply);

 private:
  /// The block a slave was asked for last.
  struct Block {
    std::optional<std::size_t> step;
    std::uint32_t address = 0;
    std::uint32_t length = 0;
    std::uint32_t before = 0;  ///< bytes of the blocks before it
    IntervalNumber asked = 0;  ///< interval of the newest command
    bool done = false;
    bool failed = false;
  };

  void begin(const TransferInitialise& initialise, Duration since_first, Instant at);
  bool goes_on(const TransferInitialise& initialise, const TransferStep& step, const Block& block,
               Instant at);
  void take(Block& block, std::uint32_t offset, std::span<const std::uint8_t> bytes, bool last);

  Observation& out_;
  std::array<Block, kSlaves> block_ = {};
  std::size_t kept_ = 0;
};

}  // namespace cansync::observe
