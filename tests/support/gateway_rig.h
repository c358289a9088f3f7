#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "cansync.h"
#include "cansync/config/config.h"
#include "cansync/dds/convert.h"
#include "cansync/dds/topics.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/gateway.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "kept_journal.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

namespace cansyncd {

/// This start of the daemon.
inline constexpr DaemonIdentity kTestDaemon = {0xDA, 0xE0, 0x01};

/// A line of four named slaves, 0..3.
inline Config gateway_config() {
  Config config;
  config.bus.name = "testbus";
  config.dds.partition = "testbus";
  const char* names[] = {"unwinder", "feeder", "cutter", "rewinder"};
  for (unsigned i = 0; i < 4; ++i) {
    config.master.slaves[i].configured = true;
    config.slaves[i].name = names[i];
  }
  config.slaves[1].actual[0] = {"speed", "1/min", 0.5, 10.0};
  config.references[2] = {"draw", "%", 0.01, 0.0};
  // On a loaded machine samples may take long; tests of stale ones switch this on.
  config.failsafe.reference_max_age = std::chrono::milliseconds(0);
  return config;
}

/// The other end of DDS: every topic read and written raw, without the client library. What arrives is kept.
class TestClient {
 public:
  using Identity = std::array<std::uint8_t, 16>;

  explicit TestClient(const gateway::dds::ParticipantOptions& options) : participant_(options) {}

  template <class T>
  void write(const T& sample) {
    ASSERT_EQ(writer<T>().write(sample), DDS_RETCODE_OK);
  }

  /// Writes as if at another time.
  template <class T>
  void write_at(const T& sample, dds_time_t written) {
    ASSERT_EQ(dds_write_ts(writer<T>().handle(), &sample, written), DDS_RETCODE_OK);
  }

  /// Writes and waits until the gateway's reader has it.
  template <class T>
  void deliver(const T& sample) {
    write(sample);
    ASSERT_EQ(dds_wait_for_acks(writer<T>().handle(), DDS_SECS(20)), DDS_RETCODE_OK);
  }

  /// Everything that has arrived on a topic so far.
  template <class T>
  std::vector<T>& all() {
    auto& inbox = std::get<Inbox<T>>(inboxes_);
    inbox.reader.take([&](const T& sample) { inbox.samples.push_back(sample); });
    return inbox.samples;
  }
  /// Waits until a sample fits; nothing when none does in time.
  template <class T, class Fits>
  std::optional<T> wait_for(Fits&& fits) {
    std::optional<T> found;
    (void)eventually(signal_, [&] {
      for (const T& sample : all<T>()) {
        if (!fits(sample)) continue;
        found = sample;
        return true;
      }
      return false;
    });
    return found;
  }
  /// All events by number once there are `count`, or those there are after 20 s. Each level has a writer of
  /// its own, so that one's event may come before an earlier one of another's.
  std::vector<gateway_Event> events(std::size_t count) {
    (void)eventually(signal_, [&] { return all<gateway_Event>().size() >= count; });
    std::vector<gateway_Event> found = all<gateway_Event>();
    std::sort(found.begin(), found.end(),
              [](const gateway_Event& a, const gateway_Event& b) { return a.number < b.number; });
    return found;
  }
  /// Like `wait_for`, for best-effort topics: `again` makes the gateway publish once more, because it may not
  /// have found this client's reader yet.
  template <class T, class Again, class Fits>
  std::optional<T> ask_for(Again&& again, Fits&& fits) {
    constexpr int kPatience = 20;
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (std::chrono::steady_clock::now() < end) {
      again();
      (void)signal_.wait(kPatience);
      signal_.clear();
      for (const T& sample : all<T>()) {
        if (fits(sample)) return sample;
      }
    }
    return std::nullopt;
  }
  /// Waits for the reply to a request and takes it out, so that a second one would be found again.
  template <class T>
  std::optional<T> reply(std::uint64_t request, const Identity& client = identity(1)) {
    auto found = wait_for<T>([&](const T& sample) { return fits(sample, request, client); });
    if (found) {
      auto& samples = all<T>();
      samples.erase(std::find_if(samples.begin(), samples.end(),
                                 [&](const T& sample) { return fits(sample, request, client); }));
    }
    return found;
  }
  /// Replies to a request that are here now.
  template <class T>
  std::size_t replies(std::uint64_t request, const Identity& client = identity(1)) {
    auto& samples = all<T>();
    return static_cast<std::size_t>(std::count_if(
        samples.begin(), samples.end(), [&](const T& sample) { return fits(sample, request, client); }));
  }

