#include "j1939/client/message_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/reply_partition.h"
#include "dds/security.h"
#include "j1939/dds/convert.h"

namespace j1939::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Waiting is looked at again so often: `stop` is seen soon.
constexpr milliseconds kLook{20};
/// From the end of a request's monitoring time to its reply, and from a cancel to it.
constexpr milliseconds kGrace{5000};
/// For an answer in packets that is coming when the monitoring time ends: 255 of them, each within T1.
constexpr milliseconds kLongestAnswer{240'000};
/// For the monitoring time of a daemon that has not told its own.
constexpr milliseconds kDefaultMonitoring{1000};

/// Replies that come after their request was given up must be taken too, for a full reader holds up all
/// topics.
constexpr std::uint64_t kNobodysRequest = 0;

}  // namespace

MessageClient::MessageClient(const Options& options)
    : options_(options),
      identity_(gateway::dds::random_client_identity()),
      participant_(options.participant()),
      replies_(participant_, gateway::dds::Partitions{gateway::dds::reply_partition(options.bus, identity_)},
               &signal_),
      batches_(participant_, &signal_),
      long_messages_(participant_, &signal_),
      status_(participant_, &signal_),
      tables_(participant_, &signal_),
      faults_(participant_, &signal_),
      bus_reader_(participant_, &signal_),
      sight_(participant_, signal_, options.bus),
      requests_(participant_, 0, &signal_),
      cancels_(participant_, 0, &signal_) {
  sight_.find(
      options, signal_, "j1939", {.requests = {&requests_, &cancels_}, .replies = {&replies_}},
      [this] { return matched(); }, [this] { return status_.matched() != 0; });
}

bool MessageClient::matched() const noexcept {
  return batches_.matched() != 0 && status_.matched() != 0 && tables_.matched() != 0 &&
         faults_.matched() != 0;
}

std::optional<Result> MessageClient::obstacle() {
  auto found = sight_.obstacle();
  if (!found) return std::nullopt;
  Result result;
  result.replied = !found->gone;
  result.code = found->gone ? gateway_REPLY_DONE : gateway_REPLY_REFUSED;
  result.cause = found->gone ? gateway_CAUSE_NONE : gateway_CAUSE_OTHER_DAEMON;
  result.reason = std::move(found->reason);
  return result;
}

Begun MessageClient::begin(j1939_MessageKind kind, const Message& message, std::uint32_t timeout_ms) {
  if (auto problem = obstacle()) return {0, *std::move(problem)};
  j1939_MessageRequest request = {};
  std::copy(identity_.begin(), identity_.end(), std::begin(request.client));
  request.request = ++number_;
  gateway::dds::copy_text(options_.client_name, request.client_name);
  gateway::dds::set_daemon(sight_.choice().daemon(), request);
  request.kind = kind;
  request.pgn = message.pgn;
  request.priority = message.priority;
  request.destination = message.destination;
  std::vector<std::uint8_t> data = message.data;
  const auto lend = [&data](auto& to) {  // for the call
    to._length = static_cast<std::uint32_t>(data.size());
    to._maximum = to._length;
    to._buffer = data.data();
  };
  if (data.size() > j1939_MESSAGE_BYTES) {
    lend(request.long_data);
  } else {
    lend(request.data);
  }
  request.timeout = timeout_ms;
  if (const auto code = requests_.write(request); code != DDS_RETCODE_OK) {
    const bool forbidden = code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY;
    const bool full = code == DDS_RETCODE_TIMEOUT;
    Result result;
    result.replied = true;
    result.code = gateway_REPLY_REFUSED;
    result.cause =
        forbidden ? gateway_CAUSE_RIGHT : (full ? gateway_CAUSE_SHARED_LIMIT : gateway_CAUSE_UNKNOWN);
    result.reason =
        forbidden ? gateway::dds::no_right(gateway::dds::topic_info<j1939_MessageRequest>.name, "operator")
                  : fmt::format("the request could not be written: {}", dds_strretcode(code));
    return {0, std::move(result)};
  }
  return {request.request, std::nullopt};
}

Result MessageClient::request(j1939_MessageKind kind, const Message& message, std::uint32_t timeout_ms) {
  sight_.look_until_reached(options_, signal_);
  Begun begun = begin(kind, message, timeout_ms);
  if (begun.not_begun) return *std::move(begun.not_begun);
  const auto by_default = newest_ ? milliseconds(newest_->send_timeout) : kDefaultMonitoring;
  const auto monitoring =
      timeout_ms != 0
          ? milliseconds(timeout_ms)
          : std::chrono::duration_cast<milliseconds>(dds::monitoring_time(message.data.size(), by_default));
  const bool is_answered = kind == j1939_MESSAGE_ASK && message.destination != kGlobalAddress;
  return await_reply(begun.request, monitoring + (is_answered ? kLongestAnswer : kGrace));
}

bool MessageClient::may_answer(const gateway::dds::DaemonIdentity& daemon) {
  if (sight_.choice().may_answer(daemon)) return true;
  sight_.choice().program_told();
  return false;
}

