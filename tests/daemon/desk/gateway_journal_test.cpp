#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "support/gateway_rig.h"

namespace cansyncd {
namespace {

using Code = cansync::MasterEvent::Code;

/// The entries of the event with this number; the gateway writes them right after the sample.
KeptJournal::Entry entry_of(const GatewayRig& rig, std::uint64_t number) {
  const auto found = rig.journal.wait_for("CANSYNC_EVENT_NUMBER", std::to_string(number));
  EXPECT_EQ(found.size(), 1u) << "event " << number;
  return found.empty() ? KeptJournal::Entry{} : found.front();
}

TEST(GatewayJournal, EveryEventThatClientsSeeHasItsEntry) {
  GatewayRig rig;
  for (int i = 0; cansync::name(static_cast<Code>(i)) != "unknown_event"; ++i)
    rig.report(EventReport{moment(7), {static_cast<Code>(i), slave(3), 100}});
  rig.report(SyncsMissed{moment(8), 3});
  rig.report(ControllerChanged{moment(9), can::ControllerState::error_active, can::ControllerState::bus_off});
  rig.report(SendingChanged{moment(10), can::SendResult::queue_full, 1});
  rig.report(BusFault{moment(11), BusFaultKind::overrun, false, 1});
  rig.report(LinkChanged{moment(12), can::LinkState::up, can::LinkState::missing, 0, 0});
  rig.report(StateChanged{moment(13)});
  const std::vector<gateway_Event> events = rig.client.events(26);
  EXPECT_EQ(events.size(), 26u);
  for (const gateway_Event& event : events) {
    const KeptJournal::Entry entry = entry_of(rig, event.number);
    EXPECT_EQ(entry.field("EVENT"), event.code);
    EXPECT_EQ(entry.field("BUS"), "testbus");
    EXPECT_EQ(entry.field("SLAVE"), event.slave < 0 ? "" : std::to_string(event.slave)) << event.code;
    EXPECT_EQ(entry.field("CANSYNC_INTERVAL"), std::to_string(event.interval)) << event.code;
    const std::string_view code = event.code;
    const bool of_parameter =
        code == "slave_check_failed" || code == "slave_status_refused" || code == "wrong_drive";
    EXPECT_EQ(entry.field("PARAMETER"), of_parameter ? "100" : "") << event.code;
    EXPECT_NE(entry.message.find(event.text), std::string::npos) << event.code;
    const LogPriority expected = event.severity == gateway_SEVERITY_ERROR     ? LogPriority::error
                                 : event.severity == gateway_SEVERITY_WARNING ? LogPriority::warning
                                                                              : LogPriority::info;
    EXPECT_EQ(entry.priority, expected) << event.code;
  }
}

TEST(GatewayJournal, RejectedRequestsNameTheirClient) {
  GatewayRig rig;
  auto read = TestClient::request<cansync_ParameterRequest>(1);
  read.slave = 77;
  read.element = 7;
  read.format = cansync_FORMAT_AS_SLAVE_SAYS;
  rig.client.write(read);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(1));
  const auto entries = rig.journal.wait_for("EVENT", "requests_rejected");
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0].field("CLIENT"), "tester");
  EXPECT_NE(entries[0].message.find("slave"), std::string::npos);
}

}  // namespace
}  // namespace cansyncd
