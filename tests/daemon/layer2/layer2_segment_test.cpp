// The whole of a bus of general frames but for the main program: realtime thread on a simulated bus in real
// time, gateway thread, and a client over real DDS.
#include "daemon/layer2/segment/layer2_segment.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "can/flagged_frames.h"
#include "daemon/layer2/gateway/frame_gateway.h"
#include "daemon/layer2/layer2_bus.h"
#include "daemon/layer2/segment/layer2_protocol.h"
#include "dds/bounded_text.h"
#include "support/long_wait.h"

namespace cansyncd {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using layer2::client::FrameClient;
using layer2::client::SendResult;
using std::chrono::milliseconds;
using std::chrono::seconds;

using Layer2Bus = Layer2BusTest;

TEST_F(Layer2Bus, SendsFramesOfEveryKindWithOneReplyEach) {
  start();
  std::int64_t before = 0;
  for (const can::Frame& frame : can::test::four_kinds()) {
    const SendResult result = client_->send(frame, 0);
    EXPECT_TRUE(result.replied);
    EXPECT_EQ(result.code, gateway_REPLY_DONE) << result.reason;
    EXPECT_GT(result.sent_time, before);
    before = result.sent_time;
  }
  segment_->stop();
  unsigned recorded = 0;
  for (const auto& entry : journal_.all()) recorded += entry.field("EVENT") == "request_done" ? 1u : 0u;
  EXPECT_EQ(recorded, can::test::four_kinds().size());
}

TEST_F(Layer2Bus, PublishesWhatItsRangesTakeInTheOrderOfTheBus) {
  start();
  EXPECT_TRUE(comes([](const can::Frame& frame, const layer2_ReceivedFrame& received) {
    return frame.id == 0x150 && frame.data[1] == 9 && received.range_index == 0 && frame.data[0] >= 2;
  }));
  std::int64_t before = 0;
  for (const layer2_ReceivedFrame& frame : seen_) {
    EXPECT_EQ(frame.received.identifier, 0x150u);  // nothing of 0x250
    EXPECT_GT(frame.receive_time, before);
    before = frame.receive_time;
  }
}

TEST_F(Layer2Bus, ARemoteFrameBringsTheDataOfTheNodeThatHasIt) {
  start();
  const can::Frame asked = extended(remote(data_frame(0x18DAF110, {0, 0, 0})));
  EXPECT_EQ(client_->send(asked, 0).code, gateway_REPLY_DONE);
  EXPECT_TRUE(comes([](const can::Frame& frame, const layer2_ReceivedFrame& received) {
    return frame == extended(data_frame(0x18DAF110, {1, 2, 3})) && received.range_index == 1;
  }));
  for (const layer2_ReceivedFrame& frame : seen_) EXPECT_FALSE(frame.received.remote);  // not the own one
}

TEST_F(Layer2Bus, L5L12L22ControlOverDds) {
  Layer2File file = file_for(places_);
  layer2::TimerSettings sync;
  sync.frame = data_frame(0x80, {1});
  file.config.timers = {{3, sync}};
  start(std::move(file));
  const auto control = [&](layer2_ControlKind kind, std::uint8_t number) {
    layer2_ControlRequest request = {};
    request.kind = kind;
    request.number = number;
    return client_->control(request);
  };
  EXPECT_EQ(control(layer2_CONTROL_START_TIMER, 3).code, gateway_REPLY_DONE);
  EXPECT_EQ(control(layer2_CONTROL_START_TIMER, 4).cause, gateway_CAUSE_FIELD);
  EXPECT_EQ(control(layer2_CONTROL_START_TIMER, 17).reason, "number 17: no such timer; allowed 1..16");
  EXPECT_EQ(control(layer2_CONTROL_RESET_OVERFLOW, 0).code, gateway_REPLY_DONE);
  const auto timers = client_->timers(gateway::kLongWait);
  ASSERT_EQ(timers.size(), 1u);
  EXPECT_EQ(timers[0].number, 3);
  EXPECT_EQ(timers[0].content.identifier, 0x80u);
  EXPECT_EQ(control(layer2_CONTROL_STOP, 0).code, gateway_REPLY_DONE);
  EXPECT_EQ(client_->send(data_frame(0x123, {}), 0).cause, gateway_CAUSE_WRONG_STATE);
  EXPECT_EQ(control(layer2_CONTROL_RUN, 0).code, gateway_REPLY_DONE);
  EXPECT_EQ(client_->send(data_frame(0x123, {}), 0, {.high_priority = true}).code, gateway_REPLY_DONE);
}

TEST_F(Layer2Bus, ARequestThatIsWrongIsRefusedWithItsReason) {
  start();
  const SendResult result = client_->send(data_frame(0x123, {1}), 4'000'000);
  EXPECT_EQ(result.code, gateway_REPLY_REFUSED);
  EXPECT_EQ(result.reason,
            "timeout 4000000 ms: out of range; allowed 0..3600000 ms, 0 = the daemon's default");
}

TEST_F(Layer2Bus, AReadOnlyDaemonSendsNothing) {
  Layer2File file = file_for(places_);
  file.config.access.read_only = true;
  start(std::move(file));
  const SendResult result = client_->send(data_frame(0x123, {1}), 0);
  EXPECT_EQ(result.code, gateway_REPLY_REFUSED);
  EXPECT_NE(result.reason.find("access.read_only"), std::string::npos) << result.reason;
  EXPECT_TRUE(client_->gateway_status().read_only);
}

TEST_F(Layer2Bus, WhatWasReceivedBeforeTheStopIsPublished) {
  constexpr unsigned kFrames = 5000;  // more than one pass publishes
  const Layer2File file = file_for(places_);
  Layer2Exchange exchange(16, 2 * kFrames);
  const gateway::dds::Participant participant(places_.here);
  FrameGateway gateway(file, exchange, participant, journal_);
  gateway.start();
  client_.emplace(options_for(places_));
  // The gateway may know of the client's reader later than the client of the gateway's writer.
  bool heard = false;
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  while (!heard && std::chrono::steady_clock::now() < end) {
    ASSERT_TRUE(exchange.frames.try_push({data_frame(0x200, {}), can::Time{0}, 0}));
    ASSERT_TRUE(
        client_->receive(std::chrono::milliseconds(20), [&](const auto& /*batch*/) { heard = true; }));
  }
  ASSERT_TRUE(heard);
  seen_.clear();
  for (unsigned n = 0; n < kFrames; ++n)
    ASSERT_TRUE(exchange.frames.try_push({data_frame(0x100, {}), can::Time{1 + n}, 0}));
  gateway.stop();
  EXPECT_TRUE(comes([](const can::Frame&, const layer2_ReceivedFrame& received) {
    return received.receive_time == kFrames;
  }));
  EXPECT_EQ(
      std::count_if(seen_.begin(), seen_.end(),
                    [](const layer2_ReceivedFrame& frame) { return frame.received.identifier == 0x100; }),
      kFrames);
}

/// The realtime thread is this test, and takes what it likes.
TEST_F(Layer2Bus, FramesThatWaitForTheirTurnAreDeletedByAStopAndWithTheQueues) {
  Layer2File file = file_for(places_);
  file.config.run_follows = "leader";
  Layer2Exchange exchange(256, 16);
  const gateway::dds::Participant participant(places_.here);
  FrameGateway gateway(file, exchange, participant, journal_);
  gateway.start();
  client_.emplace(options_for(places_));
  const gateway::dds::Participant leader(places_.there);
  gateway::dds::Writer<layer2_RunLead> lead(leader);
  const auto next = [&] {
    Layer2Request request;
    EXPECT_TRUE(comes_true([&] { return exchange.requests.try_pop(request); }));
    return request;
  };
  const auto say = [&](bool run) {
    layer2_RunLead sample = {};
    gateway::dds::copy_text("leader", sample.client_name);
    std::ranges::copy(client_->gateway_status().daemon, std::begin(sample.daemon));
    sample.run = run;
    EXPECT_EQ(lead.write(sample), DDS_RETCODE_OK);
    return next();
  };
  const auto control = [&](layer2_ControlKind kind) {
    layer2_ControlRequest request = {};
    request.kind = kind;
    (void)client_->begin_control(request);
    return next();
  };
  const std::vector<std::function<Layer2Request()>> ways = {
      [&] { return control(layer2_CONTROL_CLEAR_QUEUES); }, [&] { return control(layer2_CONTROL_STOP); },
      [&] { return say(false); }};
  EXPECT_EQ(std::get<layer2::ControlOrder>(say(true)).what, layer2::Control::run);
  const std::vector<can::Frame> most(layer2_BATCH, data_frame(0x123, {1}));
  for (const auto& empty_the_queues : ways) {
    (void)client_->begin_send(most, 0);
    const auto first = std::get<layer2::SendOrder>(next());
    const auto second = client_->begin_send(most, 0);
    EXPECT_TRUE(std::holds_alternative<layer2::ControlOrder>(empty_the_queues()));
    std::optional<SendResult> ended;
    EXPECT_TRUE(comes_true([&] {
      client_->look({.ended = [&](std::uint64_t request, const SendResult& result) {
        if (request == second.request) ended = result;
      }});
      return ended.has_value();
    }));
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->code, gateway_REPLY_CANCELLED);
    EXPECT_EQ(ended->reason, "not sent: the queues were emptied");
    EXPECT_TRUE(exchange.done.try_push({.answer = {.id = first.id, .outcome = layer2::Outcome::deleted}}));
    exchange.gateway_wake.signal();
  }
  gateway.stop();
}