Result MessageClient::await_reply(std::uint64_t request, milliseconds longest) {
  const auto daemon = sight_.choice().daemon();
  const auto without_reply = [](std::string reason) {
    Result result;
    result.reason = std::move(reason);
    return result;
  };
  auto end = steady_clock::now() + longest;
  bool cancelled = false;
  while (!cancelled || steady_clock::now() < end) {
    if (auto result = take_reply(request)) return *std::move(result);
    if (!may_answer(daemon)) return without_reply("the daemon has gone");
    if (!cancelled && (options_.stopped() || steady_clock::now() >= end)) {
      cancelled = true;
      cancel(request, daemon);
      end = steady_clock::now() + kGrace;
    }
    (void)signal_.wait(static_cast<int>(kLook.count()));
    signal_.clear();
  }
  return without_reply("the daemon did not answer");
}

std::optional<Result> MessageClient::take_reply(std::uint64_t request) {
  sight_.look();
  std::optional<Result> found;
  take_replies([&](std::uint64_t number, const Result& result) {
    if (number == request) found = result;
  });
  return found;
}

void MessageClient::take_replies(const std::function<void(std::uint64_t, const Result&)>& ended) {
  replies_.take([&](const j1939_MessageReply& reply) {
    if (!std::equal(identity_.begin(), identity_.end(), reply.client)) return;
    Result got;
    got.replied = true;
    got.code = reply.code;
    got.cause = reply.cause;
    got.reason = gateway::dds::text(reply.reason);
    got.sent_time = reply.sent_time;
    got.answer_code = reply.answer_code;
    got.data.assign(reply.data._buffer, reply.data._buffer + reply.data._length);
    got.data.insert(got.data.end(), reply.long_data._buffer,
                    reply.long_data._buffer + reply.long_data._length);
    ended(reply.request, got);
  });
}

void MessageClient::look(const Listener& listener) {
  sight_.look();
  take_replies([&](std::uint64_t number, const Result& result) {
    if (listener.ended) listener.ended(number, result);
  });
  batches_.take([&](const j1939_MessageBatch& batch) {
    if (listener.batch) listener.batch(batch);
  });
  status_.take([this](const j1939_NodeStatus& sample) { newest_ = sample; });
}

const std::optional<gateway_BusStatus>& MessageClient::bus_status() {
  bus_reader_.take([this](const gateway_BusStatus& sample) { bus_ = sample; });
  return bus_;
}

void MessageClient::cancel(std::uint64_t request, const gateway::dds::DaemonIdentity& daemon) {
  gateway_JobCancel sample = {};
  std::copy(identity_.begin(), identity_.end(), std::begin(sample.client));
  sample.request = request;
  gateway::dds::set_daemon(daemon, sample);
  (void)cancels_.write(sample);
}

void MessageClient::take_state() {
  (void)take_reply(kNobodysRequest);
  status_.take([this](const j1939_NodeStatus& sample) { newest_ = sample; });
  tables_.take([this](const j1939_AddressTable& sample) {
    addresses_.emplace(sample.addresses._buffer, sample.addresses._buffer + sample.addresses._length);
  });
  faults_.take([this](const j1939_FaultList& sample) {
    Faults& faults = told_[{sample.source, sample.active}];
    faults.codes.assign(sample.codes._buffer, sample.codes._buffer + sample.codes._length);
    faults.list = sample;
    faults.list.codes = {};
  });
}

bool MessageClient::receive(milliseconds time, const std::function<void(const j1939_MessageBatch&)>& on_batch,
                            const std::function<void(const j1939_LongMessage&)>& on_long) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    take_state();
    const bool came = batches_.take(on_batch) > 0;
    const auto longest = long_messages_.take([&](const j1939_LongMessage& message) {
      if (on_long) on_long(message);
    });
    if (came || longest > 0) return true;
    if (!daemon_present()) return false;
    const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now());
    if (left <= milliseconds{0} || options_.stopped()) return true;
    (void)signal_.wait(static_cast<int>(std::min(left, kLook).count()));
  }
}

void MessageClient::look_until(milliseconds time, const std::function<bool()>& there) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    take_state();
    batches_.take([](const j1939_MessageBatch&) {});
    long_messages_.take([](const j1939_LongMessage&) {});
    if (there() || options_.stopped() || !daemon_present() || steady_clock::now() >= end) return;
    (void)signal_.wait(static_cast<int>(kLook.count()));
  }
}

std::optional<j1939_NodeStatus> MessageClient::status(milliseconds time) {
  look_until(time, [this] { return newest_.has_value(); });
  return newest_;
}

std::optional<std::vector<j1939_ClaimedAddress>> MessageClient::addresses(milliseconds time) {
  look_until(time, [this] { return addresses_.has_value(); });
  return addresses_;
}

const std::map<std::pair<std::uint8_t, bool>, Faults>& MessageClient::faults(milliseconds time) {
  look_until(time, [] { return false; });
  return told_;
}

}  // namespace j1939::client
