// Values of which the mapping carries one word or two.
#include "process_data_rig.h"

namespace cansync::test {
namespace {

// 70000 would go out as 4464.
TEST(ProcessData, AReferenceValueThatItsLowWordCannotHoldIsRefused) {
  MasterSettings settings = settings_for(2);
  settings.process.reference_mapping[0].word = {{{true, false, 0}, {true, false, 1}, {true, true, 1}}};
  auto rig = active_line(settings);
  const auto give = [&](std::uint32_t first, std::uint32_t second, std::uint8_t valid = 3) {
    return rig->master.submit(ReferenceUpdate{.value = {first, second}, .valid_mask = valid});
  };
  EXPECT_EQ(give(70'000, 70'000), Refusal::value_too_wide);
  EXPECT_EQ(give(static_cast<std::uint32_t>(-32'769), 0), Refusal::value_too_wide);
  rig->step();
  EXPECT_TRUE(references(*rig).empty());
  for (const std::int32_t fits : {-32'768, -100, 32'767, 65'535}) {
    EXPECT_EQ(give(static_cast<std::uint32_t>(fits), 70'000), Refusal::none) << fits;
  }
  EXPECT_EQ(give(70'000, 70'000, 2), Refusal::none) << "what is not new is not looked at";
  rig->step();
  ASSERT_EQ(references(*rig).size(), 1u);
}

TEST(ProcessData, WhatAValueGotUnderAWiderMappingIsNotCutUnderANewOne) {
  auto rig = active_line(settings_for(2));
  ASSERT_EQ(rig->master.submit(ReferenceUpdate{.value = {70'000, 1}, .valid_mask = 3}), Refusal::none);
  rig->step();
  ProcessMapping words;
  words[0].word = {{{true, false, 0}, {true, false, 1}}};
  ASSERT_EQ(rig->master.set_reference_mapping(words), Refusal::none);
  ReferenceUpdate second{.value = {0, 2}, .valid_mask = 2, .mapping_number = 2};
  EXPECT_EQ(rig->master.submit(second), Refusal::value_too_wide);
  second.valid_mask = 3;
  EXPECT_EQ(rig->master.submit(second), Refusal::none);
}

TEST(ProcessData, AValueIsAWordWhileItsLowWordAloneIsMapped) {
  MasterSettings settings = settings_for(2);
  settings.process.poll_without_reference = true;
  settings.process.polling[0] = {Cursor::Kind::fixed, slave(1)};
  settings.process.polling[1] = {Cursor::Kind::nobody, {}};
  auto rig = active_line(settings);
  rig->answer = [](const Telegram& telegram) -> std::optional<Telegram> {
    const auto* reference = std::get_if<ReferenceTelegram>(&telegram);
    if (reference == nullptr || reference->polled > 31) return MasterRig::status_only(telegram);
    return ActualTelegram{reference->channel, slave(reference->polled), 4, {0xFF9C, 7, 0, 0}};
  };
  rig->step();
  ASSERT_FALSE(rig->told.actual.empty());
  EXPECT_EQ(rig->told.actual.back().second.value[0], 0x7FF9Cu);
  EXPECT_EQ(rig->told.actual.back().second.words, 0);
  ProcessMapping words;
  words[0].word[0] = {true, false, 0};
  ASSERT_EQ(rig->master.set_actual_mapping(slave(1), words), Refusal::none);
  rig->step();
  EXPECT_EQ(rig->told.actual.back().second.value[0], 0xFF9Cu) << "the high word was of the mapping before";
  EXPECT_EQ(rig->told.actual.back().second.words, 0x01);
  ASSERT_EQ(rig->master.set_actual_mapping(slave(1), {default_mapping(Channel::one), {}}), Refusal::none);
  rig->step();
  EXPECT_EQ(rig->told.actual.back().second.words, 0);
}

}  // namespace
}  // namespace cansync::test
