#include "can/adapter/adapters.h"

#include <linux/if_arp.h>

#include <algorithm>
#include <charconv>
#include <exception>
#include <fstream>
#include <iterator>
#include <system_error>

namespace can {
namespace {

namespace fs = std::filesystem;

/// First line of a file of sysfs; empty when there is none.
std::string line_of(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// A whole number as sysfs writes it, also with 0x; 0 when there is none.
std::uint32_t number_of(const fs::path& file) {
  const std::string text = line_of(file);
  const bool hexadecimal = text.starts_with("0x");
  const char* const begin = text.data() + (hexadecimal ? 2 : 0);
  std::uint32_t number = 0;
  std::from_chars(begin, text.data() + text.size(), number, hexadecimal ? 16 : 10);
  return number;
}

/// The subsystem of a device; empty: the folder is no device.
std::string subsystem_of(const fs::path& device) {
  std::error_code error;
  return fs::read_symlink(device / "subsystem", error).filename().string();
}

template <std::size_t N>
void put(const std::string& text, std::array<char, N>& out) noexcept {
  // One that does not fit is not known: a part of it could be that of another.
  if (text.size() < N) std::copy(text.begin(), text.end(), out.begin());
}

/// One part of the path that udev gives to a device; empty: its subsystem adds none.
std::string path_part(const std::string& subsystem, const std::string& name) {
  if (subsystem == "pci" || subsystem == "platform") return subsystem + "-" + name;
  if (subsystem == "usb" && name.find('-') != std::string::npos)
    return "usb-0:" + name.substr(name.find('-') + 1);
  if (subsystem != "spi") return {};
  const auto last = std::find_if_not(name.rbegin(), name.rend(), [](char c) { return c >= '0' && c <= '9'; });
  return "cs-" + std::string(last.base(), name.end());
}

/// From the device up to the root of all devices: a part for each subsystem on the way, that of the innermost
/// device of each.
std::string path_of(fs::path device, const fs::path& top) {
  std::string path;
  bool unique = false;  // below a parent whose name stays the same over boots
  std::string before;
  for (; device != top && device.has_relative_path(); device = device.parent_path()) {
    const std::string subsystem = subsystem_of(device);
    if (subsystem.empty()) continue;
    const std::string part = subsystem == before ? std::string() : path_part(subsystem, device.filename());
    before = subsystem;
    if (part.empty()) continue;
    if (!path.empty()) path.insert(0, "-");
    path.insert(0, part);
    unique = unique || subsystem == "pci" || subsystem == "platform";
  }
  return unique ? path : std::string();
}

/// As udev writes it: runs of blanks as '_'; a serial number with other characters than printable ones is none.
std::string usb_serial(const std::string& text) {
  std::string out;
  for (const char letter : text) {
    if (letter < ' ' || letter > '~' || letter == ',' || letter == '"') return {};
    if (letter != ' ')
      out += letter;
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (out.ends_with('_') && text.ends_with(' ')) out.pop_back();
  return out;
}

/// Of the USB device that the interface belongs to; a hub above it has one, too, which says nothing.
std::string serial_of(fs::path device, const fs::path& top) {
  for (; device != top && device.has_relative_path(); device = device.parent_path()) {
    if (subsystem_of(device) != "usb") continue;
    std::error_code error;
    if (fs::exists(device / "idVendor", error)) return usb_serial(line_of(device / "serial"));
  }
  return {};
}

Adapter read_adapter(const fs::path& interface, const fs::path& root) {
  std::error_code error;
  const fs::path device = fs::canonical(interface / "device", error);
  if (error) return {};
  const fs::path top = fs::weakly_canonical(root / "devices", error);
  Adapter adapter;
  put(path_of(device, top), adapter.path);
  put(serial_of(device, top), adapter.serial);
  adapter.channel = number_of(interface / "dev_port");
  if (adapter.channel == 0) adapter.channel = number_of(interface / "dev_id");
  return adapter;
}

}  // namespace

Adapter adapter_of(std::string_view interface, std::uint32_t index, const fs::path& root) noexcept {
  try {
    const fs::path folder = root / "class" / "net" / interface;
    if (number_of(folder / "ifindex") != index) return {};
    const Adapter adapter = read_adapter(folder, root);
    // An interface that was renamed meanwhile is read again with its index.
    return number_of(folder / "ifindex") == index ? adapter : Adapter{};
  } catch (const std::exception&) {
    return {};
  }
}

std::vector<InterfaceAdapter> adapters_there(const fs::path& root) {
  std::vector<InterfaceAdapter> there;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(root / "class" / "net", error)) {
    if (number_of(entry.path() / "type") != ARPHRD_CAN) continue;
    InterfaceAdapter one{entry.path().filename().string(), read_adapter(entry.path(), root)};
    if (one.adapter.known()) there.push_back(std::move(one));
  }
  std::sort(there.begin(), there.end(),
            [](const InterfaceAdapter& a, const InterfaceAdapter& b) { return a.interface < b.interface; });
  return there;
}

bool is_kernel_name(std::string_view interface) noexcept {
  for (const std::string_view prefix : {"can", "vcan", "slcan", "vxcan"}) {
    if (interface.starts_with(prefix) && interface.size() > prefix.size() &&
        interface.find_first_not_of("0123456789", prefix.size()) == std::string_view::npos)
      return true;
  }
  return false;
}

std::optional<AdapterPin> pin_of(std::string_view interface, const std::vector<InterfaceAdapter>& there) {
  const auto found = std::find_if(there.begin(), there.end(), [interface](const InterfaceAdapter& one) {
    return one.interface == interface;
  });
  if (found == there.end()) return std::nullopt;
  const Adapter& adapter = found->adapter;
  const AdapterPin by_serial{{}, adapter.serial.data(), std::nullopt};
  const AdapterPin by_path{adapter.path.data(), {}, std::nullopt};
  for (AdapterPin pin : {by_serial, by_path}) {
    if (pin.serial.empty() && pin.path.empty()) continue;
    if (interfaces_of(pin, there).size() == 1 && adapter.channel == 0) return pin;
    pin.channel = adapter.channel;
    if (interfaces_of(pin, there).size() == 1) return pin;
  }
  return std::nullopt;
}

std::vector<std::string> interfaces_of(const AdapterPin& pin, const std::vector<InterfaceAdapter>& there) {
  std::vector<std::string> out;
  for (const InterfaceAdapter& one : there) {
    if (matches(pin, one.adapter)) out.push_back(one.interface);
  }
  return out;
}

}  // namespace can
