#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "cansync/config/config.h"
#include "cansync/process_data/release_status.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/reference_age.h"
#include "daemon/cansync/status/reference_status.h"
#include "daemon/cansync/texts/event_text.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/writer_arbiter.h"
#include "daemon/service/daemon_identity.h"

namespace cansyncd {

/// One sample of reference values, as it came.
struct ReferenceSample {
  WriterHandle writer = 0;
  WriterKey key = {};
  unsigned telegram = 1;                 ///< as written: 1 or 2
  bool given_up = false;                 ///< nothing else but writer, telegram and `written` counts
  std::int64_t written = 0;              ///< source time, ns since 1970
  DaemonIdentity daemon = {};            ///< the start of the daemon the values are meant for
  gateway::dds::Problem problem;         ///< a field that is out of range
  cansync::ReferenceUpdate update = {};  ///< `takes_over` is decided here
};

/// What the gate needs of the world around it.
class ReferenceSurroundings {
 public:
  virtual ~ReferenceSurroundings() = default;
  /// Hands `request` (ReferenceUpdate or StopRelease) to the realtime thread, in order. Empty: done; else why
  /// there was no room.
  virtual std::string hand_on(const Request& request) = 0;
  virtual void tell(const EventText& event, SteadyTime now) = 0;
  /// Who it is; asked when a writer is not the owner of its telegram.
  virtual gateway::dds::WriterIdentity identify(WriterHandle writer) = 0;
  /// Has the writer left? For texts alone.
  virtual bool left(WriterHandle writer) = 0;
};

/// Decides what becomes of reference values: who owns a telegram, what a take-over ends, when a telegram is
/// given up or lost, which samples are too old or meant for another start of the daemon, and what of it is
/// told. Knows neither DDS nor a clock: it is told what came and when.
///
/// - The owner of a telegram keeps it until it gives it up, is lost, or a stronger writer comes (WriterArbiter).
///   That one takes over with its first sample, whatever that is refused for: what the one before gave ends
///   first. Others wait: their samples are refused, counted and told on the change.
/// - `given_up` of the owner ends the release at once, of anybody else changes nothing there. What others have
///   written before that is not taken afterwards (as far as ages are looked at), nor what they have written
///   before the owner was lost.
/// - An owner that is lost or misses its deadline ends the release too, after the configured hold.
/// - After each of these the reaction is due once, until values are handed on again.
/// - A telegram of the lead axis has no owner; its values are lost when they grow too old, and back when the
///   realtime thread has taken new ones.
/// - Where a value of the telegram has limits, the realtime thread alone knows which samples are good: one that
///   was refused for a limit ends no loss, and begins no deadline.
/// - Refused samples are told on the edge and counted; they do not keep a deadline. While values are released
///   only those keep it that the realtime thread has taken.
///
/// A StopRelease that finds no room is kept, and no values of its telegram are handed on before it.
/// Not thread safe.
class ReferenceGate {
 public:
  /// A row of refused values is over when none was refused for so long.
  static constexpr std::chrono::seconds kQuiet{1};

  /// `daemon`: this start. `around` must outlive the gate. `refusal`: as for `set_refusal`.
  ReferenceGate(const DaemonIdentity& daemon, const Config& config, ReferenceSurroundings& around,
                gateway::dds::Problem refusal = std::nullopt);

  /// Values whose source time lies further away are refused; 0: not looked at.
  void set_maximum_age(std::chrono::milliseconds age) noexcept { age_.set_limit(age); }

  /// The line as last heard of: by it the age of values is told as a number of an interval.
  void set_line(const Moment& heard) noexcept { age_.set_line(heard); }

  /// Number of the reference mapping in force; values for another are refused.
  void set_mapping_number(std::uint64_t in_force) noexcept { mapping_number_ = in_force; }

  /// The telegrams of which a value has limits.
  void set_limits(const Config& config) noexcept;

  /// The telegrams that the lead axis of a cluster gives: no program may, and none has a part in them.
  void set_lead_axis(const std::array<bool, cansync::kChannels>& gives) noexcept;

  /// With a refusal every value is refused for it, and the release of what was given before is stopped.
  void set_refusal(gateway::dds::Problem refusal);

  /// A sample came. `wall`: CLOCK_REALTIME, ns since 1970, read after `now`.
  void take(const ReferenceSample& sample, std::int64_t wall, SteadyTime now);

  /// The owner of the telegram has given its key back, left or died. `wall` as above.
  void lost(unsigned channel, std::int64_t wall, SteadyTime now);

