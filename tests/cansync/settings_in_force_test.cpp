#include "cansync/settings/settings_in_force.h"

#include <gtest/gtest.h>

namespace cansync {
namespace {

void change(Cursor& cursor, unsigned slave) {
  cursor = {Cursor::Kind::fixed, *SlaveNumber::from(slave)};
}

void change(ProcessMapping& mapping, std::uint8_t value) {
  mapping[0].word[0] = {true, false, value};
}

/// Every setting other than its default, and than its neighbours.
SettingsInForce all_changed() {
  SettingsInForce all;
  // A setting that is added does not compile here: change it below, too.
  auto& [reference_mapping, actual_mapping, polling, maximum_slave, control_word, parameter, transfer,
         reference_limits] = all;
  change(reference_mapping, 7);
  for (unsigned i = 0; i < kSlaves; ++i) change(actual_mapping[i], static_cast<std::uint8_t>(i % kValues));
  change(polling[0], 1);
  change(polling[1], 2);
  maximum_slave = *SlaveNumber::from(30);
  change(control_word, 3);
  change(parameter, 4);
  change(transfer, 5);
  for (unsigned i = 0; i < kValues; ++i) reference_limits[i].maximum = 100 + i;
  return all;
}

TEST(SettingsInForce, EachIsCarriedIntoTheSettingsAndBack) {
  const SettingsInForce all = all_changed();
  MasterSettings settings;
  EXPECT_NE(in_force(settings), all);
  put_in_force(all, settings);
  EXPECT_EQ(in_force(settings), all);
}

TEST(SettingsInForce, NothingElseChanges) {
  MasterSettings settings;
  settings.slaves[3].configured = true;
  settings.process.release_limit = 17;
  settings.command_channel.parameter_queue = 5;
  put_in_force(all_changed(), settings);
  EXPECT_TRUE(settings.slaves[3].configured);
  EXPECT_FALSE(settings.slaves[4].configured);
  EXPECT_EQ(settings.process.release_limit, 17u);
  EXPECT_EQ(settings.command_channel.parameter_queue, 5);
}

}  // namespace
}  // namespace cansync
