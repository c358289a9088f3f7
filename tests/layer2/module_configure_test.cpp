// Settings that change while the module runs.
#include <gtest/gtest.h>

#include <chrono>

#include "can/flagged_frames.h"
#include "layer2/module.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using std::chrono::microseconds;
using std::chrono::milliseconds;

class ModuleConfigure : public testing::Test {
 protected:
  ModuleConfigure() {
    settings_.station.filter.add({0, 0x7FF, false, FrameKinds::data_and_remote});
    settings_.timers[2] = TimerSettings{.frame = data_frame(0x80, {1}), .period = milliseconds(10)};
    settings_.timers[3] = TimerSettings{.frame = data_frame(0x81, {1}), .period = milliseconds(10)};
    settings_.objects[1] = ObjectSettings{.rule = {.identifier = 0x100}, .transmit = true};
    settings_.objects[2] = ObjectSettings{.rule = {.identifier = 0x200}};
    settings_.mapping.rule = {.identifier = 0x300, .mask = 0x7FF};
    settings_.mapped = {{.identifier = 0x300, .address = 5, .output = true}};
    settings_.run = parse_script("Wait 5\n");
    module_.emplace(settings_);
    module_->begin(Time{0});
    module_->advance(milliseconds(6));  // its script has ended
  }
  static PreparedSettings prepared(const ModuleSettings& settings) {
    PreparedSettings all(settings);
    all.parts = {true, true, true, true, true, true, true};
    return all;
  }
  Refusal configure(PreparedSettings& next) { return module_->configure(next, milliseconds(20)); }

  ModuleSettings settings_;
  std::optional<Module> module_;
};

TEST_F(ModuleConfigure, WhatStaysAsItIsGoesOn) {
  ASSERT_TRUE(module_->start_timer(3, milliseconds(7)));
  ASSERT_FALSE(module_->perform(
      {.id = 1, .kind = ObjectOrder::Kind::send, .number = 1, .job = {.frame = data_frame(0x100, {})}},
      milliseconds(7)));
  PreparedSettings next = prepared(settings_);
  ASSERT_EQ(configure(next), Refusal::none);
  EXPECT_TRUE(module_->timers().running(3));
  EXPECT_EQ(module_->objects().place(1), JobPlace::ready);
}

TEST_F(ModuleConfigure, EachPartTakesThePlaceOfTheOneInForce) {
  module_->mapping().outputs()[5] = 9;
  ModuleSettings other = settings_;
  other.station.filter = {};
  other.station.filter.add({0x400, 0x4FF, false, FrameKinds::data_and_remote});
  other.station.queue = 7;
  other.receive_queue = 8;
  other.timers[3].reset();
  other.timers[2]->period = milliseconds(50);
  other.objects[1].reset();
  other.objects[2]->rule.identifier = 0x201;
  other.mapped = {{.identifier = 0x310, .address = 5, .output = true}};
  other.run = parse_script("Start 3\n");
  other.window = {.used = true, .repeat = milliseconds(10), .end = milliseconds(5)};
  PreparedSettings next = prepared(other);
  ASSERT_EQ(configure(next), Refusal::none);
  module_->receive(data_frame(0x480, {}), milliseconds(21));
  module_->receive(data_frame(0x380, {}), milliseconds(21));
  ASSERT_TRUE(module_->take_received());
  EXPECT_FALSE(module_->take_received());
  EXPECT_EQ(module_->station().queue(Priority::normal).depth, 7);
  EXPECT_EQ(module_->receive_queue(Priority::normal).depth, 8);
  EXPECT_FALSE(module_->timers().configured(4));
  EXPECT_EQ(module_->timers().settings(3).period, milliseconds(50));
  EXPECT_FALSE(module_->objects().state(1).configured);
  EXPECT_EQ(module_->objects().state(2).settings.rule.identifier, 0x201u);
  EXPECT_TRUE(module_->window().used());
  module_->advance(milliseconds(21));
  EXPECT_FALSE(module_->next_frame()) << "the image begins anew, and nobody has written it yet";
  module_->mapping().set_sending(true);
  module_->advance(milliseconds(31));
  EXPECT_EQ(module_->next_frame(), data_frame(0x310, {0}));
  module_->set_running(false, milliseconds(22));
  module_->set_running(true, milliseconds(23));
  EXPECT_TRUE(module_->timers().running(3)) << "the new script of run";
}

TEST_F(ModuleConfigure, TimersThatTheWindowTakesStop) {
  const TimerSettings timer = {.frame = data_frame(0x85, {}), .period = milliseconds(10)};
  ASSERT_TRUE(module_->configure_timer(1, timer));
  ASSERT_TRUE(module_->start_timer(1, milliseconds(7)));
  ModuleSettings other;
  other.window = {.used = true, .repeat = milliseconds(10), .end = milliseconds(5)};
  PreparedSettings next(other);
  next.parts.window = true;
  ASSERT_EQ(configure(next), Refusal::none);
  EXPECT_FALSE(module_->timers().running(1));
}

