#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "can/bus.h"
#include "cansync/config/config.h"
#include "cansync/settings/settings.h"
#include "cansync/sim/drive.h"
#include "daemon/cansync/exchange.h"
#include "dice.h"
#include "sim/faults.h"

namespace cansyncd::campaign {

/// Intervals in which something holds, both included.
struct Window {
  std::uint64_t from = 0;
  std::uint64_t to = 0;
  constexpr bool has(std::uint64_t n) const noexcept { return n >= from && n <= to; }
};

/// The realtime thread wakes late.
struct Lateness {
  Window when;
  unsigned per_mille = 0;  ///< of its wake-ups
  can::Time most{};        ///< by how much at most
};

/// A drive is switched off and on so fast that it misses nothing but its memory of the master.
struct PowerCycle {
  std::size_t slave = 0;  ///< index in `Plan::slaves`
  std::uint64_t at = 0;
};

/// The programs that give reference values through the gate.
struct WriterPlan {
  std::vector<std::int32_t> strengths;  ///< one each; empty: there is one, which needs no gate
  std::uint32_t hold = 0;               ///< intervals for which the values of a lost one go on
  std::chrono::milliseconds maximum_age{0};
  std::chrono::milliseconds deadline{0};
};

/// How often the clients ask for what, in a thousand intervals.
struct Mix {
  unsigned parameters = 0;
  unsigned transfers = 0;
  unsigned control_words = 0;
  unsigned broadcasts = 0;
  unsigned settings = 0;  ///< polling, cursors, mappings
  unsigned modes = 0;
  unsigned cancels = 0;
  unsigned departures = 0;  ///< a client leaves: its jobs are cancelled, its reference values withdrawn
  unsigned bursts = 0;      ///< as many requests as go in at once
  unsigned references = 0;  ///< updates of reference values
  unsigned stop_words = 0;  ///< control words that stop
};

/// One schedule: everything that is decided before the first interval. Intervals are counted as SYNC edges,
/// as in sim::Fault.
struct Plan {
  std::uint64_t seed = 0;
  cansync::MasterSettings settings;
  std::vector<sim::DriveSettings> drives;  ///< of the configured slaves, the lowest number first
  std::vector<sim::Fault> faults;
  std::vector<PowerCycle> power_cycles;
  std::vector<Window> hangs;  ///< the gateway neither reads nor writes
  std::vector<Lateness> lateness;
  bool rare_looks = false;  ///< frames do not wake the realtime thread
  StartTarget target = StartTarget::active;
  ExchangeSizes sizes;
  std::size_t transmit_queue = 10;
  std::uint64_t last_fault = 0;      ///< nothing is provoked after this interval
  std::uint64_t stop_at = 0;         ///< the daemon is stopped in this interval, whatever runs; 0: at the end
  std::uint64_t restless_until = 0;  ///< up to this interval `disturbed` holds anyway
  Mix mix;
  WriterPlan writers;

  can::Time interval() const noexcept { return cansync::slot_times(settings.bit_rate).interval; }
  /// Something was or is on the bus, or was late, that moves telegrams: they may begin after their slot.
  bool disturbed(std::uint64_t edge) const noexcept;
  /// Answers may come twice or late around these intervals: one may be taken for that of a later command.
  bool doubtful_answers(std::uint64_t from, std::uint64_t to) const noexcept;
};

/// Most intervals by which a frame is late.
inline constexpr unsigned kLatestIntervals = 3;

/// Draws the schedule of a seed; `intervals` is about the length of its part with faults (0: drawn as well).
Plan draw_plan(std::uint64_t seed, std::uint64_t intervals);

/// Draws the kind of one more fault beside `others`. A wrong answer names the next block or parameter: where
/// answers also come late or twice, it can come when that one is asked for, and nobody could tell. The two
/// are not combined.
sim::FaultKind draw_kind(Dice& dice, const std::vector<sim::Fault>& others);

/// Draws one fault of `kind` that is over in interval `last`.
sim::Fault draw_fault(Dice& dice, sim::FaultKind kind, const Plan& plan, std::uint64_t last);

/// Draws a mapping of reference or actual values. Word 0 always carries the low word of the telegram's first
/// value, which tells whose update it is.
cansync::ProcessMapping draw_mapping(Dice& dice);
/// Likewise of reference values, none of which is a word: the values of the campaign have 32 bits.
cansync::ProcessMapping draw_reference_mapping(Dice& dice);

/// The schedule in words, one line for each thing.
std::string describe(const Plan& plan);

}  // namespace cansyncd::campaign
