#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "cansync/channel/jobs.h"
#include "cansync/settings/timing.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

/// Values of the upper bus that become reference values of the lower one without any client (O 7.1.1).
namespace cansync {

/// Where one reference value of the lower bus comes from.
struct LeadSource {
  /// What it is on the upper bus.
  enum class Kind : std::uint8_t {
    none,       ///< not from the upper bus
    reference,  ///< a reference value that the gateway gets as a slave
    actual,     ///< an actual value that the gateway releases as a slave
    monitored,  ///< an actual value of another slave of the upper bus, which the gateway monitors
  };
  Kind kind = Kind::none;
  std::uint8_t value = 0;  ///< 0..7
  SlaveNumber slave;       ///< `monitored`: whose
  bool is_signed = true;   ///< one that comes as a word, 16 bits, is made longer with its sign
  friend constexpr bool operator==(const LeadSource&, const LeadSource&) = default;
};

/// For each reference value of the lower bus. A telegram with at least one such value is given by the lead
/// axis alone.
using LeadSources = std::array<LeadSource, kValues>;

/// How many intervals after the one in which a value came it is a reference value below: 0 when its telegram
/// has certainly ended `reserve` before the lower one's planned start, else 1. Always the same for one
/// configuration, so that the lead axis has no jitter. Values of their own (`actual`) are there at the edge.
unsigned lead_delay(const LeadSource& source, Channel lower, const SlotTimes& times, Duration send_margin,
                    Duration reserve) noexcept;

/// What a lead axis has counted since its start, for one telegram of the lower bus.
struct LeadCounters {
  std::uint64_t given = 0;    ///< intervals with all values
  std::uint64_t missing = 0;  ///< intervals without: a value had not come, and the telegram was left out
  std::uint64_t refused = 0;  ///< not taken by the lower master: too wide, or another mapping
};

/// Holds what came on the upper bus, and gives it to the lower telegrams: each value for the one interval it
/// is due in, once, and never an older one in its place. Pure; realtime safe; not thread safe.
class LeadAxis {
 public:
  /// `send_margin` is the lower master's.
  LeadAxis(const LeadSources& sources, BitRate rate, Duration send_margin, Duration reserve) noexcept;

  /// Interval `now` begins.
  void begin_interval(IntervalNumber now) noexcept;

  /// A reference telegram came with `words` words; `values` are the slave's by `mapping`. `since_sync`: from
  /// the beginning of this interval to its end; one that was read late and ended before it belongs to the
  /// interval before.
  void took_references(Channel channel, unsigned words, const ProcessMapping& mapping, const Values& values,
                       Duration since_sync) noexcept;
  /// An actual value telegram of another slave, likewise.
  void took_monitored(SlaveNumber slave, Channel channel, unsigned words, const ProcessMapping& mapping,
                      const Values& values, Duration since_sync) noexcept;
  /// The gateway's own actual values of a channel were released: of its four those whose bit is in `valid`.
  void released(Channel channel, std::uint8_t valid, const Values& values) noexcept;

  /// Asked once an interval, right before the lower telegram is taken: its values, when all of them are
  /// there.
  std::optional<ReferenceUpdate> take(Channel channel) noexcept;
  /// The lower master did not take it.
  void refused(Channel channel) noexcept { ++counters_[index(channel)].refused; }

  /// True when the lead axis gives this telegram, and nobody else may.
  bool gives(Channel channel) const noexcept { return gives_[index(channel)] != 0; }
  /// Intervals until this lower value is given, 0 or 1.
  unsigned delay(unsigned value) const noexcept { return delay_[value]; }
  /// Counters as of this call; they go on changing.
  const LeadCounters& counters(Channel channel) const noexcept { return counters_[index(channel)]; }

 private:
  struct Sample {
    bool there = false;
    std::uint32_t value = 0;
  };
  using Samples = std::array<Sample, kValues>;  ///< by lower value
  Samples* samples_of(Duration since_sync) noexcept;
  void keep(const LeadSource& source, unsigned words, const ProcessMapping& mapping, const Values& values,
            Samples& samples) noexcept;

  LeadSources sources_;
  Duration interval_;
  std::array<std::uint8_t, kValues> delay_ = {};
  std::array<std::uint8_t, kChannels> gives_ = {};  ///< bit n: value n of the telegram
  IntervalNumber now_ = 0;
  Samples current_ = {};                    ///< came in this interval
  Samples previous_ = {};                   ///< came in the one before
  std::array<bool, kChannels> taken_ = {};  ///< in this interval
  std::array<LeadCounters, kChannels> counters_ = {};
};

}  // namespace cansync
