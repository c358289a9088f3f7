// Message objects over real DDS, on a simulated bus in real time.
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <vector>

#include "daemon/layer2/layer2_bus.h"
#include "dds/bounded_text.h"

namespace cansyncd {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using layer2::client::SendResult;
using std::chrono::milliseconds;

layer2_ObjectSettings receiver(std::uint8_t number, std::uint32_t identifier, std::uint32_t mask = 0x7FF) {
  layer2_ObjectSettings settings = {};
  settings.number = number;
  settings.identifier = identifier;
  settings.mask = mask;
  settings.tell = true;
  return settings;
}
layer2_ObjectSettings sender(std::uint8_t number, std::uint32_t identifier, std::uint32_t timeout = 0) {
  layer2_ObjectSettings settings = receiver(number, identifier);
  settings.transmit = true;
  settings.timeout = timeout;
  return settings;
}

class Layer2Objects : public Layer2BusTest {
 protected:
  SendResult configure(std::vector<layer2_ObjectSettings> settings, bool anew = false) {
    layer2_ObjectRequest request = {};
    request.action = layer2_OBJECT_CONFIGURE;
    request.anew = anew;
    request.settings._buffer = settings.data();
    request.settings._length = request.settings._maximum = static_cast<std::uint32_t>(settings.size());
    return client_->object(request);
  }
  SendResult job(std::uint8_t number, const can::Frame& frame, bool on_remote = false) {
    layer2_ObjectRequest request = {};
    request.action = layer2_OBJECT_SEND;
    request.number = number;
    request.content = layer2::dds::to_idl(frame);
    request.on_remote = request.every_time = on_remote;
    return client_->object(request);
  }
  SendResult read(std::uint8_t number, bool release = true, bool ask = false) {
    layer2_ObjectRequest request = {};
    request.action = layer2_OBJECT_READ;
    request.number = number;
    request.release = release;
    request.ask = ask;
    return client_->object(request);
  }
  /// Reads until there is a frame.
  SendResult fetched(std::uint8_t number) {
    SendResult result;
    EXPECT_TRUE(comes_true([&] { return (result = read(number)).fresh || !result.replied; }));
    return result;
  }
  /// What the daemon says of an object, once it fits.
  template <class Fits>
  layer2_ObjectStatus status(std::uint8_t number, const Fits& fits) {
    layer2_ObjectStatus found = {};
    EXPECT_TRUE(comes_true([&] {
      for (const layer2_ObjectStatus& object : client_->objects(milliseconds(50))) {
        if (object.number == number && fits(object)) {
          found = object;
          return true;
        }
      }
      return false;
    })) << int{number};
    return found;
  }
};

TEST_F(Layer2Objects, L33L40ObjectsOfTheFileReceiveByTheirMaskOnceTheyAreReleased) {
  Layer2File file = file_for(places_);
  file.config.objects = {{5, {{.identifier = 0x150, .mask = 0x7F0}, false, layer2::Time{0}, false}}};
  start(std::move(file));
  EXPECT_FALSE(read(5, false).fresh) << "closed";
  EXPECT_FALSE(read(5).fresh);  // opens it
  const SendResult result = fetched(5);
  EXPECT_EQ(result.code, gateway_REPLY_DONE);
  EXPECT_EQ(result.content.id, 0x150u);
  EXPECT_EQ(result.content.data[1], 9);
  EXPECT_GT(result.sent_time, 0);
  const auto object = status(5, [](const auto& state) { return state.full && state.received > 1; });
  EXPECT_EQ(object.mask, 0x7F0u);
  EXPECT_GT(object.time, result.sent_time);
  // What it does not take, because it is full, goes on to the ranges.
  EXPECT_TRUE(comes([](const can::Frame& frame, const auto&) { return frame.id == 0x150; }));
}

TEST_F(Layer2Objects, L34ConfiguredWhileItRunsAllOrNothing) {
  start();
  ASSERT_EQ(configure({sender(1, 0x300), receiver(2, 0x301)}).code, gateway_REPLY_DONE);
  SendResult result = configure({receiver(1, 0x310), sender(2, 0x800)}, true);
  EXPECT_EQ(result.code, gateway_REPLY_REFUSED);
  EXPECT_EQ(result.cause, gateway_CAUSE_FIELD);
  EXPECT_EQ(
      result.reason,
      "settings[1].identifier 0x800: out of range; allowed 0..0x7FF, or with extended up to 0x1FFFFFFF");
  EXPECT_EQ(configure({sender(32, 1)}).reason, "settings[0].number 32: no such object; allowed 0..31");
  EXPECT_EQ(configure({sender(3, 1, 3'600'001)}).cause, gateway_CAUSE_FIELD);
  EXPECT_EQ(job(1, data_frame(0x300, {1})).code, gateway_REPLY_DONE) << "it is as it was";
  ASSERT_EQ(configure({receiver(1, 0x300), sender(1, 0x320)}, true).code, gateway_REPLY_DONE);
  EXPECT_TRUE(status(1, [](const auto& state) { return state.identifier == 0x320; }).transmit);
  EXPECT_TRUE(comes_true([&] { return client_->objects(milliseconds(50)).size() == 1; })) << "2 is forgotten";
  EXPECT_EQ(read(2).cause, gateway_CAUSE_WRONG_STATE);
}

TEST_F(Layer2Objects, L34WhatBelongsToTheMappingIsRefusedWithItsPlace) {
  Layer2File file = file_for(places_);
  file.config.mapped = {{.identifier = 0x400, .output = true}};
  start(std::move(file));
  const SendResult result = configure({sender(27, 0x300), sender(28, 0x301)});
  EXPECT_EQ(result.cause, gateway_CAUSE_WRONG_STATE);
  EXPECT_EQ(result.reason.rfind("settings[1].number: this object belongs to the data mapping", 0), 0u)
      << result.reason;
  EXPECT_EQ(configure({sender(27, 0x300)}).code, gateway_REPLY_DONE);
}

TEST_F(Layer2Objects, L35L39JobsAreAnsweredWhenTheyStoodOnTheBus) {
  start();
  ASSERT_EQ(configure({sender(7, 0x300), sender(3, 0x301)}).code, gateway_REPLY_DONE);
  std::int64_t before = 0;
  for (const std::uint8_t number : std::vector<std::uint8_t>{7, 3, 7}) {
    const SendResult result = job(number, data_frame(0x333, {number}));
    EXPECT_EQ(result.code, gateway_REPLY_DONE) << result.reason;
    EXPECT_GT(result.sent_time, before);
    before = result.sent_time;
  }
  const auto object = status(7, [](const auto& state) { return state.sent == 2; });
  EXPECT_EQ(object.job, layer2_OBJECT_JOB_NONE);
  EXPECT_EQ(object.ended_as, layer2_OBJECT_END_DONE);
  EXPECT_EQ(object.time, before);
  EXPECT_EQ(object.content.identifier, 0x333u);
  EXPECT_EQ(job(9, data_frame(1, {})).cause, gateway_CAUSE_WRONG_STATE) << "not configured";
  EXPECT_EQ(job(7, extended(data_frame(1, {}))).cause, gateway_CAUSE_FIELD) << "another width";
  EXPECT_EQ(job(7, remote(data_frame(1, {}))).cause, gateway_CAUSE_FIELD);
}

TEST_F(Layer2Objects, L36L38AHeldJobAnswersRemoteFramesUntilItIsAborted) {
  Layer2File file = file_for(places_);
  file.config.nodes.push_back({4, remote(data_frame(0x321, {})), milliseconds(20)});
  start(std::move(file));
  ASSERT_EQ(configure({sender(2, 0x320), sender(3, 0x321), receiver(4, 0x155)}).code, gateway_REPLY_DONE);
  EXPECT_EQ(job(3, data_frame(0x321, {6}), true).code, gateway_REPLY_DONE);
  EXPECT_TRUE(status(3, [](const auto& state) { return state.sent >= 3; }).every_time);
  const SendResult held = job(2, data_frame(0x320, {7}), true);
  EXPECT_EQ(held.code, gateway_REPLY_DONE) << "as soon as the object holds it";
  EXPECT_EQ(status(2, [](const auto& state) { return state.job == layer2_OBJECT_JOB_HELD; }).sent, 0u);
  layer2_ObjectRequest abort = {};
  abort.action = layer2_OBJECT_ABORT;
  abort.number = 2;
  EXPECT_EQ(client_->object(abort).code, gateway_REPLY_DONE);
  EXPECT_EQ(status(2, [](const auto& state) { return state.job == layer2_OBJECT_JOB_NONE; }).ended_as,
            layer2_OBJECT_END_ABORTED);
  abort.number = 4;
  EXPECT_EQ(client_->object(abort).cause, gateway_CAUSE_WRONG_STATE);
}

TEST_F(Layer2Objects, L42AReleaseThatAsksBringsTheFrame) {
  start();
  layer2_ObjectSettings settings = receiver(6, 0x18DAF110, 0x1FFFFFFF);
  settings.extended = true;
  ASSERT_EQ(configure({settings}).code, gateway_REPLY_DONE);
  EXPECT_EQ(read(6, false, true).cause, gateway_CAUSE_FIELD);
  EXPECT_FALSE(read(6, true, true).fresh);
  EXPECT_EQ(fetched(6).content, extended(data_frame(0x18DAF110, {1, 2, 3})));
}

TEST_F(Layer2Objects, L41AnOverrunIsToldToWhoFetches) {
  start();
  ASSERT_EQ(configure({receiver(0, 0x250)}).code, gateway_REPLY_DONE);
  ASSERT_FALSE(read(0).fresh);
  (void)status(0, [](const auto& state) { return state.overruns > 0; });
  const SendResult result = read(0, false);
  EXPECT_TRUE(result.fresh);
  EXPECT_TRUE(result.overrun);
  EXPECT_FALSE(read(0, false).fresh) << "fetched once, and locked";
}

TEST_F(Layer2Objects, L43L49EventsOfObjectsAndOfTheSendQueue) {
  start();
  bool queue_empty = false;
  std::vector<layer2_ModuleEvent> events;
  const auto look = [&] {
    return client_->events(milliseconds(50), [&](const layer2_ModuleEvent& event) {
      EXPECT_TRUE(events.empty() || event.number > events.back().number);
      events.push_back(event);
      queue_empty = queue_empty || event.kind == layer2_SEND_QUEUE_EMPTY;
    });
  };
  // The daemon may learn of the reader later than the reader of the daemon.
  ASSERT_TRUE(comes_true([&] {
    EXPECT_EQ(client_->send(data_frame(0x300, {}), 0).code, gateway_REPLY_DONE);
    return !look() || queue_empty;
  }));
  events.clear();
  ASSERT_EQ(configure({sender(1, 0x300), receiver(2, 0x250)}).code, gateway_REPLY_DONE);
  ASSERT_EQ(job(1, data_frame(0x300, {5})).code, gateway_REPLY_DONE);
  ASSERT_FALSE(read(2).fresh);
  const auto of = [&](layer2_ModuleEventKind kind) {
    return std::find_if(events.begin(), events.end(), [&](const auto& event) { return event.kind == kind; });
  };
  ASSERT_TRUE(comes_true([&] {
    return !look() || (of(layer2_OBJECT_SENT) != events.end() && of(layer2_OBJECT_RECEIVED) != events.end());
  }));
  ASSERT_NE(of(layer2_OBJECT_RECEIVED), events.end());
  EXPECT_EQ(of(layer2_OBJECT_SENT)->object_number, 1);
  EXPECT_EQ(of(layer2_OBJECT_SENT)->content.data[0], 5);
  EXPECT_GT(of(layer2_OBJECT_SENT)->time, 0);
  EXPECT_EQ(of(layer2_OBJECT_RECEIVED)->object_number, 2);
  EXPECT_EQ(of(layer2_OBJECT_RECEIVED)->content.identifier, 0x250u);
}

TEST_F(Layer2Objects, L37AJobThatIsNotSentInItsTimeIsAborted) {
  start();
  ASSERT_EQ(configure({sender(1, 0x300, 30)}).code, gateway_REPLY_DONE);
  ASSERT_EQ(job(1, data_frame(0x300, {}), true).code, gateway_REPLY_DONE);  // nobody asks for it
  const auto object = status(1, [](const auto& state) { return state.ended_as != layer2_OBJECT_END_NONE; });
  EXPECT_EQ(object.ended_as, layer2_OBJECT_END_TIMED_OUT);
  EXPECT_EQ(object.job, layer2_OBJECT_JOB_NONE);
}

}  // namespace
}  // namespace cansyncd
