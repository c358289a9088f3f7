#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "cli/doctor/doctor_input.h"

namespace cansync::cli {
namespace {

TEST(Doctor, AnInterfaceInANetworkNamespaceIsNotMissing) {
  DoctorInput in = apart();
  EXPECT_EQ(find(diagnose(in), "interface")->level, Level::ok);
  put(in.status->bus.controller_state, "bus-off");
  EXPECT_NE(find(diagnose(in), "controller")->remedy.find("ip -n cansync-can0 link set can0 down && ip -n"),
            std::string::npos);
  put(in.status->bus.link_state, "missing");
  EXPECT_EQ(find(diagnose(in), "interface")->level, Level::error);
}

TEST(Doctor, ASimulatedLineHasNoInterface) {
  DoctorInput in = healthy();
  in.interface_name = "sim";
  in.link = {};
  const auto findings = diagnose(in);
  EXPECT_EQ(exit_code(findings, true), ExitCode::done);
  for (const char* topic : {"bit rate", "sample point", "restart-ms", "one-shot", "echo", "txqueuelen"})
    EXPECT_EQ(find(findings, topic), nullptr) << topic;
}

can::InterfaceAdapter adapter(const char* interface, std::string_view serial) {
  can::InterfaceAdapter one{interface, {}};
  std::copy(serial.begin(), serial.end(), one.adapter.serial.begin());
  return one;
}

/// One of two adapters, which the kernel names in the order in which it finds them.
DoctorInput with_two_adapters() {
  DoctorInput in = healthy();
  in.adapters = {adapter("can0", "A"), adapter("can1", "B")};
  in.link.adapter = in.adapters.front().adapter;
  return in;
}

TEST(Doctor, OneOfTwoAdaptersWithTheKernelsNameIsAWarning) {
  DoctorInput in = with_two_adapters();
  const auto findings = diagnose(in);
  const Finding* found = find(findings, "adapter");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->level, Level::warning);
  EXPECT_EQ(found->found, "serial=A,channel=0 of 2 adapters; after a boot can0 can be another one");
  EXPECT_NE(found->remedy.find("set bus.adapter = \"serial=A\""), std::string::npos) << found->remedy;
  EXPECT_NE(found->remedy.find("cansync scan can0 --write FOLDER --interface-name"), std::string::npos);
  in.adapters.pop_back();
  EXPECT_EQ(find(diagnose(in), "adapter"), nullptr) << "the only one";
  in = with_two_adapters();
  in.interface_name = "can-winder";
  in.adapters.front().interface = "can-winder";
  EXPECT_EQ(find(diagnose(in), "adapter")->level, Level::ok) << "a name that somebody gave to it";
}

TEST(Doctor, APinnedAdapterIsComparedAndTheRightOneNamed) {
  DoctorInput in = with_two_adapters();
  put(in.status->bus.adapter_wanted, "serial=A");
  EXPECT_EQ(find(diagnose(in), "adapter")->level, Level::ok);
  put(in.status->bus.adapter_wanted, "serial=B");
  put(in.status->bus.link_state, "wrong-adapter");
  auto findings = diagnose(in);
  const Finding* found = find(findings, "adapter");
  EXPECT_EQ(found->level, Level::error);
  EXPECT_EQ(found->found,
            "serial=A,channel=0, but bus.adapter is serial=B: nothing is sent or received; that one is can1");
  in.adapters.pop_back();
  findings = diagnose(in);
  EXPECT_NE(find(findings, "adapter")->found.find("that one is not there"), std::string::npos);
  in.adapters = {adapter("can0", "B"), adapter("can1", "B")};
  in.link.adapter = in.adapters.front().adapter;
  put(in.status->bus.link_state, "up");
  findings = diagnose(in);
  EXPECT_EQ(find(findings, "adapter")->level, Level::warning);
  EXPECT_EQ(find(findings, "adapter")->found, "bus.adapter is serial=B, which can0 and can1 have");
}

TEST(Doctor, AVirtualInterfaceHasNothingToSet) {
  DoctorInput in = healthy();
  in.link = can_link("vcan");
  in.link.queue_length = 0;
  const auto findings = diagnose(in);
  EXPECT_EQ(exit_code(findings, true), ExitCode::done);
  ASSERT_NE(find(findings, "interface"), nullptr);
  EXPECT_EQ(find(findings, "interface")->found, "can0 is up, virtual (vcan): nothing to set");
  for (const char* topic : {"bit rate", "sample point", "restart-ms", "one-shot", "echo", "txqueuelen"})
    EXPECT_EQ(find(findings, topic), nullptr) << topic;
  in.link.up = false;
  EXPECT_EQ(find(diagnose(in), "interface")->remedy, "ip link set can0 up");
}

TEST(Doctor, ADriverWithoutOneShotHasNothingToSet) {
  DoctorInput in = healthy();
  in.link.one_shot = false;
  in.link.can_one_shot = false;
  EXPECT_EQ(find(diagnose(in), "one-shot")->level, Level::ok);
  in.link.one_shot.reset();
  EXPECT_EQ(find(diagnose(in), "one-shot"), nullptr);
}

TEST(Doctor, OneShotIsForLinesWithSlots) {
  DoctorInput in = healthy();
  in.status->master.reset();
  put(in.status->realtime.sync_state, "");
  in.link.one_shot = false;
  EXPECT_EQ(find(diagnose(in), "one-shot")->level, Level::ok);
  in.link.one_shot = true;
  const auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "one-shot")->level, Level::warning);
  EXPECT_NE(find(findings, "one-shot")->remedy.find("one-shot off"), std::string::npos);
  put(in.status->realtime.sync_state, "locked");  // a slave's
  EXPECT_EQ(find(diagnose(in), "one-shot")->level, Level::ok);
}

