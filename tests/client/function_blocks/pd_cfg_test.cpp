// CANsync_PD_CFG_MA and CANsync_PD_CFG_READ_MA, sections 4.15 and 4.16 of the application manual.
#include <algorithm>

#include "block_rig.h"

namespace cansync::client::function_blocks {
namespace {

class PdCfg : public CommandTest {
 protected:
  static MappingBytes bytes_of(const cansync_Command& taken) {
    MappingBytes bytes = {};
    std::copy(std::begin(taken.mapping), std::end(taken.mapping), bytes.begin());
    return bytes;
  }
};

// The manual's example of 4.15: words 0 and 1 are reference value 1, word 2 value 0, word 3 value 2; in
// telegram 2
// "-1: no reference value is to be assigned", and the flag is meaningless.
TEST_F(PdCfg, TheManualsExampleOfReferenceValues) {
  PD_CFG_MA block(client);
  block.a_WRC1 = {1, 1, 0, 2};
  block.a_HL_WRC1 = {false, true, false, false};
  block.a_WRC2 = {4, -1, 5, 5};
  block.a_HL_WRC2 = {false, true, false, true};
  const cansync_Command taken = command(block, 1);
  EXPECT_EQ(taken.kind, cansync_COMMAND_REFERENCE_MAPPING);
  EXPECT_EQ(bytes_of(taken), (MappingBytes{0x05, 0x07, 0x01, 0x09, 0x11, 0x00, 0x15, 0x17}));
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.in_effect(); }));
  for (int i = 0; i < 100; ++i) block.call();
  EXPECT_EQ(daemon.commands().size(), 1u);
  block.a_WRC1[3] = 3;
  EXPECT_EQ(bytes_of(command(block, 2))[3], 0x0D);
}

TEST_F(PdCfg, WhatWasRefusedForWhatPassesIsEnteredAgain) {
  PD_CFG_MA block(client);
  block.a_WRC1 = {0, 1, -1, -1};
  daemon.refuse_next(2, gateway_CAUSE_CLIENT_LIMIT);
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return !block.error().empty(); }));
  EXPECT_FALSE(block.in_effect());
  ASSERT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.in_effect(); })) << block.error();
  EXPECT_EQ(daemon.commands().size(), 1u);
}

TEST_F(PdCfg, ASlaveThatAReloadAddsIsEntered) {
  PD_CFG_READ_MA block(client);
  block.si_SL_NR = 4;
  block.a_RDC1 = {0, -1, -1, -1};
  block.call();
  ASSERT_EQ(block.error().rfind("client: slave 4: not configured", 0), 0u) << block.error();
  daemon.configure_slave_4();
  EXPECT_TRUE(repeat_until([&] { block.call(); }, [&] { return block.in_effect(); })) << block.error();
  EXPECT_EQ(daemon.commands().size(), 1u);
}

// The manual's example of 4.16.
TEST_F(PdCfg, TheManualsExampleOfActualValues) {
  PD_CFG_READ_MA block(client);
  block.si_SL_NR = 3;
  block.a_RDC1 = {1, 1, 0, 2};
  block.a_HL_RDC1 = {false, true, false, false};
  block.a_RDC2 = {4, -1, -1, -1};
  const cansync_Command taken = command(block, 1);
  EXPECT_EQ(taken.kind, cansync_COMMAND_ACTUAL_MAPPING);
  EXPECT_EQ(taken.slave, 3u);
  EXPECT_EQ(bytes_of(taken), (MappingBytes{0x05, 0x07, 0x01, 0x09, 0x11, 0, 0, 0}));
}

// "You can choose the data for reference value message frame 1 from reference values 0 to 3 and ... 2 from
// ... 4 to 7."
TEST_F(PdCfg, NumbersOfTheOtherTelegramAndWrongSlavesAreRefused) {
  PD_CFG_MA references(client);
  references.a_WRC1 = {4, -1, -1, -1};
  ASSERT_TRUE(repeat_until([&] { references.call(); }, [&] { return !references.error().empty(); }));
  EXPECT_NE(references.error().find("daemon: mapping[0]"), std::string::npos) << references.error();
  references.a_WRC1 = {8, -1, -1, -1};
  references.call();
  EXPECT_NE(references.error().find("client: word 0 of telegram 1: value number 8"), std::string::npos);
  EXPECT_FALSE(references.in_effect());
  PD_CFG_READ_MA actuals(client);
  actuals.si_SL_NR = 9;
  actuals.call();
  EXPECT_EQ(actuals.error().rfind("client: slave 9: not configured", 0), 0u) << actuals.error();
  EXPECT_EQ(daemon.commands().size(), 0u);
}

}  // namespace
}  // namespace cansync::client::function_blocks
