#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "cansync.h"
#include "cansync/config/config.h"
#include "cansync/dds/topics.h"
#include "cansync/dds/validate.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/reference_gate.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/owned_reader.h"
#include "dds/signal.h"

namespace cansyncd {

/// Takes reference values from DDS to the realtime thread. Gateway thread only.
///
/// What becomes of them, and whose count, is decided by ReferenceGate. Here it is fed with samples, with the
/// writers that have left or died, and with the clocks.
///
/// The deadline is counted by the clock of the gateway, and not by the QoS of DDS: that one is agreed upon
/// with every writer, and clients that do not offer it would not be matched at all.
class ReferenceInput : private ReferenceSurroundings {
 public:
  /// `daemon`: this start. Throws gateway::dds::SetupError. `signal`, `events` and `exchange` must outlive
  /// this object.
  ReferenceInput(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
                 EventPublisher& events, const Config& config, const DaemonIdentity& daemon,
                 Exchange& exchange);

  /// Values whose source time lies further away are refused; 0: not looked at.
  void set_maximum_age(std::chrono::milliseconds age) noexcept { gate_.set_maximum_age(age); }

  /// The line as last heard of: by it the age of values is told as a number of an interval.
  void set_line(const Moment& heard) noexcept { gate_.set_line(heard); }

  /// As `ReferenceGate::set_mapping_number`.
  void set_mapping_number(std::uint64_t in_force) noexcept { gate_.set_mapping_number(in_force); }

  /// The telegrams that the lead axis of a cluster gives.
  void set_lead_axis(const std::array<bool, cansync::kChannels>& gives) noexcept {
    gate_.set_lead_axis(gives);
  }

  /// As `ReferenceGate::set_limits`.
  void set_limits(const Config& config) noexcept { gate_.set_limits(config); }

  /// Takes note of what the realtime thread has ended by itself.
  void watch(const std::array<cansync::ReleaseStatus, cansync::kChannels>& release, SteadyTime now) {
    gate_.watch(release, now);
  }

  /// True once for each loss after which the reaction is due.
  bool take_reaction(unsigned channel) noexcept { return gate_.take_reaction(channel); }

  /// True once when new values came after a loss.
  bool take_return(unsigned channel) noexcept { return gate_.take_return(channel); }

  /// Who gives the values of each telegram.
  const std::array<ReferenceGiver, cansync::kChannels>& givers() const noexcept { return gate_.givers(); }

  /// With a reason every value is refused for it, and the release of what was given before is stopped.
  void set_refusal(gateway::dds::Problem refusal) { gate_.set_refusal(std::move(refusal)); }

  /// Takes what is new and hands it on; needed only after the signal was raised. True: there may be more.
  bool take_samples(SteadyTime now);

  /// Hands on the withdrawals for which there was no room yet.
  void push_stops() { gate_.push_stops(); }

  /// The master refused what was handed on last.
  void refused(const ReferenceRefused& report, const Config& config, const RefusalContext& context,
               SteadyTime now);

  /// Tells missed deadlines, and rows of refused values that are over. Returns when to call again; nothing:
  /// no need.
  std::optional<SteadyTime> tick(SteadyTime now) { return gate_.tick(now); }

 private:
  std::string hand_on(const Request& request) override;
  void tell(const EventText& event, SteadyTime now) override { events_.publish(event, now); }
  gateway::dds::WriterIdentity identify(WriterHandle writer) override { return reader_.identify(writer); }
  bool left(WriterHandle writer) override { return reader_.left(writer); }

  void take(const cansync_ReferenceValues& sample, const dds_sample_info_t& info, SteadyTime now);

  OwnedReader<cansync_ReferenceValues> reader_;
  EventPublisher& events_;
  Exchange& exchange_;
  cansync::dds::Limits limits_;
  ReferenceGate gate_;
};

}  // namespace cansyncd
