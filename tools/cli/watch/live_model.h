#pragma once

#include <cansync/topics.h>
#include <cansync/types.h>

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "cli/cansync/timing_report.h"
#include "cli/watch/watch_rows.h"

/// What the live view knows: the newest of everything, and a bounded past. Main thread only.
namespace cansync::cli {

inline constexpr std::size_t kTrendPoints = 64;
inline constexpr std::size_t kLiveEvents = 100;
/// Samples of Timing, which come once a second, that figures of timing are made of.
inline constexpr std::size_t kTimingSeconds = 60;

/// The last points of one value, one for each look; the oldest goes when the ring is full.
class Trend {
 public:
  /// `point` is nothing when there was no value at that look.
  void add(std::optional<double> point);
  /// The newest `count` points at most, oldest first.
  std::vector<std::optional<double>> last(std::size_t count) const;

 private:
  std::array<std::optional<double>, kTrendPoints> points_ = {};
  std::size_t added_ = 0;
};

/// Actual values, then parameters.
inline constexpr unsigned kLiveValues = kSlaveValues + kMostParameters;

/// One of a slave's actual values, or of its parameters.
struct LiveValue {
  std::string name;  ///< as configured, may be empty; of a parameter as typed
  std::string unit;
  std::string words;  ///< of a parameter: what its profile calls the value; may be empty
  bool mapped = false;
  std::optional<double> scaled;  ///< nothing: not mapped, never came, or never read
  std::int64_t raw = 0;          ///< the number on the bus
  Trend trend;
};

/// One slave.
struct LiveSlave {
  unsigned number = 0;
  std::string name;
  std::string state;
  bool responds = false;
  std::optional<std::uint16_t> status_word;
  std::string fault;  ///< as the profile calls it; empty: none known
  std::uint64_t answers = 0;
  std::optional<std::int64_t> age_ms;   ///< of its newest actual value telegram; nothing: none yet
  std::optional<std::int64_t> read_ms;  ///< age of the oldest of its parameters' values; nothing: none yet
  bool read_failed = false;             ///< the newest read of one of them
  std::array<LiveValue, kLiveValues> values;
};

/// One event of the daemon.
struct LiveEvent {
  std::int64_t time = 0;  ///< CLOCK_REALTIME in ns
  gateway_EventSeverity severity = gateway_SEVERITY_INFO;
  std::string code;
  std::string text;
};

/// The master and the bus.
struct LiveMaster {
  LineFacts line;
  std::string state;
  unsigned configured = 0;  ///< slaves
  unsigned synchronized = 0;
  unsigned released = 0;
};

class LiveModel {
 public:
  /// One look at the line at CLOCK_REALTIME `now` in ns: every slave's trends grow by one point.
  void look(const LineFacts& line, const client::MasterStatus& status, const std::vector<WatchRow>& rows,
            std::int64_t now);
  /// A sample of timing. Figures are those of the last kTimingSeconds samples, once there are two.
  void take(const client::Timing& timing);
  void take(const client::Event& event);
  /// A warning of this program itself among the events.
  void tell(std::int64_t time, std::string code, std::string text);
  /// Whether a daemon is there; where it is looked for is told while it is not, and trends have gaps.
  void set_daemon(bool present, std::string place);

  bool daemon_present() const noexcept { return present_; }
  const std::string& place() const noexcept { return place_; }
  std::int64_t now() const noexcept { return now_; }
  const LiveMaster& master() const noexcept { return master_; }
  const std::vector<LiveSlave>& slaves() const noexcept { return slaves_; }
  /// Oldest first.
  const std::deque<LiveEvent>& events() const noexcept { return events_; }
  const std::optional<TimingReport>& timing() const noexcept { return timing_; }

 private:
  LiveSlave& slave(unsigned number);

  bool present_ = true;
  std::string place_;
  std::int64_t now_ = 0;
  LiveMaster master_;
  std::vector<LiveSlave> slaves_;
  std::deque<LiveEvent> events_;
  std::deque<client::Timing> samples_;
  std::optional<TimingReport> timing_;
};

}  // namespace cansync::cli
