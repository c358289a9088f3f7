#include "can/adapter/link_remedy.h"

#include <string_view>

namespace can {
namespace {

enum class Kind : std::uint8_t { adapter, virtual_one, serial };

Kind kind_of(const std::string& name, const LinkFacts& link) {
  const std::string_view driver(link.driver_kind.data());
  // The driver of slcan names no kind before Linux 6.0, and "can" since then.
  if (driver == "slcan" || name.starts_with("slcan")) return Kind::serial;
  if (driver == "vcan" || driver == "vxcan") return Kind::virtual_one;
  const bool called_so = name.starts_with("vcan") || name.starts_with("vxcan");
  return driver.empty() && called_so ? Kind::virtual_one : Kind::adapter;
}

std::string up(const std::string& name) {
  return "ip link set " + name + " up";
}

}  // namespace

std::string link_remedy(const std::string& name, const LinkFacts& link, std::uint32_t bit_rate) {
  switch (kind_of(name, link)) {
    case Kind::virtual_one:
      return link.present ? up(name) : "ip link add dev " + name + " type vcan && " + up(name);
    case Kind::serial:
      if (link.present) return up(name) + "   (its bit rate is that of slcand, such as -s6 for 500 kbit/s)";
      return "slcand -o -s6 /dev/ttyACM0 " + name + " && " + up(name) +
             "   (-s6: 500 kbit/s; the adapter's serial device)";
    case Kind::adapter:
      break;
  }
  if (!link.present)
    return "plug the adapter in or load its driver; `ip -br link show type can` lists the CAN interfaces";
  if (link.timing && (bit_rate == 0 || keeps_bit_rate(*link.timing, bit_rate))) return up(name);
  if (bit_rate != 0) return up(name) + " type can bitrate " + std::to_string(bit_rate);
  return up(name) + " type can bitrate 500000   (the bit rate of the bus)";
}

std::string sending_remedy(const std::string& name) {
  return "ip link set " + name + " down && ip link set " + name + " type can listen-only off && " + up(name);
}

}  // namespace can
