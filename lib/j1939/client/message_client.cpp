#include "j1939/client/message_client.h"

#include <utility>

#include "j1939/dds/convert.h"

namespace j1939::client {
namespace {

using std::chrono::milliseconds;

/// For an answer in packets that is coming when the monitoring time ends: 255 of them, each within T1.
constexpr milliseconds kLongestAnswer{240'000};

}  // namespace

MessageClient::MessageClient(const Options& options)
    : RequestClient(options),
      replies_(participant(), reply_partitions(), &signal()),
      batches_(participant(), &signal()),
      long_messages_(participant(), &signal()),
      status_(participant(), &signal()),
      tables_(participant(), &signal()),
      faults_(participant(), &signal()),
      requests_(participant(), 0, &signal()),
      cancels_(participant(), 0, &signal()) {
  connect(
      "j1939", &replies_, {.requests = {&requests_, &cancels_}, .replies = {&replies_}},
      [this] { return matched(); }, [this] { return status_.matched() != 0; });
}

bool MessageClient::matched() const noexcept {
  return batches_.matched() != 0 && status_.matched() != 0 && tables_.matched() != 0 &&
         faults_.matched() != 0;
}

Begun MessageClient::begin(j1939_MessageKind kind, const Message& message, std::uint32_t timeout_ms) {
  j1939_MessageRequest request = {};
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
  return RequestClient::begin(requests_, request, "operator");
}

Result MessageClient::request(j1939_MessageKind kind, const Message& message, std::uint32_t timeout_ms) {
  look_until_reached();
  const Begun begun = begin(kind, message, timeout_ms);
  const auto by_default = newest_status() ? milliseconds(newest_status()->send_timeout) : kDefaultMonitoring;
  const auto monitoring =
      timeout_ms != 0
          ? milliseconds(timeout_ms)
          : std::chrono::duration_cast<milliseconds>(dds::monitoring_time(message.data.size(), by_default));
  const bool is_answered = kind == j1939_MESSAGE_ASK && message.destination != kGlobalAddress;
  return await<Result>(begun, monitoring + (is_answered ? kLongestAnswer : kGrace), cancels_,
                       [this](const auto& ended) { take_replies(ended); });
}

void MessageClient::take_replies(const std::function<void(std::uint64_t, const Result&)>& ended) {
  replies_.take([&](const j1939_MessageReply& reply) {
    Result got;
    got.sent_time = reply.sent_time;
    got.answer_code = reply.answer_code;
    got.data.assign(reply.data._buffer, reply.data._buffer + reply.data._length);
    got.data.insert(got.data.end(), reply.long_data._buffer,
                    reply.long_data._buffer + reply.long_data._length);
    hand_on(reply, std::move(got), ended);
  });
}

void MessageClient::look(const Listener& listener) {
  sight().look();
  take_replies([&](std::uint64_t number, const Result& result) {
    if (listener.ended) listener.ended(number, result);
  });
  batches_.take([&](const j1939_MessageBatch& batch) {
    if (listener.batch) listener.batch(batch);
  });
  (void)newest_.take(status_);
}

void MessageClient::take_state() {
  sight().look();
  take_replies([](std::uint64_t, const Result&) {});  // of requests that were given up
  (void)newest_.take(status_);
  tables_.take(
      [this](const j1939_AddressTable& sample) {
        addresses_.emplace(sample.addresses._buffer, sample.addresses._buffer + sample.addresses._length);
      },
      [this](const j1939_AddressTable& /*gone*/) { addresses_.reset(); });
  faults_.take(
      [this](const j1939_FaultList& sample) {
        Faults& faults = told_[{sample.source, sample.active}];
        faults.codes.assign(sample.codes._buffer, sample.codes._buffer + sample.codes._length);
        faults.list = sample;
        faults.list.codes = {};
      },
      [this](const j1939_FaultList& gone) {
        told_.erase({gone.source, gone.active});
      });
}

bool MessageClient::receive(milliseconds time, const std::function<void(const j1939_MessageBatch&)>& on_batch,
                            const std::function<void(const j1939_LongMessage&)>& on_long) {
  return wait_until(time, [&] {
    take_state();
    const bool came = batches_.take(on_batch) > 0;
    const auto longest = long_messages_.take([&](const j1939_LongMessage& message) {
      if (on_long) on_long(message);
    });
    return came || longest > 0;
  });
}

void MessageClient::look_until(milliseconds time, const std::function<bool()>& there) {
  (void)wait_until(time, [&] {
    take_state();
    batches_.take([](const j1939_MessageBatch&) {});
    long_messages_.take([](const j1939_LongMessage&) {});
    return there();
  });
}

std::optional<j1939_NodeStatus> MessageClient::status(milliseconds time) {
  look_until(time, [this] { return newest_status().has_value(); });
  return newest_status();
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
