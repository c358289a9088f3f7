#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "cansync/observe/line_clock.h"
#include "cansync/observe/observation.h"

namespace cansync::observe {

/// Looks at reference and actual value telegrams: whom they ask, what is in them, what did not come.
class ProcessWatch {
 public:
  /// Fills `out`, which must outlive it.
  explicit ProcessWatch(Observation& out) noexcept : out_(out) {}

  /// A WRC telegram.
  void reference(const ReferenceTelegram& telegram, Instant at) noexcept;
  /// An RDC telegram, asked for or not.
  void actual(const ActualTelegram& telegram) noexcept;

 private:
  struct Last {
    std::optional<std::array<std::uint16_t, 4>> word;
    std::uint8_t words = 0;
  };
  struct Asked {
    std::optional<std::uint8_t> number;  ///< of the newest telegram
    bool came = false;
    IntervalNumber interval = 0;
  };
  static void look(TelegramUse& use, Last& last, std::uint8_t words,
                   const std::array<std::uint16_t, 4>& word) noexcept;

  Observation& out_;
  std::array<Last, kChannels> last_reference_ = {};
  std::array<std::array<Last, kChannels>, kSlaves> last_actual_ = {};
  std::array<Asked, kChannels> asked_ = {};
};

}  // namespace cansync::observe
