#include "daemon/j1939/gateway/message_gateway.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "daemon/j1939/gateway/node_metrics.h"
#include "dds/bounded_text.h"
#include "j1939/config/options.h"
#include "j1939/dds/convert.h"
#include "j1939/dds/texts.h"
#include "j1939/name.h"

namespace cansyncd {
namespace {

using std::chrono::steady_clock;

/// Batches published in one pass: requests must not wait behind a bus that never rests.
constexpr unsigned kMessageBatchesAtOnce = 16;

}  // namespace

MessageGateway::MessageGateway(const J1939Config& config, J1939Exchange& exchange,
                               const gateway::dds::Participant& participant, JournalSink& journal,
                               const DaemonIdentity& identity)
    : GatewayBase(config, exchange, participant, journal, identity, kJ1939Protocol, 0),
      jobs_(participant, signal_, events_, trail_, MessageRequests(config.send, config.transport.most_bytes),
            identity, !config.dds.security.empty()),
      batches_(participant, 0, &signal_),
      long_messages_(participant, 0, &signal_),
      status_(participant, 0, &signal_),
      tables_(participant, 0, &signal_),
      faults_(participant, signal_, events_),
      left_out_(
          {"groups_left_out", "groups_left_out_over",
           "groups of [[provide]] are left out, because the one of the time before is not on the bus yet; make "
           "provide.period_ms longer, or let programs send fewer long messages",
           "groups of [[provide]] all have room again; left out"}) {
  long_data_.resize(j1939_MESSAGE_BATCH);
  jobs_.set_read_by_all(common_.gateway_writer());
}

MessageGateway::~MessageGateway() {
  stop();
}

std::string MessageGateway::metrics_text(std::uint64_t write_failures) const {
  return node_metrics_text(common_.told(), told_status_, write_failures);
}

MessageContext MessageGateway::context(SteadyTime now) const {
  return {exchange_, config_, now, {config_.dds.request_max_age, config_.access.read_only}};
}

SteadyTime MessageGateway::pass(bool samples_may_wait) {
  const SteadyTime now = steady_clock::now();
  (void)take_access(now);
  const MessageContext jobs = context(now);
  // A message that was sent is told before what came after it.
  take_answers(jobs);
  const bool more_messages = publish_messages();
  posted_.publish(events_, now);
  if (samples_may_wait) {
    second_daemon_.look(now);
    if (jobs_.take_requests(jobs)) signal_.raise();
  }
  const SteadyTime status_due = publish_status(now);
  const SteadyTime due = earliest(
      status_due,
      {jobs_.retry(jobs), losses_.next(), left_out_.next(),
       status_line_.step([this] { return bus_sentence(state_text(), bus_.controller, config_.bus); }, now)},
      now);
  return more_messages ? now : due;
}

std::string MessageGateway::state_text() const {
  const auto with = [this](std::string text) {
    if (losses_.next()) text += "; received messages are lost";
    if (left_out_.next()) text += "; groups of [[provide]] are left out";
    return text;
  };
  if (bus_.name_twice) return with("no address, nothing is sent: another node has the NAME of the daemon");
  switch (bus_.claim) {
    case j1939::ClaimState::listening:
      return with("J1939: listens without an address");
    case j1939::ClaimState::asking:
      return with("J1939: asks which addresses are free");
    case j1939::ClaimState::claiming:
      return with(fmt::format("J1939: claims address {}", bus_.address));
    case j1939::ClaimState::claimed:
      return with(fmt::format("J1939: has address {}", bus_.address));
    case j1939::ClaimState::cannot_claim:
      break;
  }
  return with("no address, nothing is sent: another node has address.preferred");
}

void MessageGateway::take_answers(const MessageContext& context) {
  MessageDone done;
  while (exchange_.done.try_pop(done)) jobs_.finish(done, context);
}

bool MessageGateway::publish_messages() {
  for (unsigned i = 0; i < kMessageBatchesAtOnce; ++i) {
    const bool more = collect_batch();
    if (!reports_.empty()) publish_batch();
    if (!more) return false;
  }
  return true;
}

bool MessageGateway::collect_batch() {
  reports_.clear();
  MessageReport report;
  while (reports_.size() < j1939_MESSAGE_BATCH) {
    if (!exchange_.messages.try_pop(report)) return false;
    if (report.size > j1939::kMostBytes) {
      // What came before it is published before it.
      if (!reports_.empty()) publish_batch();
      reports_.clear();
      publish_long(report);
      continue;
    }
    reports_.push_back(report);
    // What is longer was pushed before the report.
    if (report.size > report.data.size()) (void)exchange_.long_data.try_pop(long_data_[reports_.size() - 1]);
  }
  return true;
}

void MessageGateway::publish_long(const MessageReport& report) {
  longest_.clear();
  for (std::size_t i = 0; i < pieces_of(report.size); ++i) {
    (void)exchange_.long_data.try_pop(long_data_[0]);
    longest_.insert(longest_.end(), long_data_[0].begin(), long_data_[0].end());
  }
  longest_.resize(report.size);
  const j1939::Message message{report.number,    report.priority,     report.source, report.destination,
                               report.transport, report.receive_time, longest_};
  const auto sample =
      j1939::dds::long_message(message, report.receive_time.count(), report.range, ++long_number_);
  if (long_messages_.write(sample) != DDS_RETCODE_OK) ++unwritten_;
}

void MessageGateway::publish_batch() {
  batch_.clear();
  const SteadyTime now = steady_clock::now();
  for (std::size_t i = 0; i < reports_.size(); ++i) {
    const MessageReport& report = reports_[i];
    const std::uint8_t* data = report.size > report.data.size() ? long_data_[i].data() : report.data.data();
    const j1939::Message message{report.number,      report.priority,  report.source,
                                 report.destination, report.transport, report.receive_time,
                                 {data, report.size}};
    const j1939_ReceivedMessage received =
        j1939::dds::received_message(message, report.receive_time.count(), report.range);
    faults_.take(received, now);
    if (report.taken) batch_.push_back(received);
  }
  if (batch_.empty()) return;
  j1939_MessageBatch sample = {};
  sample.number = ++batch_number_;
  sample.lost = bus_.lost + unwritten_;
  sample.messages._length = static_cast<std::uint32_t>(batch_.size());
  sample.messages._maximum = sample.messages._length;
  sample.messages._buffer = batch_.data();  // lent for the call
  if (batches_.write(sample) != DDS_RETCODE_OK) unwritten_ += batch_.size();
}

void MessageGateway::publish_addresses() {
  AddressSnapshot snapshot;
  if (!exchange_.addresses.read(snapshot)) return;
  addresses_.clear();
  for (std::size_t i = 0; i < snapshot.names.size(); ++i) {
    if (snapshot.claimed[i]) addresses_.push_back({static_cast<std::uint8_t>(i), snapshot.names[i]});
  }
  j1939_AddressTable sample = {};
  sample.time = wall_clock_now();
  sample.addresses._length = static_cast<std::uint32_t>(addresses_.size());
  sample.addresses._maximum = sample.addresses._length;
  sample.addresses._buffer = addresses_.data();  // lent for the call
  (void)tables_.write(sample);
}

void MessageGateway::tell_claim(const NodeSnapshot& before, SteadyTime now) {
  using j1939::ClaimState;
  if (bus_.losses != before.losses) {
    events_.publish(
        {gateway_SEVERITY_WARNING, "address_lost", -1,
         fmt::format("a stronger NAME took address {}{}", before.address,
                     bus_.name_twice ? "; it is the daemon's own: give another name.identity" : ""),
         std::nullopt},
        now);
  }
  if (bus_.claim == before.claim && bus_.address == before.address) return;
  if (bus_.claim == ClaimState::claimed) {
    events_.publish({gateway_SEVERITY_INFO, "address_claimed", -1,
                     fmt::format("the daemon has address {}", bus_.address), std::nullopt},
                    now);
  } else if (bus_.claim == ClaimState::cannot_claim) {
    events_.publish({gateway_SEVERITY_ERROR, "address_unavailable", -1,
                     "the daemon has no address and sends nothing; give it another address.preferred, or "
                     "address.arbitrary, or end the node that has it",
                     std::nullopt},
                    now);
  }
}

SteadyTime MessageGateway::publish_status(SteadyTime now) {
  const NodeSnapshot before = bus_;
  if (exchange_.status.read(bus_)) {
    tell_bus(before.controller, bus_.controller, now);
    tell_claim(before, now);
  }
  publish_addresses();
  losses_.tell(bus_.lost + unwritten_, events_, now);
  tell_left_out(left_out_, bus_.groups_left_out, bus_.controller, now);
  const SteadyTime common_due = tell_common({.controller = bus_.controller,
                                             .timestamps = bus_.timestamps,
                                             .in_run = bus_.claim == j1939::ClaimState::claimed},
                                            jobs_, now);
  const bool changed = bus_.claim != before.claim || bus_.address != before.address;
  if (now < next_status_ && !changed) return std::min(common_due, next_status_);
  next_status_ = now + kStatusPeriod;
  told_status_ = node_status();
  (void)status_.write(told_status_);
  return std::min(common_due, next_status_);
}

j1939_NodeStatus MessageGateway::node_status() const {
  j1939_NodeStatus sample = {};
  sample.time = wall_clock_now();
  gateway::dds::copy_text(j1939::dds::name_of(bus_.claim), sample.claim_state);
  sample.address = bus_.address;
  sample.node_name = j1939::compose(config_.name);
  sample.name_twice = bus_.name_twice;
  sample.addresses_lost = bus_.losses;
  sample.intruders = bus_.intruders;
  sample.bus_load = bus_.bus_load;
  sample.received = bus_.counters.frames;
  sample.foreign = bus_.counters.foreign;
  sample.messages = bus_.counters.messages;
  sample.taken = bus_.counters.taken;
  sample.lost = bus_.lost + unwritten_;
  sample.packets_completed = bus_.packets.completed;
  sample.packets_broken = bus_.packets.broken;
  sample.packets_refused = bus_.packets.refused();
  sample.declined_length = bus_.counters.wrong_length + bus_.packets.wrong_length;
  sample.declined_unknown = bus_.counters.unknown;
  sample.declined_impossible = bus_.packets.impossible;
  sample.declined_busy = bus_.packets.busy;
  sample.declined_no_room = bus_.packets.no_room;
  sample.transports = bus_.transports;
  sample.sent = bus_.counters.sent;
  sample.unanswered = bus_.counters.unanswered;
  sample.not_sent = bus_.counters.not_sent;
  sample.answers_lost = bus_.answers_lost;
  sample.groups_left_out = bus_.groups_left_out;
  sample.waiting = bus_.waiting;
  sample.send_timeout = static_cast<std::uint32_t>(config_.send.timeout.count());
  return sample;
}

void MessageGateway::end() {
  take_answers(context(steady_clock::now()));
  while (publish_messages()) {
  }  // the realtime thread has ended: the ring grows no more
  posted_.publish(events_, steady_clock::now());
  jobs_.stop_and_deliver(signal_, [this] { return context(steady_clock::now()); });
}

}  // namespace cansyncd
