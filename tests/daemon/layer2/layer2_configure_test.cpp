// The configuration changed over real DDS while the daemon runs.
#include <gtest/gtest.h>

#include <string>

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
}

}  // namespace
}  // namespace cansyncd
