#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "support/reference_writer.h"
#include "whole_requests.h"
#include "whole_rig.h"

/// Words that stop, from a program and from the failsafe reaction, on the whole line: the gateway over real
/// DDS, the realtime loop and simulated drives in virtual time.
namespace cansyncd {
namespace {

std::string ended(WholeRig& rig) {
  for (const gateway_Event& event : rig.watcher().all<gateway_Event>()) {
    if (std::string_view(event.code) == "failsafe_control_word_ended") return event.text;
  }
  return {};
}

TEST(FailsafeLine, WordsThatStopPassACursorThatServesNobody) {
  Config config = whole_config();
  config.master.command_channel.control_word = {cansync::Cursor::Kind::nobody, {}};
  config.failsafe.reaction = LossReaction::control_word;
  config.failsafe.control_word = 0x0000;
  WholeRig rig(config);

  rig.watcher().deliver(command(1, cansync_COMMAND_CONTROL_WORD));  // it enables, and waits for the cursor
  auto late = command(2, cansync_COMMAND_CONTROL_WORD);
  late.slave = 2;
  late.timeout = 3;
  rig.watcher().deliver(late);
  pass_marker(rig);
  rig.run(6);
  EXPECT_TRUE(rig.all_answered(1));
  EXPECT_FALSE(rig.replies().contains(1));
  EXPECT_EQ(rig.replies().at(2), std::vector{gateway_REPLY_TIMEOUT});

  auto stop = command(3, cansync_COMMAND_CONTROL_WORD);
  stop.control_word = 0x0006;
  rig.watcher().deliver(stop);
  pass_marker(rig);
  rig.run(3);
  EXPECT_TRUE(rig.all_answered(3));
  EXPECT_EQ(rig.replies().at(1), std::vector{gateway_REPLY_REPLACED});
  EXPECT_EQ(rig.replies().at(3), std::vector{gateway_REPLY_DONE});

  {
    const gateway::dds::Participant participant(rig.client_place());
    gateway::dds::DataSignal signal;
    gateway::dds::Writer<cansync_ReferenceValues> writer(participant, 0, &signal, "winder");
    ASSERT_TRUE(eventually(signal, [&] { return writer.matched() > 0; }));
    ASSERT_EQ(writer.write(values(1, 1)), DDS_RETCODE_OK);
    ASSERT_TRUE(rig.heard("reference_writer_began"));
  }
  ASSERT_TRUE(rig.heard("failsafe_control_word"));
  pass_marker(rig);
  rig.run(6);  // four slaves, one an interval
  ASSERT_TRUE(rig.heard("failsafe_control_word_ended"));
  EXPECT_EQ(ended(rig).find("; not"), std::string::npos) << ended(rig);
}

}  // namespace
}  // namespace cansyncd
