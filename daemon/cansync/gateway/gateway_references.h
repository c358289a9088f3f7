#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "cansync.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/status/reference_status.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/config/config.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/writer_watch.h"
#include "dds/endpoint.h"
#include "dds/signal.h"
#include "dds/validate.h"

namespace cansyncd {

/// Takes reference values from DDS to the realtime thread. Gateway thread only.
///
/// DDS delivers those of the strongest living writer of each telegram. When that writer leaves, dies or
/// misses its deadline, the telegram's release is stopped, or held first, until new values come; the
/// configured reaction runs once until then, whatever else is lost meanwhile. Values that grow too old are
/// seen by the realtime thread, which needs nobody for it. A change of the writer is told as an event.
///
/// The deadline is counted here, by the clock of the gateway, and not by the QoS of DDS: that one is agreed
/// upon with every writer, and clients that do not offer it would not be matched at all.
///
/// Values that cannot be taken have no reply: the first of a row is told as an event, the rest is counted,
/// and a second event tells when it is over.
class ReferenceInput {
 public:
  /// A row of refused values is over when none was refused for so long.
  static constexpr std::chrono::seconds kQuiet{1};

  /// Throws cansync::dds::SetupError. `signal` and `events` must outlive this object.
  ReferenceInput(const cansync::dds::Participant& participant, cansync::dds::DataSignal& signal,
                 EventPublisher& events, const Config& config);

  /// Values whose source time lies further away are refused; 0: not looked at.
  void set_maximum_age(std::chrono::milliseconds age) noexcept { maximum_age_ = age; }

  /// Takes note of values that grew too old.
  void watch(const std::array<cansync::ReleaseStatus, cansync::kChannels>& release);

  /// True once for each loss after which the reaction is due.
  bool take_reaction(unsigned channel) noexcept;

  /// Who gives the values of each telegram.
  const std::array<ReferenceGiver, cansync::kChannels>& givers() const noexcept { return givers_; }

  /// With a reason every value is refused for it, and the release of what was given before is stopped.
  void set_refusal(std::optional<std::string> reason);

  /// Takes what is new and hands it on; needed only after the signal was raised. True: there may be more.
  bool take_samples(Exchange& exchange, SteadyTime now);

  /// Hands on the withdrawals for which there was no room yet.
  void push_stops(Exchange& exchange);

  /// The master refused what was handed on last.
  void refused(const ReferenceRefused& report, const Config& config, const RefusalContext& context,
               SteadyTime now);

  /// Tells missed deadlines, and rows of refused values that are over. Returns when to call again; nothing:
  /// no need.
  std::optional<SteadyTime> tick(SteadyTime now);

 private:
  struct Telegram {
    dds_instance_handle_t owner = 0;  ///< writer of the values handed on last; 0: none
    SteadyTime given;                 ///< when they were
    bool stop_wanted = false;         ///< StopRelease waits for room
    bool deadline_missed = false;     ///< since then
    bool reacted = false;             ///< to a loss, since the values handed on last
    bool reaction_due = false;
    std::uint64_t too_old = 0;        ///< as last told by the realtime thread
    cansync::ReferenceUpdate newest;  ///< handed on last
    FaultRow refused{kQuiet};
    std::string reason;  ///< of the event that was told
  };

  void take(const cansync_ReferenceValues& sample, const dds_sample_info_t& info, Exchange& exchange,
            SteadyTime now);
  std::optional<std::string> problem(const cansync_ReferenceValues& sample,
                                     const dds_sample_info_t& info) const;
  void look_for_owners(SteadyTime now);
  void accepted(unsigned channel, dds_instance_handle_t writer, SteadyTime now);
  void announce(unsigned channel, dds_instance_handle_t writer, SteadyTime now);
  void writer_lost(unsigned channel, SteadyTime now);
  void lose(unsigned channel, Loss loss);
  std::optional<SteadyTime> look_at_deadline(unsigned channel, SteadyTime now);
  std::string reaction_text() const;
  void count_refused(unsigned channel, std::string reason, std::optional<Moment> when, SteadyTime now);

  cansync::dds::Reader<cansync_ReferenceValues> reader_;
  EventPublisher& events_;
  cansync::dds::Limits limits_;
  std::chrono::milliseconds maximum_age_;
  std::uint32_t hold_;  ///< intervals for which the values of a lost writer go on; 0: not at all
  std::chrono::milliseconds deadline_;  ///< 0: not looked at
  WriterWatch writers_;
  std::optional<std::string> refusal_;  ///< of everything
  std::array<Telegram, cansync::kChannels> telegrams_;
  std::array<ReferenceGiver, cansync::kChannels> givers_;
};

}  // namespace cansyncd
