#include "daemon/cansync_slave/gateway/application_gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "cansync_slave/dds/convert.h"
#include "cansync_slave/dds/topics.h"
#include "cansync_slave/dds/validate.h"
#include "dds/daemon_identity.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

using gateway::dds::Denial;

/// Without room for an order the gate tries again after so long.
constexpr std::chrono::milliseconds kOrderRetry{10};

TakeOver take_over_of(const cansync_slave_ApplicationAnswer& sample) {
  TakeOver order;
  order.present = true;
  order.blocks = sample.blocks;
  order.taken.sub_slaves = sample.sub_slaves;
  for (std::uint32_t i = 0; i < sample.parameters._length; ++i)
    order.taken.numbers.set(sample.parameters._buffer[i]);
  return order;
}

bool same(const TakeOver& a, const TakeOver& b) {
  return a.blocks == b.blocks && a.taken.sub_slaves == b.taken.sub_slaves &&
         a.taken.numbers == b.taken.numbers;
}

gateway::dds::Problem status_word_taken(const cansync_slave_ApplicationAnswer& sample, std::uint16_t number) {
  const std::span numbers(sample.parameters._buffer, sample.parameters._length);
  if (std::find(numbers.begin(), numbers.end(), number) == numbers.end()) return std::nullopt;
  return Denial{gateway_CAUSE_FIELD,
                fmt::format("parameters: found {}, which is slave.status_parameter and answered with the "
                            "status word; allowed: other numbers",
                            number)};
}

BlockReply::Kind kind_of(cansync_slave_AnswerKind kind) noexcept {
  switch (kind) {
    case cansync_slave_ANSWER_BLOCK_ALLOWED:
      return BlockReply::Kind::allow;
    case cansync_slave_ANSWER_BLOCK_TAKEN:
      return BlockReply::Kind::take;
    case cansync_slave_ANSWER_BLOCK_STEP:
      return BlockReply::Kind::step;
    default:
      return BlockReply::Kind::refuse;
  }
}

ApplicationOrder order_of(const cansync_slave_ApplicationAnswer& sample) {
  if (sample.kind == cansync_slave_ANSWER_PARAMETER) {
    JobAnswer order;
    order.id = sample.job;
    order.answer.error = static_cast<cansync::ParameterError>(sample.error);
    order.answer.doubleword = sample.doubleword;
    order.answer.value = sample.value;
    return order;
  }
  BlockReply order;
  order.kind = kind_of(sample.kind);
  order.id = sample.job;
  order.error = static_cast<cansync::TransferError>(sample.error);
  order.length = sample.length;
  order.bytes = static_cast<std::uint16_t>(std::min<std::size_t>(sample.data._length, order.data.size()));
  std::copy_n(sample.data._buffer, order.bytes, order.data.begin());
  return order;
}

}  // namespace

ApplicationGate::ApplicationGate(const gateway::dds::Participant& participant,
                                 gateway::dds::DataSignal& signal, EventPublisher& events,
                                 const DaemonIdentity& daemon, std::uint16_t status_parameter,
                                 SlaveExchange& exchange)
    : reader_(participant, signal),
      events_(events),
      daemon_(daemon),
      status_parameter_(status_parameter),
      exchange_(exchange) {}

bool ApplicationGate::take_samples(SteadyTime now) {
  const bool more =
      reader_.take([](const Sample& /*sample*/) { return 0u; },
                   [](const Sample& sample) { return sample.kind == cansync_slave_ANSWER_GIVEN_UP; },
                   [&](const Sample& sample, const dds_sample_info_t& info) { take(sample, info, now); });
  if (reader_.lost(0, arbiter_))
    lost(reader_.left(arbiter_.owner().handle) ? "has gone without giving up" : "is silent", false, now);
  reader_.tell_dropped(events_, now);
  return more;
}

void ApplicationGate::take(const Sample& sample, const dds_sample_info_t& info, SteadyTime now) {
  if (sample.kind == cansync_slave_ANSWER_GIVEN_UP) {
    arbiter_.forget(info.publication_handle);
    if (arbiter_.owner().handle == info.publication_handle) lost("gives up", true, now);
    return;
  }
  if (const auto problem = problem_of(sample, info.publication_handle)) {
    refuse(*problem, now);
    return;
  }
  if (sample.kind == cansync_slave_ANSWER_PRESENT) {
    const TopicWriter writer = reader_.writer_of(sample, info.publication_handle);
    if (arbiter_.claim(writer.handle, writer.identity.strength) == WriterArbiter::Claim::waits) {
      tell_waiting(events_, arbiter_, writer, now);
      return;
    }
    heard_ = now;
    take_over(sample, writer, now);
    return;
  }
  heard_ = now;
  if (!flush() || !exchange_.orders.try_push(order_of(sample)))
    refuse({gateway_CAUSE_QUEUE_FULL, "too many answers wait for the realtime thread; give fewer"}, now);
}

