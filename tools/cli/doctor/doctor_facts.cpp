#include "cli/doctor/doctor_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <string_view>

#include "config/document.h"
#include "rt/kernel_type.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kMostIdleStates = 16;
constexpr std::size_t kMostCharacters = 4096;

/// First line of a file; nothing when it cannot be read.
std::optional<std::string> first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string text(kMostCharacters, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  if (text.empty()) return std::nullopt;
  return text.substr(0, text.find('\n'));
}

/// A whole decimal number; nothing for everything else.
std::optional<std::uint32_t> number(const std::optional<std::string>& text) {
  if (!text) return std::nullopt;
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc{} || end != text->data() + text->size()) return std::nullopt;
  return value;
}

std::vector<IdleState> read_idle_states(const fs::path& root, int cpu) {
  const fs::path folder = root / fmt::format("sys/devices/system/cpu/cpu{}/cpuidle", std::max(cpu, 0));
  std::vector<IdleState> states;
  for (unsigned i = 0; i < kMostIdleStates; ++i) {
    const fs::path state = folder / fmt::format("state{}", i);
    const auto name = first_line(state / "name");
    if (!name) break;
    if (number(first_line(state / "disable")).value_or(0) != 0) continue;
    states.push_back({*name, number(first_line(state / "latency")).value_or(0)});
  }
  return states;
}

/// The text of an option of [bus]; empty: it is not there, or is no text.
std::string text_of(const config::Document& document, std::string_view option) {
  for (const config::Node& node : document.nodes) {
    const bool it_is = node.kind == config::Node::Kind::value && node.path.size() == 2 &&
                       node.path.front().name == "bus" && node.name() == option;
    if (!it_is) continue;
    const std::string* text = config::scalar<std::string>(node.value);
    return text != nullptr ? *text : std::string();
  }
  return {};
}

}  // namespace

MachineFacts read_machine(const fs::path& root, int cpu) {
  MachineFacts facts;
  facts.kernel = first_line(root / "proc/sys/kernel/osrelease").value_or("");
  if (const auto version = first_line(root / "proc/sys/kernel/version"))
    facts.preemption = rt::preemption_of(*version);
  facts.isolated = first_line(root / "sys/devices/system/cpu/isolated").value_or("");
  facts.idle_states = read_idle_states(root, cpu);
  return facts;
}

std::optional<ConfiguredBus> configured_bus(const fs::path& root, const std::string& bus) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(root / "etc/cansync", none))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::optional<ConfiguredBus> of_that_name;
  for (const fs::path& path : files) {
    const config::Document document = config::read_document(path.string());
    const ConfiguredBus found{path.stem().string(), text_of(document, "interface")};
    const std::string name = text_of(document, "name");
    if ((name.empty() ? found.interface : name) == bus) return found;
    if (found.unit == bus && !document.nodes.empty()) of_that_name = found;
  }
  return of_that_name;
}

bool in_processor_list(const std::string& list, int cpu) noexcept {
  std::string_view rest = list;
  while (!rest.empty()) {
    const std::string_view part = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    int first = 0;
    const auto begin = std::from_chars(part.data(), part.data() + part.size(), first);
    if (begin.ec != std::errc{}) return false;
    int last = first;
    if (begin.ptr != part.data() + part.size()) {
      if (*begin.ptr != '-') return false;
      const auto end = std::from_chars(begin.ptr + 1, part.data() + part.size(), last);
      if (end.ec != std::errc{} || end.ptr != part.data() + part.size()) return false;
    }
    if (first <= cpu && cpu <= last) return true;
  }
  return false;
}

}  // namespace cansync::cli