TEST(Doctor, ASamplePointAsNearAsAControllerComesIsWell) {
  DoctorInput in = healthy();
  in.link.timing->sample_point = 625;  // 10 of 16 quanta
  EXPECT_EQ(exit_code(diagnose(in), true), ExitCode::done);
  in.link.timing->sample_point = 633;
  EXPECT_EQ(exit_code(diagnose(in), true), ExitCode::failed);
}

TEST(Doctor, ABusWithoutSlotsHasTheSamplePointOfItsProtocol) {
  DoctorInput in = healthy();
  in.status->master.reset();
  put(in.status->realtime.sync_state, "");
  in.status->bus.sample_point_wanted = 875;  // J1939
  for (const std::uint16_t point : {std::uint16_t{800}, std::uint16_t{875}, std::uint16_t{900}}) {
    in.link.timing->sample_point = point;
    EXPECT_EQ(find(diagnose(in), "sample point")->level, Level::ok) << point;
  }
  for (const std::uint16_t point : {std::uint16_t{600}, std::uint16_t{799}, std::uint16_t{901}}) {
    in.link.timing->sample_point = point;
    const auto findings = diagnose(in);
    EXPECT_EQ(find(findings, "sample point")->level, Level::warning) << point;
    EXPECT_NE(find(findings, "sample point")->remedy.find("sample-point 0.875"), std::string::npos);
  }
  in.status->bus.sample_point_wanted = 0;  // general frames
  EXPECT_EQ(find(diagnose(in), "sample point"), nullptr);
}

TEST(Doctor, AnOlderDaemonLeavesTheSamplePointsOfBothFamilies) {
  DoctorInput in = healthy();
  in.status->bus.sample_point_wanted = 0;
  for (const std::uint16_t point : {std::uint16_t{600}, std::uint16_t{875}}) {
    in.link.timing->sample_point = point;
    EXPECT_EQ(find(diagnose(in), "sample point")->level, Level::ok) << point;
  }
  in.link.timing->sample_point = 750;
  EXPECT_EQ(find(diagnose(in), "sample point")->level, Level::warning);
  // The Omega Drive-Line II has no 1 Mbit/s.
  in.status->bus.bit_rate = in.link.timing->bits_per_second = 1'000'000;
  in.link.timing->sample_point = 875;
  EXPECT_EQ(find(diagnose(in), "sample point")->level, Level::warning);
}

TEST(Doctor, WithoutADaemonLooksAtTheInterfaceItself) {
  DoctorInput in = healthy();
  in.status.reset();
  in.no_daemon = "no daemon found";
  in.link.state = can::ControllerState::bus_off;
  in.link.transmit_errors = 248;
  auto findings = diagnose(in);
  EXPECT_EQ(find(findings, "bit rate")->found, "500000 bit/s");
  EXPECT_EQ(find(findings, "bit rate")->level, Level::ok);
  EXPECT_EQ(find(findings, "controller")->level, Level::error);
  EXPECT_EQ(find(findings, "controller")->remedy, "ip link set can0 down && ip link set can0 up");
  EXPECT_EQ(find(findings, "error counters")->found, "248 transmit, 0 receive");
  in.link.timing->bits_per_second = 800'000;
  in.link.up = in.link.has_counters = false;
  findings = diagnose(in);
  EXPECT_EQ(find(findings, "bit rate")->level, Level::error);
  EXPECT_NE(find(findings, "bit rate")->remedy.find("bitrate 1000000 sample-point 0.600"), std::string::npos);
  EXPECT_EQ(find(findings, "controller"), nullptr) << "it is down";
  EXPECT_EQ(find(findings, "error counters"), nullptr);
}

}  // namespace
}  // namespace cansync::cli
