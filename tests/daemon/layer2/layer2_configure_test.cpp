// The configuration changed over real DDS while the daemon runs.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "daemon/layer2/layer2_bus.h"

namespace cansyncd {
namespace {

using can::test::data_frame;
using layer2::client::SendResult;
using std::chrono::milliseconds;

class Layer2Configure : public Layer2BusTest {
 protected:
  void SetUp() override { start(); }
  void expect_refused(const std::string& toml, const std::string& reason) {
    const SendResult result = client_->configure(toml);
    EXPECT_EQ(result.code, gateway_REPLY_REFUSED);
    EXPECT_EQ(result.cause, gateway_CAUSE_FIELD);
    EXPECT_EQ(result.reason.rfind(reason, 0), 0u) << result.reason;
  }
};

TEST_F(Layer2Configure, SectionsTakeThePlaceOfThoseInForce) {
  ASSERT_EQ(client_->configure("[[receive]]\nnumber = 0\nfirst = 0x250\nlast = 0x250\n").code,
            gateway_REPLY_DONE);
  EXPECT_TRUE(comes([](const can::Frame& frame, const auto&) { return frame.id == 0x250; }));
  ASSERT_EQ(client_
                ->configure("[[timer]]\nnumber = 5\nidentifier = 0x70\n"
                            "[[object]]\nnumber = 3\ntransmit = true\nidentifier = 0x300\n"
                            "[send]\nqueue = 5\n"
                            "[mapping]\nidentifier = 0x310\nmask = 0x7FF\n"
                            "[[mapped]]\nnumber = 0\nidentifier = 0x310\noutput = true\n")
                .code,
            gateway_REPLY_DONE);
  const auto timers = client_->timers(gateway::kLongWait);
  ASSERT_EQ(timers.size(), 1u);
  EXPECT_EQ(timers[0].number, 5);
  EXPECT_TRUE(comes_true([&] {
    const auto objects = client_->objects(milliseconds(100));
    return !objects.empty() && objects[0].number == 3;
  }));
  EXPECT_TRUE(client_->image(gateway::kLongWait)) << "there is an image now";
  EXPECT_TRUE(comes_true([&] {
    client_.emplace(options_for(places_));
    const auto status = client_->status(milliseconds(1000));
    return status && status->send_depth == 5;
  }));
  // The ranges of before are still those of the first request.
  EXPECT_TRUE(comes([](const can::Frame& frame, const auto&) { return frame.id == 0x250; }));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(client_->send(data_frame(0x7, {}), 0).code, gateway_REPLY_DONE);
}

TEST_F(Layer2Configure, WhatIsWrongIsRefusedWithItsPlaceAndNothingChanges) {
  expect_refused("[[timer]]\nnumber = 5\nidentifier = 0x70\n[[timer]]\nnumber = 6\nidentifier = 0x800\n",
                 "data:6:14: timer.6.identifier: found 0x800; allowed: 0..0x7FF");
  expect_refused("[bus]\nbit_rate = 125000\n", "data:1:");
  expect_refused("[send\n", "data:1:");
  expect_refused("[window]\nused = true\nbegin_us = 10\nend_us = 10\n", "data:4:");
  expect_refused("[script]\nrun = [\"Fly 1\"]\n", "data:2:");
  EXPECT_TRUE(client_->timers(milliseconds(100)).empty());
  EXPECT_EQ(
      client_
          ->configure("[[timer]]\nnumber = 5\nidentifier = 0x70\n[[timer]]\nnumber = 6\nidentifier = 0x7FF\n")
          .code,
      gateway_REPLY_DONE)
      << "corrected";
}

TEST_F(Layer2Configure, OneIsTakenOverAtATimeAndTheOtherAfterIt) {
  std::map<std::uint64_t, SendResult> ended;
  const auto begin = [&](const std::string& toml) {
    layer2_ControlRequest request = {};
    request.kind = layer2_CONTROL_CONFIGURE;
    std::vector<std::uint8_t> bytes(toml.begin(), toml.end());
    request.data._buffer = bytes.data();
    request.data._length = request.data._maximum = static_cast<std::uint32_t>(bytes.size());
    return client_->begin_control(request).request;
  };
  const auto both = [&](std::uint64_t first, std::uint64_t second) {
    return comes_true([&] {
      client_->look(
          {.ended = [&](std::uint64_t request, const SendResult& result) { ended[request] = result; }});
      return ended.contains(first) && ended.contains(second);
    });
  };
  bool refused = false;
  for (int tries = 0; tries < 1000 && !refused; ++tries) {  // the daemon may have ended the first by then
    const auto first = begin("[send]\nqueue = 5\n");
    const auto second = begin("[send]\nqueue = 6\n");
    ASSERT_TRUE(both(first, second));
    EXPECT_EQ(ended[first].code, gateway_REPLY_DONE);
    refused = ended[second].code == gateway_REPLY_REFUSED;
    if (refused) {
      EXPECT_EQ(ended[second].cause, gateway_CAUSE_QUEUE_FULL);
      EXPECT_EQ(ended[second].reason, "another configuration is being taken over; try again");
    }
  }
  EXPECT_TRUE(refused);
  EXPECT_EQ(client_->configure("[send]\nqueue = 6\n").code, gateway_REPLY_DONE);
}

}  // namespace
}  // namespace cansyncd
