#include "can/adapter/adapter.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "can/adapter/adapters.h"

namespace can::test {
namespace {

namespace fs = std::filesystem;

TEST(AdapterPin, IsReadInAnyOrderAndToldInOne) {
  const ReadPin read = read_pin("channel=1,serial=0042B7");
  EXPECT_EQ(read.problem, "");
  EXPECT_EQ(read.pin.serial, "0042B7");
  EXPECT_EQ(read.pin.channel, 1u);
  EXPECT_EQ(text_of(read.pin), "serial=0042B7,channel=1");
  EXPECT_EQ(read_pin("path=pci-0000:03:00.0").pin.path, "pci-0000:03:00.0");
  EXPECT_EQ(read_pin("").problem, "") << "no pin";
}

TEST(AdapterPin, OfAWrongFormThePartIsNamedWithWhatIsAllowed) {
  for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
           {"0042B7", "\"0042B7\""},
           {"serial=", "\"serial=\""},
           {"serial=1,", "\"\""},
           {"serial=1,serial=2", "\"serial=2\""},
           {"path=a b", "\"path=a b\""},
           {"serial=1,channel=256", "\"channel=256\""},
           {"serial=1,channel=-1", "\"channel=-1\""},
           {"channel=1", "\"channel=1\", which names no adapter"},
           {"name=can0", "\"name=can0\""},
           {"path=" + std::string(64, 'x'), std::string(64, 'x')}}) {
    const std::string problem = read_pin(text).problem;
    EXPECT_NE(problem.find("found " + std::string(part.front() == '"' ? "" : "\"path=") + part),
              std::string::npos)
        << text << ": " << problem;
    EXPECT_NE(problem.find("allowed: path=PATH or serial=NUMBER"), std::string::npos) << text;
  }
}

/// sysfs of a made-up computer.
class Sysfs : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            ("sysfs-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(root_);
    fs::create_directories(root_ / "class" / "net");
  }
  void TearDown() override { fs::remove_all(root_); }

  /// A device below /sys/devices; `subsystem`: empty, it has none.
  fs::path device(const std::string& path, const std::string& subsystem) {
    const fs::path folder = root_ / "devices" / path;
    fs::create_directories(folder);
    if (!subsystem.empty() && !fs::is_symlink(folder / "subsystem"))
      fs::create_directory_symlink("/sys/bus/" + subsystem, folder / "subsystem");
    return folder;
  }
  static void put(const fs::path& file, const std::string& text) { std::ofstream(file) << text << "\n"; }

  /// An interface of `device`, null: a virtual one.
  void interface(const std::string& name, unsigned index, const fs::path& device,
                 const std::string& dev_port = "0", const std::string& dev_id = "0x0") {
    const fs::path folder = root_ / "class" / "net" / name;
    fs::create_directories(folder);
    if (!device.empty()) fs::create_directory_symlink(device, folder / "device");
    put(folder / "ifindex", std::to_string(index));
    put(folder / "type", "280");
    put(folder / "dev_port", dev_port);
    put(folder / "dev_id", dev_id);
  }

  /// A USB adapter in a port: its interface's device.
  fs::path usb(const std::string& port, const std::string& serial) {
    device("pci0000:00", "");
    device("pci0000:00/0000:00:14.0", "pci");
    const std::string hub = "pci0000:00/0000:00:14.0/usb1";
    put(device(hub, "usb") / "idVendor", "1d6b");
    put(root_ / "devices" / hub / "serial", "0000:00:14.0");
    const fs::path one = device(hub + "/1-" + port, "usb");
    put(one / "idVendor", "1d50");
    if (!serial.empty()) put(one / "serial", serial);
    return device(hub + "/1-" + port + "/1-" + port + ":1.0", "usb");
  }
  fs::path pci(const std::string& slot) {
    device("pci0000:00", "");
    device("pci0000:00/0000:00:1c.0", "pci");
    return device("pci0000:00/0000:00:1c.0/" + slot, "pci");
  }

  std::string adapter(const std::string& name, unsigned index) {
    return text_of(adapter_of(name, index, root_));
  }
  /// The pin that `scan` writes.
  std::string pin(const std::string& name) {
    const auto found = pin_of(name, adapters_there(root_));
    return found ? text_of(*found) : "none";
  }

  fs::path root_;
};