TEST_F(Layer2Bus, TellsWhichDaemonItIs) {
  start();
  const gateway_GatewayStatus first = client_->gateway_status();
  EXPECT_EQ(gateway::dds::text(first.bus), "layer2bus");
  EXPECT_EQ(gateway::dds::text(first.protocol), "layer2");
  EXPECT_EQ(first.process, static_cast<std::uint32_t>(getpid()));
  client_.reset();
  segment_.reset();
  start();
  EXPECT_FALSE(std::equal(std::begin(first.daemon), std::end(first.daemon), client_->gateway_status().daemon))
      << "another start";
}

TEST_F(Layer2Bus, TellsWhatEveryBusTells) {
  start();
  const gateway::dds::Participant participant(places_.there);
  gateway::dds::DataSignal signal;
  gateway::dds::Reader<gateway_BusStatus> bus_reader(participant, &signal);
  gateway::dds::Reader<gateway_RealtimeStatus> realtime_reader(participant, &signal);
  std::optional<gateway_BusStatus> bus;
  std::optional<gateway_RealtimeStatus> realtime;
  ASSERT_TRUE(eventually(signal, [&] {
    bus_reader.take([&](const gateway_BusStatus& sample) { bus = sample; });
    realtime_reader.take([&](const gateway_RealtimeStatus& sample) { realtime = sample; });
    return bus && realtime && gateway::dds::text(bus->timestamp_source) == "simulation";
  }));
  EXPECT_EQ(gateway::dds::text(bus->bus_interface), "sim");
  EXPECT_EQ(gateway::dds::text(bus->controller_state), "error-active");
  EXPECT_EQ(gateway::dds::text(bus->link_state), "up");
  EXPECT_EQ(bus->bit_rate, 500'000u);
  EXPECT_EQ(bus->sample_point_wanted, 0u) << "none is asked for";
  EXPECT_EQ(realtime->realtime_priority_wanted, 0);
  EXPECT_FALSE(realtime->memory_lock_wanted);
  EXPECT_EQ(gateway::dds::text(realtime->sync_output), "none");
}

TEST_F(Layer2Bus, TellsItsState) {
  start();
  EXPECT_EQ(client_->send(data_frame(0x123, {1}), 0).code, gateway_REPLY_DONE);
  std::optional<layer2_FrameStatus> status;
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  // The sample of the start has no counts yet.
  do {
    client_.emplace(options_for(places_));
    status = client_->status(gateway::kLongWait);
  } while (std::chrono::steady_clock::now() < end && (!status || status->sent == 0));
  ASSERT_TRUE(status);
  EXPECT_GT(status->time, 0);
  EXPECT_EQ(status->sent, 1u);
  EXPECT_EQ(status->send_timeout, 20'000u);
}

}  // namespace
}  // namespace cansyncd
