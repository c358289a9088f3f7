#pragma once

#include <string>

namespace cansync::cli {

/// "process 12 on host cab": how the daemon names the writers of this process.
std::string name_of_this_process();
/// Name of this computer, as the daemon on it has it in GatewayStatus.host.
std::string name_of_this_host();

}  // namespace cansync::cli
