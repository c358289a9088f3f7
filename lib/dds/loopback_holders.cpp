#include "dds/loopback_holders.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "dds/loopback_ports.h"
#include "text/counts.h"

namespace gateway::dds {
namespace {

namespace fs = std::filesystem;

/// Local port and inode of each UDP socket.
std::vector<std::pair<std::uint32_t, std::string>> udp_sockets() {
  std::vector<std::pair<std::uint32_t, std::string>> found;
  std::ifstream file("/proc/net/udp");
  std::string line;
  std::getline(file, line);  // the heading
  while (std::getline(file, line)) {
    constexpr std::size_t kInode = 9;  // which word it is
    std::istringstream words(line);
    std::vector<std::string> word;
    for (std::string one; words >> one;) word.push_back(one);
    const std::size_t colon = word.size() > kInode ? word[1].find(':') : std::string::npos;
    std::uint32_t port = 0;
    if (colon == std::string::npos) continue;
    std::from_chars(word[1].data() + colon + 1, word[1].data() + word[1].size(), port, 16);
    found.emplace_back(port, word[kInode]);
  }
  return found;
}

/// Sockets of these inodes that each program has, by its name.
std::map<std::string, unsigned> programs_with(const std::set<std::string>& inodes) {
  std::map<std::string, unsigned> programs;
  std::error_code error;
  for (const auto& process : fs::directory_iterator("/proc", error)) {
    const std::string id = process.path().filename().string();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    std::error_code closed;  // another user's, or it has ended
    for (fs::directory_iterator next(process.path() / "fd", closed), end; !closed && next != end;
         next.increment(closed)) {
      std::error_code gone;
      const std::string target = fs::read_symlink(next->path(), gone).string();
      constexpr std::string_view kSocket = "socket:[";
      if (gone || !target.starts_with(kSocket)) continue;
      if (!inodes.contains(target.substr(kSocket.size(), target.size() - kSocket.size() - 1))) continue;
      std::ifstream comm(process.path() / "comm");
      std::string name;
      std::getline(comm, name);
      ++programs[name.empty() ? "a program" : name];
    }
  }
  return programs;
}

}  // namespace

PlacesTaken places_taken(std::uint32_t domain) {
  PlacesTaken taken;
  std::set<std::string> inodes;
  for (const auto& [port, inode] : udp_sockets()) {
    const std::uint32_t first = serving_port(domain, 0);
    if (port < first || port > asking_port(domain, kPlaces - 1) || !inodes.insert(inode).second) continue;
    ++((port - first) % 2 == 0 ? taken.serving : taken.asking);
  }
  std::vector<std::pair<unsigned, std::string>> most;
  for (const auto& [name, count] : programs_with(inodes)) most.emplace_back(count, name);
  std::sort(most.rbegin(), most.rend());
  constexpr std::size_t kNamed = 5;
  for (std::size_t i = 0; i < std::min(most.size(), kNamed); ++i)
    taken.holders += fmt::format("{}{} {}", i == 0 ? "" : ", ", most[i].second, most[i].first);
  return taken;
}

std::string text_of(const PlacesTaken& taken) {
  return fmt::format("{} of daemons and {} of {} of clients are taken{}",
                     text::counted_of(taken.serving, kPlaces, "place"), taken.asking, kPlaces,
                     taken.holders.empty() ? "" : " (" + taken.holders + ")");
}

}  // namespace gateway::dds
