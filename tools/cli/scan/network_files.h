#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "can/link_facts.h"
#include "cansync/settings/timing.h"
#include "cli/learn/learn_files.h"

namespace cansync::cli {

/// The files of systemd-networkd that set this interface up at the boot: for a controller link and network,
/// for a virtual interface netdev and network. Their paths have no folder. Pure.
std::vector<LearnedFile> network_files(const std::string& interface, const can::LinkFacts& link,
                                       BitRate rate);

}  // namespace cansync::cli
