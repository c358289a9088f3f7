#include "cansync/settings/settings_check.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace cansync {
namespace {

using std::chrono::hours;
using std::chrono::microseconds;
using std::chrono::nanoseconds;

SlaveNumber slave(unsigned number) {
  return *SlaveNumber::from(number);
}

// Slaves 0, 3 and 5.
MasterSettings good() {
  MasterSettings settings;
  for (const unsigned number : {0u, 3u, 5u}) settings.slaves[number].configured = true;
  settings.process.maximum_slave = slave(5);
  return settings;
}

TEST(SettingsCheck, GoodSettingsAtEveryBitRate) {
  for (const SlotTimes& times : kSlotTimes) {
    MasterSettings settings = good();
    settings.bit_rate = times.bit_rate;
    EXPECT_TRUE(check(settings).empty());
  }
}

TEST(SettingsCheck, ConfiguredMask) {
  EXPECT_EQ(good().configured().bits, 0x29u);
  EXPECT_TRUE(MasterSettings{}.configured().empty());
}

struct Case {
  std::string name;
  std::function<void(MasterSettings&)> change;
  std::string field;  ///< empty: no problem expected
  std::string found;
};

std::vector<Case> line_cases() {
  return {
      {"no_slave",
       [](auto& s) {
         s.slaves = {};
         s.process.polling = {};
       },
       "slaves", "none configured"},
      {"status_parameter_4095", [](auto& s) { s.slaves[3].status_parameter = 4095; }, "", ""},
      {"status_parameter_4096", [](auto& s) { s.slaves[3].status_parameter = 4096; },
       "slaves[3].status_parameter", "4096"},
      {"block_limit_5", [](auto& s) { s.slaves[0].block_limit = 5; }, "slaves[0].block_limit", "5"},
      {"block_limit_6", [](auto& s) { s.slaves[0].block_limit = 6; }, "", ""},
      {"block_limit_4092", [](auto& s) { s.slaves[0].block_limit = 4092; }, "", ""},
      {"block_limit_4093", [](auto& s) { s.slaves[0].block_limit = 4093; }, "slaves[0].block_limit", "4093"},
      {"unconfigured_slave_is_not_looked_at", [](auto& s) { s.slaves[4].block_limit = 0; }, "", ""},
      {"actual_value_of_other_telegram",
       [](auto& s) {
         s.slaves[5].actual_mapping[0].word[1] = {true, false, 4};
       },
       "slaves[5].actual_mapping[0].word[1]", "value 4"},
      {"actual_value_8",
       [](auto& s) {
         s.slaves[5].actual_mapping[1].word[3] = {true, false, 8};
       },
       "slaves[5].actual_mapping[1].word[3]", "value 8"},
      {"reference_value_3_in_second",
       [](auto& s) {
         s.process.reference_mapping[1].word[0] = {true, true, 3};
       },
       "process.reference_mapping[1].word[0]", "value 3"},
      {"unused_word_with_a_value",
       [](auto& s) {
         s.process.reference_mapping[0].word[2] = {false, true, 2};
       },
       "process.reference_mapping[0].word[2]", "unused, yet with value 2 high"},
      {"all_words_unused", [](auto& s) { s.process.reference_mapping = {}; }, "", ""},
      {"margin_zero", [](auto& s) { s.send_margin = {}; }, "", ""},
      {"margin_negative", [](auto& s) { s.send_margin = nanoseconds(-1); }, "send_margin", "-1 ns"},
      {"margin_just_below_first_slot", [](auto& s) { s.send_margin = microseconds(350) - nanoseconds(1); },
       "", ""},
      {"margin_at_first_slot", [](auto& s) { s.send_margin = microseconds(350); }, "send_margin", "350 us"},
      {"margin_by_bit_rate",
       [](auto& s) {
         s.send_margin = microseconds(700);
         s.bit_rate = BitRate::kbit500;
       },
       "", ""},
      {"bit_rate", [](auto& s) { s.bit_rate = static_cast<BitRate>(4); }, "bit_rate", "4"},
  };
}

std::vector<Case> cursor_cases() {
  const auto fixed = [](unsigned number) { return Cursor{Cursor::Kind::fixed, slave(number)}; };
  return {
      {"fixed_on_configured",
       [=](auto& s) {
         s.process.polling = {fixed(0), fixed(3)};
       },
       "", ""},
      {"polling_fixed_on_missing", [=](auto& s) { s.process.polling[1] = fixed(4); }, "process.polling[1]",
       "slave 4"},
      {"control_word_fixed_on_missing", [=](auto& s) { s.command_channel.control_word = fixed(31); },
       "command_channel.control_word", "slave 31"},
      {"parameter_fixed_on_missing", [=](auto& s) { s.command_channel.parameter = fixed(1); },
       "command_channel.parameter", "slave 1"},
      {"transfer_fixed_on_missing", [=](auto& s) { s.command_channel.transfer = fixed(2); },
       "command_channel.transfer", "slave 2"},
      {"nobody_names_no_slave",
       [](auto& s) {
         s.process.polling[0] = {Cursor::Kind::nobody, slave(4)};
       },
       "", ""},
      {"maximum_slave_above_highest", [](auto& s) { s.process.maximum_slave = slave(31); }, "", ""},
      {"maximum_slave_below_highest", [](auto& s) { s.process.maximum_slave = slave(4); },
       "process.maximum_slave", "4"},
      {"maximum_slave_unused_without_automatic",
       [=](auto& s) {
         s.process.maximum_slave = slave(0);
         s.process.polling = {fixed(5), Cursor{Cursor::Kind::nobody, {}}};
         s.command_channel.control_word = s.command_channel.parameter = s.command_channel.transfer = fixed(3);
       },
       "", ""},
      {"poll_nobody_31", [](auto& s) { s.process.poll_nobody = 31; }, "process.poll_nobody", "31"},
      {"poll_nobody_32", [](auto& s) { s.process.poll_nobody = 32; }, "", ""},
      {"poll_nobody_128", [](auto& s) { s.process.poll_nobody = 128; }, "process.poll_nobody", "128"},
      {"release_limit", [](auto& s) { s.process.release_limit = 0; }, "process.release_limit", "0"},
  };
}

std::vector<Case> channel_cases() {
  return {
      {"parameter_queue", [](auto& s) { s.command_channel.parameter_queue = 0; },
       "command_channel.parameter_queue", "0"},
      {"transfer_queue", [](auto& s) { s.command_channel.transfer_queue = 0; },
       "command_channel.transfer_queue", "0"},
      {"broadcast_queue", [](auto& s) { s.command_channel.broadcast_queue = 0; },
       "command_channel.broadcast_queue", "0"},
      {"queue_65535", [](auto& s) { s.command_channel.parameter_queue = 65535; }, "", ""},
      {"share_strict", [](auto& s) { s.command_channel.minimum_share = 0; }, "", ""},
      {"share_1", [](auto& s) { s.command_channel.minimum_share = 1; }, "command_channel.minimum_share", "1"},
      {"share_2", [](auto& s) { s.command_channel.minimum_share = 2; }, "", ""},
      {"share_65536", [](auto& s) { s.command_channel.minimum_share = 65536; },
       "command_channel.minimum_share", "65536"},
      {"parameter_monitoring_zero", [](auto& s) { s.command_channel.parameter_monitoring = {}; },
       "command_channel.parameter_monitoring", "0 us"},
      {"parameter_monitoring_one_interval",
       [](auto& s) { s.command_channel.parameter_monitoring = microseconds(1000); }, "", ""},
      {"command_monitoring_zero", [](auto& s) { s.command_channel.command_monitoring = {}; },
       "command_channel.command_monitoring", "0 us"},
      {"transfer_monitoring_too_long", [](auto& s) { s.command_channel.transfer_monitoring = hours(25); },
       "command_channel.transfer_monitoring", "90000000000 us"},
      {"address_step_4", [](auto& s) { s.command_channel.address_step = 4; }, "", ""},
      {"block_limit_between_two_addresses",
       [](auto& s) {
         s.command_channel.address_step = 4;
         s.slaves[3].block_limit = 302;
       },
       "slaves[3].block_limit", "302"},
      {"address_step_2", [](auto& s) { s.command_channel.address_step = 2; }, "command_channel.address_step",
       "2"},
      {"activate_command_1", [](auto& s) { s.startup.activate_command = 1; }, "startup.activate_command",
       "1"},
      {"activate_command_2", [](auto& s) { s.startup.activate_command = 2; }, "", ""},
      {"activate_command_255", [](auto& s) { s.startup.activate_command = 255; }, "", ""},
      {"status_period_never", [](auto& s) { s.startup.status_period = {}; }, "", ""},
      {"status_period_below_interval", [](auto& s) { s.startup.status_period = microseconds(999); },
       "startup.status_period", "999 us"},
      {"lost_after", [](auto& s) { s.startup.lost_after = 0; }, "startup.lost_after", "0"},
  };
}

std::vector<Case> all() {
  std::vector<Case> cases;
  for (const auto& part : {line_cases(), cursor_cases(), channel_cases()}) {
    cases.insert(cases.end(), part.begin(), part.end());
  }
  return cases;
}

class OneChange : public testing::TestWithParam<Case> {};

TEST_P(OneChange, IsFoundAlone) {
  MasterSettings settings = good();
  GetParam().change(settings);
  const auto problems = check(settings);
  if (GetParam().field.empty()) {
    EXPECT_TRUE(problems.empty()) << problems.front().field << " = " << problems.front().found;
    return;
  }
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].field, GetParam().field);
  EXPECT_EQ(problems[0].found, GetParam().found);
  EXPECT_FALSE(problems[0].allowed.empty());
}

INSTANTIATE_TEST_SUITE_P(Settings, OneChange, testing::ValuesIn(all()),
                         [](const auto& row) { return row.param.name; });

TEST(SettingsCheck, SaysWhatIsAllowed) {
  MasterSettings settings = good();
  settings.slaves[3].block_limit = 5000;
  settings.process.polling[0] = {Cursor::Kind::fixed, slave(7)};
  settings.send_margin = microseconds(350);
  const auto problems = check(settings);
  ASSERT_EQ(problems.size(), 3u);
  EXPECT_EQ(problems[0].allowed, "0 us up to, not including, tWRC1 = 350 us");
  EXPECT_EQ(problems[1].allowed, "6..4092");
  EXPECT_EQ(problems[2].allowed, "a configured slave (0, 3, 5), automatic, or nobody");
}

}  // namespace
}  // namespace cansync
