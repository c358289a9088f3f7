#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/adapter/adapter.h"
#include "can/link_facts.h"
#include "cansync/settings/timing.h"
#include "cli/learn/learn_files.h"

namespace cansync::cli {

/// The interface that files for the boot are written for.
struct NetworkInterface {
  std::string name;         ///< that it is to have
  bool is_renamed = false;  ///< it has another one now; needs `pin`
  can::LinkFacts link;
  std::optional<can::AdapterPin> pin;  ///< of its adapter; nothing: nothing distinguishes it from others
};

/// The files of systemd that name this interface and set it up at the boot: for a controller link and network,
/// for a virtual interface netdev and network. Their paths have no folder. Pure.
std::vector<LearnedFile> network_files(const NetworkInterface& interface, BitRate rate);

}  // namespace cansync::cli
