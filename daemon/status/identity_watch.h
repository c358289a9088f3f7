#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "daemon/desk/event_text.h"
#include "dds/security.h"

namespace cansyncd {

/// Tells before the identity with which the daemon runs ends: DDS removes its participant at that instant. Pure,
/// but for memory; one thread.
class IdentityWatch {
 public:
  using WallTime = std::chrono::system_clock::time_point;
  /// How often `look` is to be called; the wall clock may have been set between.
  static constexpr std::chrono::hours kPeriod{1};
  /// From when on it tells.
  static constexpr std::chrono::days kNotice{30};

  /// `in_use`: of the files that were loaded at the start; nothing: DDS Security is off.
  explicit IdentityWatch(std::optional<gateway::dds::IdentityEnd> in_use) : in_use_(std::move(in_use)) {}

  /// What is to be told at `now`: events `identity_ending` when 30 days, 7 days and a day are left, and
  /// `identity_ended`. `on_disk`: of the files as they are now; those that were renewed are used from the next
  /// start on.
  std::optional<EventText> look(WallTime now, const std::optional<gateway::dds::IdentityEnd>& on_disk);

  /// Until it ends; 0: it has ended, or there is none.
  std::chrono::seconds time_left(WallTime now) const noexcept;

  bool is_used() const noexcept { return in_use_.has_value(); }

 private:
  std::optional<gateway::dds::IdentityEnd> in_use_;
  unsigned told_ = 0;  ///< steps towards the end that were told
};

}  // namespace cansyncd
