#pragma once

#include <cansync/topics.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

/// Whether the reference values that `set` gives reach the line.
namespace cansync::cli {

inline constexpr std::uint16_t kActiveMaster = 0x0080;  ///< w_OPTION_STATUS: active as master

/// The values of one telegram.
struct TelegramToSet {
  std::array<std::int32_t, 4> value{};
  std::uint8_t valid = 0;
};
using Telegrams = std::array<TelegramToSet, 2>;

/// Who gives telegram 0 or 1, when that keeps a writer with `strength` from it, with the consequence and what
/// takes over; else empty.
std::string given_by_another(unsigned telegram, const client::MasterStatus& status, std::int32_t strength,
                             std::string_view consequence);

/// A strength that takes over every telegram that has values; `strength`, when that does.
std::int32_t strength_to_take_over(const Telegrams& telegrams, const client::MasterStatus& status,
                                   std::int32_t strength) noexcept;

/// Whether the values have an effect: the line is in active operation, and the daemon hears this writer.
/// `take` may be called by another thread.
class ReferenceEffect {
 public:
  /// `own`: part of what the daemon calls this writer.
  ReferenceEffect(const Telegrams& telegrams, std::int32_t strength, std::string own);

  /// An event that came while values are given.
  void take(const client::Event& event);

  /// Looks at the line; what keeps the values from having an effect, when that has changed, else empty.
  std::string look(const client::MasterStatus& status);

  /// True once the daemon was seen to hear this writer for every telegram.
  bool heard() const noexcept;

  /// Why values surely had no effect; empty: they had one, or nothing is known. After the last `look`.
  std::string without_effect() const;

 private:
  /// What is known of a telegram.
  struct Known {
    std::atomic<bool> heard = false;
    std::string giver;    ///< who gives it instead; empty: nobody does
    std::string refused;  ///< why the daemon refused values of it
  };

  const Telegrams& telegrams_;
  std::int32_t strength_;
  std::string own_;
  std::string told_;
  mutable std::mutex mutex_;  ///< guards `refused`
  std::array<Known, 2> known_;
  bool active_ = false;
};

}  // namespace cansync::cli