  /// True while DDS keeps the sample's key in our reader of its topic.
  template <class T>
  bool keeps_key(const T& sample) const {
    const dds_entity_t reader = std::get<Inbox<T>>(inboxes_).reader.handle();
    const dds_instance_handle_t key = dds_lookup_instance(reader, &sample);
    if (key == DDS_HANDLE_NIL) return false;
    std::array<void*, gateway::dds::ReaderBase::kBatch> lent = {};
    dds_sample_info_t info;
    const dds_return_t count = dds_read_instance(reader, lent.data(), &info, 1, 1, key);
    if (count > 0) (void)dds_return_loan(reader, lent.data(), count);
    return count != DDS_RETCODE_PRECONDITION_NOT_MET;
  }

  /// Waits until the gateway's side is matched on every topic, and knows every reader here.
  bool wait_for_gateway() {
    // DDS tells of readers in their order: who writes to this one knows those before it.
    gateway::dds::Reader<gateway_GatewayStatus> last(participant_, &signal_);
    bool known = false;
    return eventually(signal_, [&] {
      known = last.take([](const gateway_GatewayStatus&) {}) > 0 || known;
      if (!known) return false;
      return std::apply([](const auto&... inbox) { return ((inbox.reader.matched() > 0) && ...); },
                        inboxes_) &&
             std::apply([](const auto&... out) { return ((out.matched() > 0) && ...); }, writers_);
    });
  }
  /// Waits until the gateway's side is gone on every topic: what is written then waits for no dead reader.
  bool wait_until_gone() {
    return eventually(signal_, [&] {
      return std::apply([](const auto&... inbox) { return ((inbox.reader.matched() == 0) && ...); },
                        inboxes_) &&
             std::apply([](const auto&... out) { return ((out.matched() == 0) && ...); }, writers_);
    });
  }

  static Identity identity(std::uint8_t n) {
    Identity id = {};
    id[0] = n;
    return id;
  }
  template <class T>
  static T request(std::uint64_t number, const Identity& client = identity(1)) {
    T sample = {};
    std::copy(client.begin(), client.end(), std::begin(sample.client));
    sample.request = number;
    if constexpr (requires { sample.client_name; }) gateway::dds::copy_text("tester", sample.client_name);
    gateway::dds::set_daemon(kTestDaemon, sample);
    return sample;
  }

  const gateway::dds::Participant& participant() const { return participant_; }
  gateway::dds::DataSignal& signal() { return signal_; }

 private:
  template <class T>
  struct Inbox {
    explicit Inbox(TestClient& client)
        : reader(client.participant_, client.partitions<T>(), &client.signal_) {}
    gateway::dds::Reader<T> reader;
    std::vector<T> samples;
  };
  /// Replies are in partitions of their own.
  template <class T>
  gateway::dds::Partitions partitions() const {
    if constexpr (requires(T sample) {
                    sample.client;
                    sample.request;
                  }) {
      return replies_to_all(participant_.options());
    } else {
      return {participant_.options().partition};
    }
  }
  template <class T>
  static bool fits(const T& sample, std::uint64_t request, const Identity& client) {
    return sample.request == request && std::equal(client.begin(), client.end(), std::begin(sample.client));
  }
  template <class T>
  gateway::dds::Writer<T>& writer() {
    return std::get<gateway::dds::Writer<T>>(writers_);
  }
  template <class T>
  using Out = gateway::dds::Writer<T>;

