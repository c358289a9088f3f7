#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/desk/gateway_events.h"
#include "dds/denial.h"

namespace cansyncd {

/// Why a request, cancel or sample of a client was not taken.
enum class Rejection : std::uint8_t {
  value,         ///< a field is out of range
  full,          ///< a limit of the client, or of all together, is reached
  stale,         ///< too old, or from the future
  number,        ///< its number was used before
  identity,      ///< the identity belongs to another program, or a program uses too many
  malformed,     ///< DDS could not read the sample
  state,         ///< refused by the master: the state of the line, a slave, a right
  other_daemon,  ///< meant for another start of a daemon, or names none
};
inline constexpr unsigned kRejections = 8;

/// Why a request or cancel is refused whose member `daemon` is zero.
inline constexpr std::string_view kNamesNoDaemon =
    "daemon: the request names none; its program was made for data model 6 or older, or did not fill `daemon`: read "
    "GatewayStatus.daemon, or build it anew";

/// As what a refusal for this cause is counted.
Rejection rejection_of(gateway_RefusalCause cause) noexcept;

/// Counts by kind; index: `Rejection`.
using RejectionCounts = std::array<std::uint64_t, kRejections>;

/// Counts what is rejected, by kind, and reports each kind on the edge: an event when it begins, and one with
/// the sum when it has stayed away for `kQuiet`. Gateway thread only.
class Rejections {
 public:
  static constexpr std::chrono::seconds kQuiet{10};
  /// Most lines in the journal a second; the events have the sums.
  static constexpr unsigned kLines = 20;

  explicit Rejections(EventPublisher& events) : events_(events) {}

  /// Counts `count` and writes `text` (who and why) to the journal. The first of a row becomes an event.
  /// `client`: who, as far as it is known.
  void add(Rejection kind, const std::string& client, const std::string& text, SteadyTime now,
           std::uint64_t count = 1);

  /// Publishes the sums that are due. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  const RejectionCounts& counts() const noexcept { return counts_; }

 private:
  bool line_allowed(SteadyTime now);

  EventPublisher& events_;
  RejectionCounts counts_ = {};
  std::array<FaultRow, kRejections> rows_ = {FaultRow(kQuiet), FaultRow(kQuiet), FaultRow(kQuiet),
                                             FaultRow(kQuiet), FaultRow(kQuiet), FaultRow(kQuiet),
                                             FaultRow(kQuiet), FaultRow(kQuiet)};
  SteadyTime second_;
  unsigned lines_ = 0;
};

/// Nothing, or why a request written at `written` (ns since 1970, the client's clock) is not taken at `now`;
/// it may be older or further in the future by `limit` at most, 0 = any.
gateway::dds::Problem stale(std::int64_t written, std::int64_t now, std::chrono::milliseconds limit);

}  // namespace cansyncd
