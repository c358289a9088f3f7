#include "cli/scan/network_files.h"

#include <fmt/format.h>

#include <cstring>

namespace cansync::cli {
namespace {

bool is_virtual_link(const can::LinkFacts& link) {
  return std::strcmp(link.driver_kind.data(), "vcan") == 0;
}

std::vector<LearnedFile> virtual_files(const std::string& interface) {
  return {
      {fmt::format("25-{}.netdev", interface),
       fmt::format(
           "# A virtual CAN interface, to try things out without hardware.\n[NetDev]\nName={}\nKind=vcan\n",
           interface)},
      {fmt::format("25-{}.network", interface),
       fmt::format("# Brings the virtual interface up. It has no bit rate.\n[Match]\nName={}\n\n[Link]\n"
                   "RequiredForOnline=no\n\n[Network]\nLinkLocalAddressing=no\n",
                   interface)}};
}

/// Which adapter a .link file is for. The channel is a property that 60-cansyncd.rules gives to CAN interfaces.
std::string match_text(const can::AdapterPin& pin) {
  std::string out;
  if (!pin.path.empty()) out += fmt::format("Path={}\n", pin.path);
  std::string properties;
  if (!pin.serial.empty()) properties = fmt::format(" ID_SERIAL_SHORT={}", pin.serial);
  if (pin.channel) properties += fmt::format(" CANSYNC_CHANNEL={}", *pin.channel);
  return properties.empty() ? out : fmt::format("{}Property={}\n", out, properties.substr(1));
}

std::string link_text(const NetworkInterface& interface) {
  std::string out = "# Name and settings of the interface itself, applied when it appears.\n[Match]\n";
  out += interface.pin ? match_text(*interface.pin)
                       : "# Nothing distinguishes its adapter from others: another one may get this name.\n"
                         "OriginalName=" +
                             interface.name + "\n";
  out += "\n[Link]\n";
  if (interface.is_renamed)
    out += fmt::format(
        "# The name stays with the adapter, in whatever order the kernel finds several.\nName={}\n",
        interface.name);
  else if (interface.pin)
    out +=
        "# With a second adapter, give it a name of your choice that the kernel does not use:\n#Name=can-line1\n";
  return out +
         "# What stands in this queue is still sent when the daemon dies; it sends at most three frames in an interval.\n"
         "TransmitQueueLength=10\n";
}

std::string network_text(const std::string& interface, const can::LinkFacts& link, BitRate rate) {
  const bool known = link.timing && link.timing->sample_point != 0;
  const double sample_point = known ? link.timing->sample_point / 10.0 : 60.0;
  return fmt::format(
      "# Sets the CAN interface up, so that nobody else needs the right to.\n[Match]\nName={}\n\n[Link]\n"
      "# It has no address, which the boot would wait for.\nRequiredForOnline=no\n\n[CAN]\n"
      "BitRate={}K\n# That of the other nodes: b maXX PLC 60 %, Omega Drive-Line II 87.5 %.{}\n"
      "SamplePoint={:g}%\n# After this time in bus-off the kernel lets the controller take part again.\n"
      "RestartSec=100ms\n"
      "# Take the # away when the driver has this mode (docs/operations.md, \"When nobody acknowledges\"):\n"
      "#OneShot=yes\n",
      interface, slot_times(rate).bits_per_second / 1000,
      known ? " The interface had this one." : " Not known here: look it up.", sample_point);
}

}  // namespace

std::vector<LearnedFile> network_files(const NetworkInterface& interface, BitRate rate) {
  if (is_virtual_link(interface.link)) return virtual_files(interface.name);
  // Below 70: those of systemd come later, and the first that matches is the only one.
  return {{fmt::format("60-{}.link", interface.name), link_text(interface)},
          {fmt::format("80-{}.network", interface.name), network_text(interface.name, interface.link, rate)}};
}

}  // namespace cansync::cli
