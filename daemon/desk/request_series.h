#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/desk/gateway_events.h"
#include "daemon/desk/recorded_request.h"

namespace cansyncd {

/// What clients send again and again, so that a program that does it every 10 ms does not fill the journal: requests of
/// one client for one `Change::series` with one end are a series. The first is recorded, the others are counted and
/// recorded together, each minute and when none has come for a while. Gateway thread only.
class RequestSeries {
 public:
  /// Series that are kept apart; of those beyond, what one client sends of a kind with one end is one, and of as many
  /// again what all clients send with one end.
  static constexpr std::size_t kMost = 256;
  /// Between two entries of a series that goes on.
  static constexpr std::chrono::minutes kTogether{1};
  /// Without a request for so long a series has ended.
  static constexpr std::chrono::seconds kEnds{10};

  /// Requests that are recorded together.
  struct Sum {
    RecordedRequest newest;
    std::uint64_t count = 1;
    std::chrono::seconds within{0};  ///< since the entry before, rounded up; 0: it is the first
    std::string_view of = {};  ///< "several", "several clients": of all these, for which there was no room
  };

  /// Nothing: it was counted. Else it is to be recorded now.
  std::optional<Sum> add(RecordedRequest request, SteadyTime now);

  /// What is to be recorded now of what was counted. `all`: of every series, which are over.
  std::vector<Sum> take(SteadyTime now, bool all = false);

  /// When to call `take` again; nothing: no series goes on.
  std::optional<SteadyTime> next() const;

 private:
  bool has_room(const std::string& key, std::size_t most) const;

  struct Series {
    RecordedRequest newest;
    std::uint64_t counted = 0;  ///< since `recorded`
    SteadyTime recorded;
    SteadyTime came;
    std::string_view of;
    SteadyTime due() const;
  };
  std::map<std::string, Series> series_;
};

}  // namespace cansyncd
