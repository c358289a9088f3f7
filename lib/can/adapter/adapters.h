#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/adapter/adapter.h"

/// The CAN adapters of this computer as sysfs shows them. Reads files; threads of normal priority.
namespace can {

/// An interface with the adapter behind it.
struct InterfaceAdapter {
  std::string interface;
  Adapter adapter;
};

/// Adapter of `interface`, whose index is `index`; one that is not known when sysfs shows another interface by
/// that name, or none. `root`: where sysfs is mounted.
///
/// The path is built as udev's builtin path_id does, for PCI, USB, platform devices and SPI below them; so
/// `Path=` of a .link file of systemd matches it. The channel is `dev_port`, or where that is 0 `dev_id`, by
/// which older drivers tell controllers of one adapter apart.
Adapter adapter_of(std::string_view interface, std::uint32_t index,
                   const std::filesystem::path& root = "/sys") noexcept;

/// Every CAN interface with hardware behind it, sorted by name.
std::vector<InterfaceAdapter> adapters_there(const std::filesystem::path& root = "/sys");

/// Is it a name that the kernel gives by itself, so that another interface may come to have it: "can0"?
bool is_kernel_name(std::string_view interface) noexcept;

/// The shortest pin that allows the adapter of `interface` and no other of `there`: its serial number, else its
/// path, with the channel where the adapter has more of them. Nothing: it is not known, or none tells it from
/// the others.
std::optional<AdapterPin> pin_of(std::string_view interface, const std::vector<InterfaceAdapter>& there);

/// The interfaces of `there` whose adapters `pin` allows.
std::vector<std::string> interfaces_of(const AdapterPin& pin, const std::vector<InterfaceAdapter>& there);

}  // namespace can