TEST_F(Sysfs, TellsPathSerialAndChannelAsUdevDoes) {
  interface("can0", 3, usb("2", "0042 B7 "));
  interface("can1", 4, usb("1.4", ""));
  interface("can2", 5, pci("0000:03:00.0"), "0", "0x1");
  interface("can3", 6, pci("0000:03:00.0"), "2");
  device("platform/soc", "platform");
  device("platform/soc/fe204000.spi", "platform");
  device("platform/soc/fe204000.spi/spi_master", "");
  device("platform/soc/fe204000.spi/spi_master/spi0", "spi_master");
  interface("can4", 7, device("platform/soc/fe204000.spi/spi_master/spi0/spi0.1", "spi"));
  interface("vcan0", 8, {});
  EXPECT_EQ(adapter("can0", 3), "path=pci-0000:00:14.0-usb-0:2:1.0,serial=0042_B7,channel=0");
  EXPECT_EQ(adapter("can1", 4), "path=pci-0000:00:14.0-usb-0:1.4:1.0,channel=0")
      << "not the hub's serial number";
  EXPECT_EQ(adapter("can2", 5), "path=pci-0000:03:00.0,channel=1") << "an older driver";
  EXPECT_EQ(adapter("can3", 6), "path=pci-0000:03:00.0,channel=2");
  EXPECT_EQ(adapter("can4", 7), "path=platform-fe204000.spi-cs-1,channel=0");
  EXPECT_EQ(adapter("vcan0", 8), "") << "virtual";
  EXPECT_EQ(adapter("can0", 4), "") << "the name was given to another interface meanwhile";
  EXPECT_EQ(adapter("can9", 4), "");
  std::vector<std::string> there;
  for (const InterfaceAdapter& one : adapters_there(root_)) there.push_back(one.interface);
  EXPECT_EQ(there, (std::vector<std::string>{"can0", "can1", "can2", "can3", "can4"}));
}

TEST_F(Sysfs, WhatIsTooLongOrHasNoPlaceIsNotKnown) {
  interface("can0", 3, usb("2", std::string(40, '7')));
  interface("can1", 4, device("virtual/dongle", "strange"));
  EXPECT_EQ(adapter("can0", 3), "path=pci-0000:00:14.0-usb-0:2:1.0,channel=0");
  EXPECT_EQ(adapter("can1", 4), "");
}

TEST_F(Sysfs, APinIsTheSerialNumberWhereThatTellsAdaptersApart) {
  interface("can0", 3, usb("1", "A"));
  interface("can1", 4, usb("2", "B"));
  EXPECT_EQ(pin("can0"), "serial=A");
  interface("can2", 5, usb("2", "B"), "1");
  EXPECT_EQ(pin("can1"), "serial=B,channel=0");
  EXPECT_EQ(pin("can2"), "serial=B,channel=1");
  EXPECT_EQ(pin("can7"), "none");
}

TEST_F(Sysfs, OfTwoWithOneSerialNumberAPinIsThePath) {
  interface("can0", 3, usb("1", "0001"));
  interface("can1", 4, usb("2", "0001"));
  interface("can2", 5, pci("0000:03:00.0"));
  EXPECT_EQ(pin("can0"), "path=pci-0000:00:14.0-usb-0:1:1.0");
  EXPECT_EQ(pin("can2"), "path=pci-0000:03:00.0");
  EXPECT_EQ(interfaces_of(read_pin("serial=0001").pin, adapters_there(root_)),
            (std::vector<std::string>{"can0", "can1"}));
}

TEST_F(Sysfs, TwoInterfacesThatNothingTellsApartHaveNoPin) {
  interface("can0", 3, pci("0000:03:00.0"));
  interface("can1", 4, pci("0000:03:00.0"));
  EXPECT_EQ(pin("can0"), "none");
}

TEST(InterfaceNames, ThatTheKernelGivesByItselfAreToldApart) {
  for (const char* name : {"can0", "can12", "vcan0", "slcan3", "vxcan1"})
    EXPECT_TRUE(is_kernel_name(name)) << name;
  for (const char* name : {"can", "can-winder", "can0b", "winder0", "xcan0"})
    EXPECT_FALSE(is_kernel_name(name)) << name;
}

TEST(AdapterPin, MatchesWhatItNamesAndNothingUnknown) {
  Adapter adapter;
  const AdapterPin serial = read_pin("serial=A").pin;
  EXPECT_FALSE(matches(serial, adapter)) << "not known";
  EXPECT_TRUE(matches({}, adapter)) << "no pin";
  adapter.serial = {'A'};
  adapter.channel = 1;
  EXPECT_TRUE(matches(serial, adapter));
  EXPECT_TRUE(matches(read_pin("serial=A,channel=1").pin, adapter));
  EXPECT_FALSE(matches(read_pin("serial=A,channel=0").pin, adapter));
  EXPECT_FALSE(matches(read_pin("serial=AB").pin, adapter));
  EXPECT_FALSE(matches(read_pin("serial=A,path=pci-0000:03:00.0").pin, adapter));
}

}  // namespace
}  // namespace can::test
