// What the gateway of a J1939 bus tells of other nodes, over real DDS.
#include "daemon/j1939/gateway/message_gateway.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "dds/bounded_text.h"
#include "j1939/client/message_client.h"
#include "support/dds_places.h"
#include "support/kept_journal.h"
#include "support/long_wait.h"

namespace cansyncd {
namespace {

class MessageGatewayTest : public testing::Test {
 protected:
  MessageGatewayTest() {
    config_.bus.name = places_.here.partition;
    gateway_.emplace(config_, exchange_, participant_, journal_);
    gateway_->start();
  }
  /// DM1 in one frame, which no range takes.
  void hear(std::array<std::uint8_t, 8> data) {
    MessageReport report;
    report.number = j1939::pgn::kActiveFaults;
    report.source = 7;
    report.destination = j1939::kGlobalAddress;
    report.taken = false;
    report.size = 8;
    report.data = data;
    ASSERT_TRUE(exchange_.messages.try_push(report));
    exchange_.gateway_wake.signal();
  }

  TwoPlaces places_{"j1939bus"};
  KeptJournal journal_;
  J1939Config config_;
  J1939Exchange exchange_{16, 16, 0};
  gateway::dds::Participant participant_{places_.here};
  std::optional<MessageGateway> gateway_;
};

TEST_F(MessageGatewayTest, FaultsAreToldWhateverTheRangesTake) {
  j1939::client::Options options;
  options.domain = places_.there.domain;
  options.bus = places_.there.partition;
  options.xml = places_.there.xml;
  options.wait = gateway::kLongWait;
  j1939::client::MessageClient client(options);
  hear({0x10, 0xFF, 0x6E, 0x00, 0x10, 0x03, 0xFF, 0xFF});  // red stop lamp; SPN 110, FMI 16
  ASSERT_EQ(journal_.wait_for("EVENT", "fault_appeared").size(), 1u);
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  while (client.faults(std::chrono::milliseconds(50)).empty() && std::chrono::steady_clock::now() < end) {
  }
  const auto& told = client.faults(std::chrono::milliseconds(50));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told.begin()->second.codes.size(), 1u);
  EXPECT_EQ(told.begin()->second.list.red_stop_lamp, 1);
}

TEST_F(MessageGatewayTest, LampsWithoutACodeAreAFault) {
  hear({0x10, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF});
  const auto appeared = journal_.wait_for("EVENT", "fault_appeared");
  ASSERT_EQ(appeared.size(), 1u);
  EXPECT_NE(appeared[0].message.find("address 7: fault appeared: lamps on (red stop), no code"),
            std::string::npos)
      << appeared[0].message;
  hear({0x00, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF});
  EXPECT_EQ(journal_.wait_for("EVENT", "fault_gone").size(), 1u);
}

}  // namespace
}  // namespace cansyncd
