#pragma once

#include <string>

namespace cansync::cli {

/// "process 12 on host cab": how the daemon names the writers of this process.
std::string name_of_this_process();

}  // namespace cansync::cli
