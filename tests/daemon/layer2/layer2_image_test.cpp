// The process image, its owner, and orders of several frames, over real DDS.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/desk/gateway_events.h"
#include "daemon/layer2/gateway/frame_gateway.h"
#include "daemon/layer2/layer2_bus.h"
#include "dds/bounded_text.h"
#include "layer2/client/image_writer.h"

namespace cansyncd {
namespace {

using can::test::data_frame;
using layer2::client::FrameClient;
using layer2::client::ImageWriter;
using layer2::client::RunLead;
using layer2::client::SendResult;
using std::chrono::milliseconds;

class Layer2Image : public Layer2BusTest {
 protected:
  /// One telegram in, and 128 of 8 bytes out.
  void start_mapped(WriterLost reaction) {
    Layer2File file = file_for(places_);
    Layer2Config& config = file.config;
    config.writer_lost = reaction;
    config.mapping.rule = {.identifier = 0x150, .mask = 0x7FF};
    config.mapped = {{.identifier = 0x150, .address = 1000, .size = 2}};
    for (std::uint16_t i = 0; i < 128; ++i) {
      config.mapped.push_back({.identifier = 0x400u + i,
                               .offset = 0,
                               .address = static_cast<std::uint16_t>(8 * i),
                               .size = 8,
                               .output = true});
    }
    config.mapping.interval = milliseconds(100);
    start(std::move(file));
  }
  /// The image once it fits.
  template <class Fits>
  layer2_ProcessImage image(const Fits& fits) {
    layer2_ProcessImage found = {};
    EXPECT_TRUE(comes_true([&] {
      const auto newest = client_->image(milliseconds(200), true);
      if (newest) found = *newest;
      return newest && fits(*newest);
    }));
    return found;
  }
  /// A program of its own, which dies without any farewell when it is destroyed.
  struct Program {
    Program(const TwoPlaces& places, std::int32_t strength, const gateway_GatewayStatus& daemon)
        : participant(places.there),
          writer(participant, strength),
          identity(gateway::dds::daemon_of(daemon)) {
      EXPECT_TRUE(comes_true([&] { return writer.matched() != 0; }));
    }
    void write(std::uint16_t address, std::vector<std::uint8_t> bytes) {
      layer2_ImageOutputs sample = {};
      sample.address = address;
      sample.data._buffer = bytes.data();
      sample.data._length = sample.data._maximum = static_cast<std::uint32_t>(bytes.size());
      gateway::dds::set_daemon(identity, sample);
      EXPECT_EQ(writer.write(sample), DDS_RETCODE_OK);
    }
    gateway::dds::Participant participant;
    gateway::dds::Writer<layer2_ImageOutputs> writer;
    gateway::dds::DaemonIdentity identity;
  };
  std::unique_ptr<Program> program(std::int32_t strength) {
    return std::make_unique<Program>(places_, strength, client_->gateway_status());
  }
  static std::vector<std::uint8_t> bytes(std::size_t count, std::uint8_t first) {
    std::vector<std::uint8_t> all(count);
    for (std::size_t i = 0; i < count; ++i) all[i] = static_cast<std::uint8_t>(first + i);
    return all;
  }
  SendResult write_by_request(std::uint8_t value) {
    layer2_ControlRequest request = {};
    request.kind = layer2_CONTROL_WRITE_IMAGE;
    request.size = 1;
    request.bytes[0] = value;
    return client_->control(request);
  }
};

TEST_F(Layer2Image, L56TheImageIsWrittenAsAWholeAndRead) {
  start_mapped(WriterLost::hold);
  EXPECT_EQ(write_by_request(7).code, gateway_REPLY_DONE);
  EXPECT_EQ(
      image([](const auto& newest) { return newest.outputs[0] == 7 && newest.inputs[1001] == 9; }).writer[0],
      '\0');
  ImageWriter writer(*client_, 1);
  const auto all = bytes(1024, 3);
  ASSERT_EQ(writer.write(0, all), "");
  const auto newest = image([](const auto& sample) { return sample.outputs[0] == 3; });
  EXPECT_TRUE(std::equal(all.begin(), all.end(), std::begin(newest.outputs)));
  EXPECT_TRUE(newest.sending);
  EXPECT_NE(gateway::dds::text(newest.writer), "");
  const auto two = bytes(2, 0xF0);
  ASSERT_EQ(writer.write(1022, two), "");
  EXPECT_EQ(image([](const auto& sample) { return sample.outputs[1023] == 0xF1; }).outputs[1021], all[1021])
      << "what a sample does not name stays";
  const SendResult refused = write_by_request(8);
  EXPECT_EQ(refused.cause, gateway_CAUSE_WRONG_STATE) << refused.reason;
  EXPECT_NE(writer.write(1023, two), "") << "it ends after the image";
  const auto other = program(0);
  other->write(1023, two);
  EXPECT_EQ(journal_.wait_for("EVENT", "image_refused").size(), 1u);
  writer.give_up();
  EXPECT_EQ(journal_.wait_for("EVENT", "image_given_up").size(), 1u);
  EXPECT_TRUE(comes_true([&] { return write_by_request(9).code == gateway_REPLY_DONE; }));
}

TEST_F(Layer2Image, BytesForAnotherStartOfTheDaemonAreNotTaken) {
  start_mapped(WriterLost::hold);
  const auto writer = program(1);
  const auto meant_for = std::exchange(writer->identity, gateway::dds::DaemonIdentity{0xDA, 0xE0, 0x02});
  writer->write(0, bytes(1, 1));
  const auto refused = journal_.wait_for("EVENT", "image_refused");
  ASSERT_EQ(refused.size(), 1u);
  writer->identity = meant_for;
  writer->write(0, bytes(1, 2));
  EXPECT_EQ(image([](const auto& sample) { return sample.sending; }).outputs[0], 2);
}

TEST_F(Layer2Image, NothingIsSentUntilSomebodyHasWritten) {
  start_mapped(WriterLost::hold);
  const auto before = image([](const auto& sample) { return sample.exchanging && sample.received > 10; });
  EXPECT_FALSE(before.sending);
  EXPECT_EQ(before.sent, 0u);
  auto first = program(1);
  first->write(0, bytes(4, 1));
  (void)image([](const auto& sample) { return sample.outputs[3] == 4 && sample.sent > 0; });
  // Another table, and another owner, begin with nothing that the one before has left.
  ASSERT_EQ(
      client_
          ->configure("[mapping]\ninterval_ms = 20\n[[mapped]]\nnumber = 0\nidentifier = 0x201\nsize = 8\n"
                      "output = true\n")
          .code,
      gateway_REPLY_DONE);
  const auto anew = image([](const auto& sample) { return !sample.sending; });
  EXPECT_EQ(anew.outputs[3], 0);
  EXPECT_EQ(journal_.wait_for("EVENT", "image_begins_anew").size(), 1u);
  EXPECT_EQ(anew.telegrams, 1);
  EXPECT_EQ(anew.telegram_identifier[0], 0x201u);
  first->write(0, bytes(1, 9));
  EXPECT_EQ(image([](const auto& sample) { return sample.sending; }).outputs[0], 9);
  first.reset();
  EXPECT_EQ(journal_.wait_for("EVENT", "image_writer_lost").size(), 1u);
  EXPECT_EQ(image([](const auto&) { return true; }).outputs[0], 9) << "held";
  auto second = program(1);
  second->write(5, bytes(1, 7));
  EXPECT_EQ(image([](const auto& sample) { return sample.outputs[5] == 7; }).outputs[0], 0);
}

TEST_F(Layer2Image, AMappingThatHasEndedIsGoneForThoseWhoComeLater) {
  start_mapped(WriterLost::hold);
  (void)image([](const auto& sample) { return sample.exchanging; });
  ASSERT_EQ(client_->configure("[mapping]\n").code, gateway_REPLY_DONE);
  EXPECT_TRUE(comes_true([&] { return !client_->image(milliseconds(50), true); }));
  FrameClient late(options_for(places_));
  EXPECT_FALSE(late.image(milliseconds(500)));
  EXPECT_FALSE(client_->image(milliseconds(0), false));
}

TEST_F(Layer2Image, WritingByParts) {
  start_mapped(WriterLost::hold);
  ImageWriter writer(*client_, 1);
  // More samples at once than the reader keeps: none of the changes is lost.
  for (std::uint16_t i = 0; i < 40; ++i)
    ASSERT_EQ(writer.write(static_cast<std::uint16_t>(25 * i), bytes(1, 1)), "");
  const auto all = image([](const auto& sample) { return sample.outputs[25 * 39] == 1; });
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(all.outputs[25 * i], 1) << i;
}

TEST_F(Layer2Image, L56AnOwnerKeepsTheImageUntilAStrongerOneComesOrItHasGone) {
  start_mapped(WriterLost::hold);
  auto strong = program(5);
  const auto weak = program(1);
  weak->write(0, bytes(1, 10));
  (void)image([](const auto& sample) { return sample.outputs[0] == 10; });
  strong->write(0, bytes(1, 20));
  (void)image([](const auto& sample) { return sample.outputs[0] == 20; });
  weak->write(0, bytes(1, 11));
  const auto equal = program(5);
  equal->write(0, bytes(1, 12));
  EXPECT_EQ(journal_.wait_for("EVENT", "writer_waits", 2).size(), 2u);
  strong->write(1, bytes(1, 21));
  EXPECT_EQ(image([](const auto& sample) { return sample.outputs[1] == 21; }).outputs[0], 20);
  const auto status = client_->status(gateway::kLongWait);
  ASSERT_TRUE(status);
  EXPECT_EQ(status->image_ownership.strength, 5);
  EXPECT_NE(gateway::dds::text(status->image_ownership.waiting_writer), "");
  ImageWriter ours(*client_, 5);
  EXPECT_NE(ours.write(0, bytes(1, 13)).find("has it with strength 5"), std::string::npos);
  strong.reset();
  EXPECT_TRUE(comes_true([&] {
    weak->write(0, bytes(1, 12));
    const auto newest = client_->image(milliseconds(50), true);
    return newest && newest->outputs[0] == 12;
  }));
}

TEST_F(Layer2Image, L56AWriterThatDiesLeavesWhatTheReactionSays) {
  start_mapped(WriterLost::zero);
  auto writer = this->program(1);
  writer->write(0, bytes(4, 1));
  (void)image([](const auto& sample) { return sample.outputs[3] == 4; });
  writer.reset();
  const auto zero = image([](const auto& sample) { return sample.outputs[3] == 0; });
  EXPECT_EQ(zero.outputs[0], 0);
  EXPECT_TRUE(zero.sending);
  EXPECT_EQ(journal_.wait_for("EVENT", "image_writer_lost").size(), 1u);
}

TEST_F(Layer2Image, L56SendingStopsUntilSomebodyWritesAgain) {
  start_mapped(WriterLost::stop_sending);
  auto writer = this->program(1);
  writer->write(0, bytes(4, 1));
  (void)image([](const auto& sample) { return sample.outputs[3] == 4 && sample.sent > 0; });
  writer.reset();
  const auto stopped = image([](const auto& sample) { return !sample.sending; });
  EXPECT_EQ(stopped.outputs[3], 4);
  EXPECT_TRUE(stopped.exchanging) << "telegrams are still taken";
  const auto later = image([&](const auto& sample) { return sample.received > stopped.received + 10; });
  EXPECT_LE(later.sent, stopped.sent + 1) << "one may have been on its way";
  EXPECT_EQ(write_by_request(9).code, gateway_REPLY_DONE);
  const auto again = image([&](const auto& sample) { return sample.sending && sample.sent > later.sent; });
  EXPECT_EQ(again.outputs[0], 9);
  EXPECT_EQ(again.outputs[3], 0) << "what the program that died gave is over";
}

using Layer2Sequence = Layer2BusTest;

TEST_F(Layer2Sequence, ManyFramesHaveOneReply) {
  start();
  std::vector<can::Frame> frames;
  for (std::uint8_t i = 0; i < 64; ++i) frames.push_back(data_frame(0x300, {i}));
  SendResult result = client_->send(frames, 0);
  EXPECT_EQ(result.code, gateway_REPLY_DONE) << result.reason;
  EXPECT_EQ(result.sent, 64u);
  EXPECT_GT(result.sent_time, 0);
  std::optional<layer2_FrameStatus> status;
  EXPECT_TRUE(comes_true([&] {
    client_.emplace(options_for(places_));
    status = client_->status(milliseconds(1000));
    return status && status->sent == 64;
  }));
  frames.push_back(frames[0]);
  EXPECT_EQ(client_->send(frames, 0).cause, gateway_CAUSE_LENGTH);
  frames.pop_back();
  EXPECT_EQ(client_->send(frames, 0).code, gateway_REPLY_DONE);
}

TEST_F(Layer2Sequence, ADeadlineThatHasPassedSendsNothing) {
  start();
  const std::vector<can::Frame> frames(3, data_frame(0x300, {1}));
  SendResult result = client_->send(frames, 0, {.deadline = wall_clock_now() - 1});
  EXPECT_EQ(result.cause, gateway_CAUSE_STALE) << result.reason;
  EXPECT_EQ(result.sent, 0u);
  const auto later = std::chrono::nanoseconds(gateway::kLongWait).count();
  EXPECT_EQ(client_->send(frames, 0, {.deadline = wall_clock_now() + later}).code, gateway_REPLY_DONE);
}

using Layer2Run = Layer2BusTest;

TEST_F(Layer2Run, RunAndStopFollowAProgram) {
  Layer2File file = file_for(places_);
  file.config.run_follows = "line-control";
  start(std::move(file));
  const auto send = [&] { return client_->send(data_frame(0x300, {}), 0); };
  const auto control = [&](layer2_ControlKind kind) {
    layer2_ControlRequest request = {};
    request.kind = kind;
    return client_->control(request);
  };
  EXPECT_EQ(send().cause, gateway_CAUSE_WRONG_STATE) << "without the program it is in stop";
  EXPECT_EQ(control(layer2_CONTROL_RUN).cause, gateway_CAUSE_WRONG_STATE);
  RunLead other(*client_, "somebody", 0);
  ASSERT_EQ(other.say(true), "");
  {
    FrameClient host(options_for(places_));
    RunLead lead(host, "line-control", 1);
    ASSERT_EQ(lead.say(true), "");
    EXPECT_TRUE(comes_true([&] { return send().code == gateway_REPLY_DONE; }));
    ASSERT_EQ(lead.say(false), "");
    EXPECT_TRUE(comes_true([&] { return send().code == gateway_REPLY_REFUSED; }));
    ASSERT_EQ(lead.say(true), "");
    EXPECT_TRUE(comes_true([&] { return send().code == gateway_REPLY_DONE; }));
    EXPECT_EQ(control(layer2_CONTROL_STOP).code, gateway_REPLY_DONE) << "an engineer may always";
    EXPECT_EQ(control(layer2_CONTROL_RUN).code, gateway_REPLY_DONE);
  }
  EXPECT_TRUE(comes_true([&] { return send().code == gateway_REPLY_REFUSED; })) << "the program has gone";
  RunLead lead(*client_, "line-control", 1);
  EXPECT_TRUE(comes_true([&] { return lead.say(true).empty(); }));
  EXPECT_TRUE(comes_true([&] { return send().code == gateway_REPLY_DONE; }));
  RunLead stronger(*client_, "somebody", 2);
  ASSERT_EQ(stronger.say(false), "");
  FrameClient another(options_for(places_));
  RunLead equal(another, "line-control", 1);
  EXPECT_TRUE(comes_true([&] { return !equal.say(false).empty(); })) << "it is told who leads";
  EXPECT_EQ(send().code, gateway_REPLY_DONE) << "neither another name nor an equal one has a part in it";
}

/// The gateway alone: what it hands on stands in the exchange.
class Layer2ReadOnly : public Layer2Image {
 protected:
  Layer2ReadOnly() {
    file_.config.mapped = {{.identifier = 0x400, .size = 8, .output = true}};
    file_.config.run_follows = "line-control";
    gateway_.emplace(file_, exchange_, participant_, journal_);
    gateway_->start();
    client_.emplace(options_for(places_));
  }
  void set_read_only(bool read_only) {
    file_.config.access.read_only = read_only;
    gateway_->reload(file_.config);
  }
  /// Until the newest image that is handed on fits.
  template <class Fits>
  bool hands_on(const Fits& fits) {
    return comes_true([&] {
      (void)exchange_.outputs.read(outputs_);
      return fits(outputs_);
    });
  }
  /// The next order to run or to stop.
  std::optional<layer2::Control> ordered() {
    Layer2Request request;
    if (!comes_true([&] { return exchange_.requests.try_pop(request); })) return std::nullopt;
    return std::get<layer2::ControlOrder>(request).what;
  }