  /// The writer whose values were handed on last; 0: none.
  WriterHandle owner(unsigned channel) const noexcept { return arbiters_[channel].owner().handle; }

  /// Who has the telegram and who waits for it, to be told who has ended.
  WriterArbiter& arbiter(unsigned channel) noexcept { return arbiters_[channel]; }

  /// Takes note of what the realtime thread has ended by itself.
  void watch(const std::array<cansync::ReleaseStatus, cansync::kChannels>& release, SteadyTime now);

  /// The master refused what was handed on last.
  void refused(unsigned channel, const gateway::dds::Denial& denial, std::optional<Moment> when,
               SteadyTime now);
  /// The master refused values because one is beyond a limit, whoever gave them.
  void refused_for_limit(unsigned channel, const gateway::dds::Denial& denial, std::optional<Moment> when,
                         SteadyTime now);
  /// Values handed on last, for the text of a refusal.
  const cansync::ReferenceUpdate& newest(unsigned channel) const noexcept {
    return telegrams_[channel].newest;
  }

  /// Hands on the stops for which there was no room yet.
  void push_stops();

  /// True once for each loss after which the reaction is due.
  bool take_reaction(unsigned channel) noexcept;

  /// True once when new values were handed on after a loss.
  bool take_return(unsigned channel) noexcept;

  /// Tells missed deadlines, rows of refused values that are over, and in `givers` who waits. Returns when to call again; nothing:
  /// no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// Who gives the values of each telegram.
  const std::array<ReferenceGiver, cansync::kChannels>& givers() const noexcept { return givers_; }

 private:
  struct Telegram {
    SteadyTime
        given;  ///< when its values were taken last, handed on while none were released, or it took over
    std::optional<std::uint32_t> stop_wanted;  ///< StopRelease with this hold waits for room
    std::int64_t not_before = 0;               ///< source time; what was written earlier is not taken
    bool deadline_missed = false;              ///< since then
    bool reacted = false;                      ///< to a loss, since the values handed on last
    bool reaction_due = false;
    bool returned = false;              ///< values were handed on after a loss
    bool released = false;              ///< as last told by the realtime thread
    bool limited = false;               ///< the realtime thread may refuse a value for a limit
    bool beyond_limit = false;          ///< the newest it has looked at was
    std::uint64_t updates = 0;          ///< as last told by the realtime thread
    std::uint64_t too_old = 0;          ///< likewise
    std::uint64_t mapping_changed = 0;  ///< likewise
    cansync::ReferenceUpdate newest;    ///< handed on last
    FaultRow refused{kQuiet};
    std::string reason;  ///< of the event that was told, with its cause
  };

  gateway::dds::Problem problem(const ReferenceSample& sample, const ReferenceAge::Verdict& age,
                                std::int64_t wall) const;
  void take_values(const ReferenceSample& sample, unsigned channel, std::int64_t wall, SteadyTime now);
  void given_up(unsigned channel, std::int64_t written, SteadyTime now);
  void wait(unsigned channel, const TopicWriter& writer, SteadyTime now);
  void tell_waiting(unsigned channel);
  void new_owner(unsigned channel, const TopicWriter& writer, SteadyTime now);
  void values_given(unsigned channel);
  static void begin_deadline(Telegram& telegram, SteadyTime now) noexcept;
  void stop(unsigned channel, std::uint32_t hold);
  void lose(unsigned channel, Loss loss);
  void end_ownership(unsigned channel, Loss loss);
  std::optional<SteadyTime> look_at_deadline(unsigned channel, SteadyTime now);
  void tell(gateway_EventSeverity severity, EventCode code, std::string text, const std::string& who,
            SteadyTime now);
  std::string reaction_text() const;

  DaemonIdentity daemon_;
  ReferenceAge age_;
  std::uint32_t hold_;  ///< intervals for which the values of a lost writer go on; 0: not at all
  std::chrono::milliseconds deadline_;  ///< 0: not looked at
  ReferenceSurroundings& around_;
  gateway::dds::Problem refusal_;  ///< of everything
  std::optional<std::uint64_t> mapping_number_;
  std::array<bool, cansync::kChannels> lead_axis_ = {};
  std::array<Telegram, cansync::kChannels> telegrams_;
  std::array<WriterArbiter, cansync::kChannels> arbiters_{
      WriterArbiter("the reference values of telegram 1"),
      WriterArbiter("the reference values of telegram 2")};
  std::array<ReferenceGiver, cansync::kChannels> givers_;
};

}  // namespace cansyncd