  gateway::dds::Participant participant_;
  gateway::dds::DataSignal signal_;
  std::tuple<Inbox<cansync_ActualValues>, Inbox<cansync_Interval>, Inbox<cansync_ParameterReply>,
             Inbox<cansync_TransferProgress>, Inbox<cansync_CommandReply>, Inbox<cansync_MasterStatus>,
             Inbox<cansync_SlaveStatus>, Inbox<cansync_Timing>, Inbox<gateway_GatewayStatus>,
             Inbox<gateway_BusStatus>, Inbox<gateway_RealtimeStatus>, Inbox<gateway_Event>>
      inboxes_{Inbox<cansync_ActualValues>(*this),   Inbox<cansync_Interval>(*this),
               Inbox<cansync_ParameterReply>(*this), Inbox<cansync_TransferProgress>(*this),
               Inbox<cansync_CommandReply>(*this),   Inbox<cansync_MasterStatus>(*this),
               Inbox<cansync_SlaveStatus>(*this),    Inbox<cansync_Timing>(*this),
               Inbox<gateway_GatewayStatus>(*this),  Inbox<gateway_BusStatus>(*this),
               Inbox<gateway_RealtimeStatus>(*this), Inbox<gateway_Event>(*this)};
  std::tuple<Out<cansync_ParameterRequest>, Out<cansync_TransferRequest>, Out<gateway_JobCancel>,
             Out<cansync_Command>>
      writers_{Out<cansync_ParameterRequest>(participant_, 0, &signal_),
               Out<cansync_TransferRequest>(participant_, 0, &signal_),
               Out<gateway_JobCancel>(participant_, 0, &signal_),
               Out<cansync_Command>(participant_, 0, &signal_)};
};

/// A transfer reply with its data copied, because Cyclone's own is lent for a moment only.
struct TransferAnswer {
  cansync_TransferReply reply;
  std::vector<std::uint8_t> data;
};

/// A gateway in one place, a client in another, and the test as the realtime thread between them. `sink`
/// takes what would go to the journal in the place of `journal`.
class GatewayRig {
 public:
  explicit GatewayRig(const Config& config = gateway_config(), const ExchangeSizes& sizes = {},
                      const rt::RealtimeSettings& wanted = {}, const rt::Grants& granted = {},
                      JournalSink* sink = nullptr)
      : exchange(sizes),
        participant_(places_.here),
        gateway(std::make_unique<Gateway>(config, exchange, participant_, sink != nullptr ? *sink : journal,
                                          kTestDaemon)),
        client(places_.there),
        transfer_replies_(client.participant(), replies_to_all(client.participant().options()),
                          &client.signal()) {
    gateway->set_realtime(wanted, granted);
    gateway->start();
    EXPECT_TRUE(client.wait_for_gateway());
    EXPECT_TRUE(eventually(client.signal(), [&] { return transfer_replies_.matched() > 0; }));
  }

  /// The next request that reached the realtime side; fails when none comes, or one of another kind.
  template <class T>
  T expect_request() {
    const auto request = next_request();
    EXPECT_TRUE(request) << "no request within the deadline";
    if (!request) return {};
    EXPECT_TRUE(std::holds_alternative<T>(*request)) << "request of kind " << request->index();
    const T* fitting = std::get_if<T>(&*request);
    return fitting != nullptr ? *fitting : T{};
  }
  std::optional<Request> next_request() {
    Request request;
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (!exchange.requests.try_pop(request)) {
      if (std::chrono::steady_clock::now() > end) return std::nullopt;
      std::this_thread::yield();
    }
    return request;
  }

  void answer(const Terminal& terminal) {
    ASSERT_TRUE(exchange.terminals.try_push(terminal));
    exchange.gateway_wake.signal();
  }
  void report(const Report& what) {
    ASSERT_TRUE(exchange.reports.try_push(what));
    exchange.gateway_wake.signal();
  }
  /// Tells the state of the line, as the realtime thread does every interval.
  void tell(const MasterSnapshot& master) {
    exchange.master.write(master);
    exchange.gateway_wake.signal();
  }

  std::optional<TransferAnswer> transfer_reply(std::uint64_t request) {
    std::optional<TransferAnswer> found;
    (void)eventually(client.signal(), [&] {
      transfer_replies_.take([&](const cansync_TransferReply& reply) {
        if (reply.request != request) return;
        found = TransferAnswer{reply, {reply.data._buffer, reply.data._buffer + reply.data._length}};
      });
      return found.has_value();
    });
    return found;
  }

  TwoPlaces& places() { return places_; }

 private:
  TwoPlaces places_;

 public:
  Exchange exchange;
  KeptJournal journal;

 private:
  gateway::dds::Participant participant_;

 public:
  std::unique_ptr<Gateway> gateway;
  TestClient client;

 private:
  gateway::dds::Reader<cansync_TransferReply> transfer_replies_;
};

/// An interval, with its end on the wall clock.
inline Moment moment(cansync::IntervalNumber interval) {
  return {interval, can::Time(interval * 1'000'000),
          can::Time(1'700'000'000'000'000'000 + interval * 1'000'000)};
}

inline cansync::SlaveNumber slave(std::uint8_t number) {
  return *cansync::SlaveNumber::from(number);
}

}  // namespace cansyncd