TEST_F(ModuleConfigure, WithoutAMappingItsObjectsAreFree) {
  ModuleSettings other = settings_;
  other.mapped.clear();
  other.objects[28] = ObjectSettings{.rule = {.identifier = 0x500}, .transmit = true};
  PreparedSettings next = prepared(other);
  ASSERT_EQ(configure(next), Refusal::none);
  EXPECT_FALSE(module_->has_mapping());
  EXPECT_TRUE(module_->objects().state(28).configured);
  PreparedSettings back = prepared(settings_);
  ASSERT_EQ(configure(back), Refusal::none);
  EXPECT_TRUE(module_->has_mapping());
  EXPECT_EQ(module_->objects().check(28, {}), ObjectProblem::reserved);
}

TEST_F(ModuleConfigure, PartsThatAreNotNamedStay) {
  ModuleSettings other;
  PreparedSettings next(other);
  next.parts.window = true;
  ASSERT_EQ(configure(next), Refusal::none);
  EXPECT_TRUE(module_->timers().configured(3));
  EXPECT_TRUE(module_->objects().state(1).configured);
  EXPECT_TRUE(module_->has_mapping());
}

TEST_F(ModuleConfigure, WhatDoesNotFitChangesNothing) {
  for (OrderId id = 1; id <= 3; ++id)
    ASSERT_EQ(module_->submit({id, data_frame(0x7, {}), milliseconds(100)}, milliseconds(7)), Refusal::none);
  ModuleSettings other = settings_;
  other.station.queue = 2;
  other.timers[3].reset();
  PreparedSettings next = prepared(other);
  EXPECT_EQ(configure(next), Refusal::queue_in_use);
  EXPECT_TRUE(module_->timers().configured(4));
  module_->clear_queues();
  EXPECT_EQ(configure(next), Refusal::none);
  module_->set_running(false, milliseconds(22));
  module_->set_running(true, milliseconds(23));  // its script waits for 5 ms
  other.run = parse_script("Start 3\n");
  PreparedSettings script = prepared(other);
  EXPECT_EQ(configure(script), Refusal::script_under_way);
  module_->advance(milliseconds(40));
  EXPECT_EQ(configure(script), Refusal::none);
}

// A frame of 8 bytes has 111 bits without stuff bits: 222 us at 500 kbit/s.
TEST_F(ModuleConfigure, ATimerThatTheBusCannotCarryBesideTheOthersIsRefused) {
  const auto set = [&](std::uint8_t number, std::chrono::microseconds period, bool cyclic = true) {
    const TimerSettings timer = {
        .frame = data_frame(0x85, {1, 2, 3, 4, 5, 6, 7, 8}), .period = period, .cyclic = cyclic};
    return module_->control({.id = 1, .what = Control::set_timer, .number = number, .timer = timer},
                            milliseconds(20));
  };
  EXPECT_EQ(set(9, microseconds(221)), Refusal::bus_full);
  EXPECT_FALSE(module_->timers().configured(9));
  EXPECT_EQ(set(9, microseconds(444)), Refusal::none);
  EXPECT_EQ(set(10, microseconds(444)), Refusal::bus_full) << "the process image takes some, too";
  EXPECT_EQ(set(10, microseconds(444), false), Refusal::none) << "it sends one frame";
  EXPECT_EQ(set(10, milliseconds(1)), Refusal::none);
  EXPECT_EQ(set(9, microseconds(500)), Refusal::none) << "it takes the place of its own";
}

TEST_F(ModuleConfigure, ATimerWithoutAFrameAndAnImageWithoutAMappingAreThereOnceTheyAreSet) {
  const TimerSettings timer = {.frame = data_frame(0x85, {}), .period = milliseconds(10)};
  const auto control = [&](ControlOrder order) { return module_->control(order, milliseconds(20)); };
  EXPECT_EQ(control({.id = 1, .what = Control::start_timer, .number = 9}), Refusal::no_timer);
  EXPECT_EQ(control({.id = 2, .what = Control::set_timer, .number = 9, .timer = timer}), Refusal::none);
  EXPECT_EQ(control({.id = 3, .what = Control::start_timer, .number = 9}), Refusal::none);
  EXPECT_TRUE(module_->timers().running(9));

  ModuleSettings other = settings_;
  other.mapped.clear();
  PreparedSettings without = prepared(other);
  ASSERT_EQ(configure(without), Refusal::none);
  EXPECT_EQ(control({.id = 4, .what = Control::write_image, .written = module_->mapping().table()}),
            Refusal::no_image);
  PreparedSettings with = prepared(settings_);
  ASSERT_EQ(configure(with), Refusal::none);
  EXPECT_EQ(control({.id = 5, .what = Control::write_image, .written = module_->mapping().table()}),
            Refusal::none);
  EXPECT_EQ(control({.id = 6, .what = Control::write_image, .written = module_->mapping().table() - 1}),
            Refusal::image_owned)
      << "what was written into the image before is not sent";
}

}  // namespace
}  // namespace layer2
