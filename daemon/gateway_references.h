#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "cansync.h"
#include "daemon/config.h"
#include "daemon/exchange.h"
#include "daemon/gateway_events.h"
#include "daemon/refusal_text.h"
#include "dds/endpoint.h"
#include "dds/signal.h"
#include "dds/validate.h"

namespace cansyncd {

/// Takes reference values from DDS to the realtime thread. Gateway thread only.
///
/// DDS delivers those of the strongest living writer of each telegram. When that writer leaves or dies, the
/// telegram's release is stopped, or held first, until new values come. Values that cannot be taken have no
/// reply: the first of a row is told as an event, the rest is counted, and a second event tells when it is
/// over.
class ReferenceInput {
 public:
  /// A row of refused values is over when none was refused for so long.
  static constexpr std::chrono::seconds kQuiet{1};

  /// Throws cansync::dds::SetupError. `signal` and `events` must outlive this object.
  ReferenceInput(const cansync::dds::Participant& participant, cansync::dds::DataSignal& signal,
                 EventPublisher& events, const Config& config);

  /// Values whose source time lies further away are refused; 0: not looked at.
  void set_maximum_age(std::chrono::milliseconds age) noexcept { maximum_age_ = age; }

  /// Takes what is new and hands it on; needed only after the signal was raised. True: there may be more.
  bool take_samples(Exchange& exchange, SteadyTime now);

  /// Hands on the withdrawals for which there was no room yet.
  void push_stops(Exchange& exchange);

  /// The master refused what was handed on last.
  void refused(const ReferenceRefused& report, const Config& config, const RefusalContext& context,
               SteadyTime now);

  /// Tells rows that are over. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

 private:
  struct Telegram {
    dds_instance_handle_t owner = 0;  ///< writer of the values handed on last; 0: none
    bool stop_wanted = false;         ///< StopRelease waits for room
    cansync::ReferenceUpdate newest;  ///< handed on last
    FaultRow refused{kQuiet};
    std::string reason;  ///< of the event that was told
  };

  void take(const cansync_ReferenceValues& sample, const dds_sample_info_t& info, Exchange& exchange,
            SteadyTime now);
  std::optional<std::string> problem(const cansync_ReferenceValues& sample,
                                     const dds_sample_info_t& info) const;
  void look_for_owners(SteadyTime now);
  void writer_lost(unsigned channel, SteadyTime now);
  void count_refused(unsigned channel, std::string reason, std::optional<Moment> when, SteadyTime now);

  cansync::dds::Reader<cansync_ReferenceValues> reader_;
  EventPublisher& events_;
  cansync::dds::Limits limits_;
  std::chrono::milliseconds maximum_age_;
  std::uint32_t hold_;  ///< intervals for which the values of a lost writer go on; 0: not at all
  std::array<Telegram, cansync::kChannels> telegrams_;
  std::uint32_t writers_ = 0;       ///< matched when last looked
  std::uint32_t writers_ever_ = 0;  ///< matched since the start when last looked
};

}  // namespace cansyncd