gateway::dds::Problem ApplicationGate::problem_of(const Sample& sample, WriterHandle writer) const {
  if (auto wrong = cansync_slave::dds::check(sample)) return wrong;
  if (read_only_)
    return Denial{
        gateway_CAUSE_READ_ONLY,
        "the daemon is read-only; set access.read_only to false in the configuration and reload the daemon"};
  if (sample.kind == cansync_slave_ANSWER_PRESENT) return status_word_taken(sample, status_parameter_);
  if (arbiter_.owner().handle != writer)
    return Denial{gateway_CAUSE_WRONG_STATE,
                  "its writer has taken over nothing; let the program say that it is present first"};
  if (gateway::dds::addressee(gateway::dds::daemon_of(sample), daemon_) !=
      gateway::dds::Addressee::this_daemon)
    return Denial{gateway_CAUSE_OTHER_DAEMON,
                  "meant for another start of the daemon; answer the jobs of this one, which name it"};
  return std::nullopt;
}

void ApplicationGate::take_over(const Sample& sample, const TopicWriter& writer, SteadyTime now) {
  TakeOver order = take_over_of(sample);
  order.same_application = arbiter_.owner().handle == writer.handle;
  if (order.same_application && same(order, taken_)) return;
  if (!order.same_application) {
    const gateway::dds::WriterIdentity& who = writer.identity;
    const bool first = arbiter_.owner().handle == 0;
    EventText event{
        first ? gateway_SEVERITY_INFO : gateway_SEVERITY_WARNING, "application_began", -1,
        fmt::format("{} (strength {}) answers for {}{}{}", who.who, who.strength,
                    text::counted(order.taken.numbers.count(), "parameter"),
                    order.blocks ? " and for blocks" : "", first ? "" : ", in place of " + name()),
        std::nullopt};
    event.client = who.who;
    events_.publish(event, now);
    arbiter_.give(writer);
  }
  taken_ = order;
  // What waits was never told: this is the first the realtime thread hears of the change.
  if (waiting_) order.same_application = order.same_application && waiting_->same_application;
  waiting_ = order;
  (void)flush();
}

void ApplicationGate::set_read_only(bool read_only, SteadyTime now) {
  read_only_ = read_only;
  if (read_only) lost("is not heard while access.read_only is set", true, now);
}

/// True: nothing waits any more.
bool ApplicationGate::flush() {
  if (waiting_ && exchange_.orders.try_push(*waiting_)) waiting_.reset();
  return !waiting_;
}

void ApplicationGate::lost(const char* how, bool wanted, SteadyTime now) {
  if (arbiter_.owner().handle == 0) return;
  EventText event{wanted ? gateway_SEVERITY_INFO : gateway_SEVERITY_ERROR, "application_lost", -1,
                  fmt::format("{} {}: the slave answers without it, as configured", name(), how),
                  std::nullopt};
  event.client = name();
  events_.publish(event, now);
  arbiter_.free();
  taken_ = {};
  waiting_ = TakeOver{};
  (void)flush();
}

void ApplicationGate::refuse(const Denial& denial, SteadyTime now) {
  if (!refusals_.add(1, now)) return;
  events_.publish({gateway_SEVERITY_WARNING, "application_refused", -1,
                   fmt::format("what an application says is not taken: {}", denial.reason), std::nullopt},
                  now);
}

std::optional<SteadyTime> ApplicationGate::tick(SteadyTime now) {
  (void)refusals_.take_over(now);
  if (arbiter_.owner().handle != 0 && now - heard_ > kSilence) lost("is silent", false, now);
  std::optional<SteadyTime> due = refusals_.next();
  const auto earlier = [&due](SteadyTime at) { due = due ? std::min(*due, at) : at; };
  if (!flush()) earlier(now + kOrderRetry);
  if (arbiter_.owner().handle != 0) earlier(heard_ + kSilence + kOrderRetry);
  return due;
}

}  // namespace cansyncd
