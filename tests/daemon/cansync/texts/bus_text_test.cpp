#include "daemon/cansync/texts/bus_text.h"

#include <gtest/gtest.h>

#include "can/fake_kernel.h"
#include "daemon/bus/socketcan_line.h"
#include "daemon_config/bit_timing_check.h"

namespace cansyncd::test {
namespace {

Config can_config(cansync::BitRate rate = cansync::BitRate::kbit500) {
  Config config;
  config.bus.kind = BusKind::socketcan;
  config.bus.interface = "can0";
  config.master.bit_rate = rate;
  config.bus.bits_per_second = cansync::slot_times(rate).bits_per_second;
  return config;
}

TEST(BitTiming, PresetsOfBothControllersFitTheirBitRates) {
  for (const can::BitTimingPreset& preset : can::kBitTimingPresets) {
    Config config = can_config(cansync::slot_times_for(preset.bits_per_second)->bit_rate);
    config.bus.btr0 = preset.registers.btr0;
    config.bus.btr1 = preset.registers.btr1;
    config.bus.registers_of = preset.controller;
    EXPECT_FALSE(check_bit_timing(config.bus)) << preset.bits_per_second;
    EXPECT_EQ(wanted_sample_point(config.bus), preset.controller == can::Controller::plc ? 600 : 875);
  }
}

TEST(BitTiming, TheSamplePointIsThatOfTheProtocol) {
  BusConfig bus = can_config(cansync::BitRate::kbit250).bus;
  EXPECT_EQ(
      bit_rate_command(bus, {}),
      "ip link set can0 down; ip link set can0 type can bitrate 250000 sample-point 0.600; ip link set can0 up");
  bus.sample_point = 875;
  EXPECT_EQ(
      bit_rate_command(bus, {}),
      "ip link set can0 down; ip link set can0 type can bitrate 250000 sample-point 0.875; ip link set can0 up");
  bus.sample_point = 0;
  EXPECT_EQ(bit_rate_command(bus, {}),
            "ip link set can0 down; ip link set can0 type can bitrate 250000; ip link set can0 up");
  bus.btr0 = 0x43;
  bus.btr1 = 0x34;
  EXPECT_EQ(wanted_sample_point(bus), 600) << "registers that were given count";
}

TEST(BitTiming, RegistersOfAnotherBitRateAreRefusedWithThoseThatFit) {
  Config config = can_config();
  config.bus.btr0 = 0x43;
  config.bus.btr1 = 0x34;
  const auto wrong = check_bit_timing(config.bus);
  ASSERT_TRUE(wrong);
  EXPECT_STREQ(wrong->option, "bus.btr0");
  EXPECT_EQ(
      wrong->text,
      "found 0x43 and 0x34, which give 250000 bit/s at 20 MHz; allowed: registers that give bus.bit_rate, "
      "500000 bit/s, as 0x41 and 0x34 (plc), 0x00 and 0x1C (omega) do");
}

TEST(BitTiming, OneRegisterAloneIsRefused) {
  Config config = can_config();
  config.bus.btr1 = 0x34;
  const auto wrong = check_bit_timing(config.bus);
  ASSERT_TRUE(wrong);
  EXPECT_STREQ(wrong->option, "bus.btr1");
  EXPECT_EQ(wrong->text, "found without bus.btr0; allowed: both together");
}

TEST(InterfaceRefusal, NamesTheCommandThatSetsTheBitRate) {
  const Config config = can_config();
  EXPECT_EQ(
      interface_refusal(config.bus, can::test::can0(250'000)),
      "can0 is set to 250000 bit/s, bus.bit_rate is 500000; set it with: ip link set can0 down; ip link set "
      "can0 type can bitrate 500000 sample-point 0.600; ip link set can0 up");
  EXPECT_EQ(interface_refusal(config.bus, can::test::can0(500'000)), "");
  EXPECT_EQ(interface_refusal(config.bus, {}), "") << "it may come later";
  can::LinkFacts ethernet = can::test::can0(500'000);
  ethernet.is_can = false;
  EXPECT_EQ(interface_refusal(config.bus, ethernet),
            "can0 is no CAN interface; give another one as bus.interface");
  can::LinkFacts virtual_one = can::test::can0();
  virtual_one.timing.reset();
  EXPECT_EQ(interface_refusal(config.bus, virtual_one), "");
}

TEST(InterfaceRefusal, AClockThatDoesNotDivideExactlyIsTakenWithinHalfAPercent) {
  const Config config = can_config();
  EXPECT_EQ(interface_refusal(config.bus, can::test::can0(498'753)), "");
  EXPECT_NE(
      interface_refusal(config.bus, can::test::can0(496'031))
          .find("It may be 0.8 % off because the controller's clock makes no better one; allowed: 0.5 %"),
      std::string::npos);
  EXPECT_EQ(interface_refusal(config.bus, can::test::can0(250'000)).find("clock"), std::string::npos);
}

TEST(InterfaceRefusal, WhatIsNotSetUpYetIsNotRefusedForItsMode) {
  Config config = can_config();
  config.bus.one_shot = OneShot::enforce;
  can::LinkFacts link = can::test::can0(500'000);
  link.one_shot = false;
  EXPECT_NE(interface_refusal(config.bus, link), "");
  link.up = false;
  EXPECT_EQ(interface_refusal(config.bus, link), "") << "once it is up nothing is sent until it has the mode";
}

TEST(BusEvents, EachStateOfTheInterfaceSaysWhatToDo) {
  const Config config = can_config();
  using can::LinkState;
  const EventText missing = describe_link({{}, LinkState::up, LinkState::missing, 0, 0}, config);
  EXPECT_EQ(missing.code, "interface_missing");
  EXPECT_EQ(missing.severity, gateway_SEVERITY_ERROR);
  EXPECT_EQ(missing.text,
            "there is no CAN interface can0, nothing is sent; plug the adapter in, or load its driver");
  can::LinkFacts link = can::test::can0();
  const auto down = [&] {
    return describe_link({{}, LinkState::up, LinkState::down, 0, 0}, config, link).text;
  };
  EXPECT_NE(down().find("set it up with: ip link set can0 down; ip link set can0 type can bitrate"),
            std::string::npos)
      << down();
  link.listen_only = true;
  EXPECT_NE(down().find(" listen-only off; ip link set can0 up"), std::string::npos) << down();
  link.listen_only = false;
  // A virtual interface has no bit timing: `ip` refuses to set one.
  link.driver_kind = {'v', 'c', 'a', 'n'};
  EXPECT_EQ(down(), "can0 is down, nothing is sent; set it up with: ip link set can0 up");
  EXPECT_EQ(describe_link({{}, LinkState::up, LinkState::wrong_bit_rate, 125'000, 0}, config).code,
            "wrong_bit_rate");
  Config pinned = config;
  pinned.bus.adapter = "serial=A,channel=1";
  can::LinkFacts exchanged = can::test::can0();
  exchanged.adapter.serial = {'B'};
  const EventText wrong =
      describe_link({{}, LinkState::up, LinkState::wrong_adapter, 0, 0}, pinned, exchanged);
  EXPECT_EQ(wrong.code, "wrong_adapter");
  EXPECT_EQ(wrong.severity, gateway_SEVERITY_ERROR);
  EXPECT_TRUE(
      wrong.text.starts_with("can0 has the adapter serial=B,channel=0, bus.adapter is "
                             "serial=A,channel=1: nothing is sent or received; "))
      << wrong.text;
  EXPECT_EQ(interface_refusal(pinned.bus, exchanged), wrong.text) << "at the start likewise";
  EXPECT_NE(interface_refusal(pinned.bus, can::test::can0()).find("no adapter that is known"),
            std::string::npos);
  const EventText up = describe_link({{}, LinkState::missing, LinkState::up, 500'000, 42}, config);
  EXPECT_EQ(up.severity, gateway_SEVERITY_INFO);
  EXPECT_EQ(up.text, "can0 is up again; 42 telegrams were left out");
}

TEST(BusLine, OneShotModeIsAskedForAsTheConfigurationSays) {
  Config config = can_config();
  can::LinkFacts facts = can::test::can0(500'000);
  EXPECT_EQ(one_shot_advice(config.bus, facts), "") << "a virtual interface, or a driver that does not tell";
  facts.one_shot = false;
  EXPECT_EQ(interface_refusal(config.bus, facts), "");
  EXPECT_EQ(
      one_shot_advice(config.bus, facts),
      "can0 is not in one-shot mode: with nobody on the bus telegrams wait in the controller until the "
      "daemon has reset it; set it with: ip link set can0 down; ip link set can0 type can one-shot on; ip "
      "link set can0 up");
  facts.can_one_shot = false;
  EXPECT_NE(one_shot_advice(config.bus, facts).find("its driver has none"), std::string::npos);
  config.bus.one_shot = OneShot::enforce;
  EXPECT_EQ(
      interface_refusal(config.bus, facts),
      "can0 is not in one-shot mode, bus.one_shot is \"enforce\"; its driver has none: set bus.one_shot to "
      "\"ignore\", and let the daemon reset the controller (CAP_NET_ADMIN, see the example reset.conf)");
  EXPECT_EQ(one_shot_advice(config.bus, facts), "");
  facts.one_shot = true;
  EXPECT_EQ(interface_refusal(config.bus, facts), "");
  config.bus.one_shot = OneShot::ignore;
  facts.one_shot = false;
  EXPECT_EQ(interface_refusal(config.bus, facts), "");
  EXPECT_EQ(one_shot_advice(config.bus, facts), "");
}

TEST(BusEvents, NobodyAcknowledges) {
  const Config config = can_config();
  using can::Delivery;
  const EventText begun = describe_delivery({{}, Delivery::normal, Delivery::unacknowledged, 0, 0}, config);
  EXPECT_EQ(begun.code, "not_delivered");
  EXPECT_EQ(begun.severity, gateway_SEVERITY_ERROR);
  EXPECT_NE(begun.text.find("check the cable, both terminating resistors, the power"), std::string::npos);
  const EventText kept =
      describe_delivery({{}, Delivery::unacknowledged, Delivery::not_emptied, 0, 0}, config);
  EXPECT_EQ(kept.code, "not_emptied");
  EXPECT_NE(kept.text.find("ip link set can0 down && ip link set can0 up"), std::string::npos);
  const EventText over = describe_delivery({{}, Delivery::unacknowledged, Delivery::normal, 6, 70}, config);
  EXPECT_EQ(over.code, "delivered_again");
  EXPECT_EQ(over.severity, gateway_SEVERITY_INFO);
  EXPECT_EQ(over.text, "telegrams are on the bus again; 6 were handed over in vain, 70 were left out");
  EXPECT_EQ(describe_link({{}, can::LinkState::up, can::LinkState::not_one_shot, 0, 0}, config).code,
            "not_one_shot");
  const EventText listens =
      describe_link({{}, can::LinkState::up, can::LinkState::listen_only, 0, 0}, config);
  EXPECT_EQ(listens.code, "listen_only");
  EXPECT_EQ(
      listens.text,
      "can0 is in listen-only mode: frames are received, nothing is sent; to send, set it with: ip link set "
      "can0 down && ip link set can0 type can listen-only off && ip link set can0 up");
}

TEST(BusEvents, FaultsBeginAndEnd) {
  const EventText begun = describe_fault({{}, BusFaultKind::not_acknowledged, false, 1});
  EXPECT_EQ(begun.code, "not_acknowledged");
  EXPECT_EQ(begun.severity, gateway_SEVERITY_WARNING);
  const EventText over = describe_fault({{}, BusFaultKind::not_acknowledged, true, 50});
  EXPECT_EQ(over.code, "acknowledged");
  EXPECT_EQ(over.text, "no longer: telegrams are acknowledged by nobody; it happened 50 times");
}

}  // namespace
}  // namespace cansyncd::test