  Layer2File file_ = file_for(places_);
  Layer2Exchange exchange_{16, 16};
  gateway::dds::Participant participant_{places_.here};
  std::optional<FrameGateway> gateway_;
  OutputImage outputs_;
};

TEST_F(Layer2ReadOnly, WhoeverHasWrittenTheImageCountsAsGone) {
  const auto writer = program(1);
  writer->write(0, bytes(1, 10));
  ASSERT_TRUE(hands_on([](const auto& image) { return image.sending && image.bytes[0] == 10; }));
  set_read_only(true);
  EXPECT_TRUE(hands_on([](const auto& image) { return !image.sending; })) << "by default it is not sent";
  EXPECT_EQ(journal_.wait_for("EVENT", "image_writer_lost").size(), 1u);
  writer->write(0, bytes(1, 11));
  EXPECT_EQ(journal_.wait_for("EVENT", "image_refused").size(), 1u);
  set_read_only(false);
  EXPECT_TRUE(hands_on([&](const auto& image) {
    writer->write(1, bytes(1, 12));
    return image.sending && image.bytes[1] == 12;
  }));
  EXPECT_EQ(outputs_.bytes[0], 0) << "it begins anew";
}

TEST_F(Layer2ReadOnly, NoProgramLetsTheModuleRun) {
  RunLead lead(*client_, "line-control", 1);
  ASSERT_EQ(lead.say(true), "");
  EXPECT_EQ(ordered(), layer2::Control::run);
  set_read_only(true);
  EXPECT_EQ(ordered(), layer2::Control::stop);
  EXPECT_TRUE(comes_true([&] { return lead.say(true).empty(); }));
  EXPECT_EQ(journal_.wait_for("EVENT", "run_lead_changed", 3).size(), 3u)
      << "it is told that it is not heard";
  set_read_only(false);
  EXPECT_EQ(journal_.wait_for("EVENT", "configuration_reloaded", 2).size(), 2u);
  ASSERT_EQ(lead.say(true), "");
  EXPECT_EQ(ordered(), layer2::Control::run);
}

}  // namespace
}  // namespace cansyncd
