#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "../client.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// Actual value telegrams that came since they were looked at last. The client's receiver thread fills it.
/// The first telegram of a slave that it hears of is none that came: it may be old, and shows which ones are
/// new.
class CANSYNC_PUBLIC ActualValueInbox {
 public:
  /// What came since the last `take`.
  struct News {
    std::array<DINT_8_BMARRAY, 32> values = {};  ///< newest value of each slave
    std::array<std::uint8_t, 32> arrived = {};   ///< bit 0/1: telegram 1/2 of that slave came
    std::array<SINT, 2> newest = {kAutomaticNumber, kAutomaticNumber};  ///< slave of the newest telegram 1, 2
  };

  /// Throws SetupError.
  explicit ActualValueInbox(Client& client);

  /// Never waits for a telegram.
  News take();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  Subscription subscription_;
};

}  // namespace cansync::client::function_blocks
