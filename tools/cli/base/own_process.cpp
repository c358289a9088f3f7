#include "cli/base/own_process.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>

namespace cansync::cli {

std::string name_of_this_process() {
  // The daemon shortens what peers say of themselves.
  constexpr std::size_t kLongestPart = 40;
  return fmt::format("process {} on host {}", ::getpid(), name_of_this_host().substr(0, kLongestPart));
}

std::string name_of_this_host() {
  std::array<char, 256> host{};
  static_cast<void>(::gethostname(host.data(), host.size() - 1));
  return host.data();
}

}  // namespace cansync::cli
