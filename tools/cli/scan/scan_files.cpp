#include "cli/scan/scan_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "cli/scan/network_files.h"

namespace cansync::cli {
namespace {

/// A drive without a profile whose parameters were read, beyond the status word alone.
bool needs_draft(const FoundSlave& slave) {
  return !slave.profile && slave.parameters.size() > 1;
}

void expect_writable(const ScannedLine& line) {
  if (!line.heard.bit_rate)
    throw std::runtime_error("--write: the bit rate is not known; --bit-rate gives it");
  const auto& heard = line.heard.census.slave;
  const bool any = std::any_of(heard.begin(), heard.end(), [](const auto& one) { return one.sends(); });
  if (line.slaves.empty() && !any)
    throw std::runtime_error("--write: no slave was found, so there is nothing to write");
  if (!line.new_name.empty() && !line.heard.pin)
    throw std::runtime_error(fmt::format(
        "--interface-name: the adapter of {} cannot be distinguished from others, by serial number, path or channel; "
        "allowed: an adapter that can",
        line.heard.interface));
}

}  // namespace

const std::string& interface_of(const ScannedLine& line) noexcept {
  return line.new_name.empty() ? line.heard.interface : line.new_name;
}

std::string scanned_profile_name(const FoundSlave& slave) {
  return fmt::format("scanned-{}", slave.number.value());
}

std::string scanned_profile(const FoundSlave& slave) {
  std::string out = fmt::format(
      "# A draft: the parameters that slave {0} gave a scan. Names, units, limits and meanings are in the drive's\n"
      "# manual; docs/profiles.md explains the keys. Everything is read-only here until you know what it is.\n\n"
      "[profile]\nname = \"{1}\"\ntext = \"Draft of slave {0}\"\n",
      slave.number.value(), scanned_profile_name(slave));
  for (const FoundParameter& parameter : slave.parameters) {
    const bool status = parameter.number == slave.status_parameter && slave.status_word;
    if (parameter.error != 0) {
      out += fmt::format("\n# number {}: there, but it gave no value (0x{:04X})\n", parameter.number,
                         parameter.error);
      continue;
    }
    out += fmt::format(
        "\n# read: {0} (0x{0:X})\n[[parameter]]\nnumber = {1}\nname = \"{2}\"\nformat = \"{3}\"\n"
        "access = \"read-only\"\n{4}",
        parameter.value, parameter.number,
        status ? "status-word" : fmt::format("parameter-{}", parameter.number),
        parameter.doubleword ? "doubleword" : "word",
        status ? "volatile = true\ntells = \"status-word\"\n" : "");
  }
  return out;
}

std::vector<LearnedFile> scan_files(const ScannedLine& line) {
  expect_writable(line);
  std::vector<LearnedFile> files;
  files.push_back({interface_of(line) + ".toml", scan_configuration(line)});
  for (const auto& [name, text] : line.profiles) {
    const bool used = std::any_of(
        line.slaves.begin(), line.slaves.end(),
        [&, &wanted = name](const auto& slave) { return slave.profile && slave.profile->name == wanted; });
    if (used) files.push_back({fmt::format("profiles/{}.toml", name), text});
  }
  for (const FoundSlave& slave : line.slaves)
    if (needs_draft(slave))
      files.push_back({fmt::format("profiles/{}.toml", scanned_profile_name(slave)), scanned_profile(slave)});
  if (line.heard.live)
    for (LearnedFile& file :
         network_files({interface_of(line), !line.new_name.empty(), line.heard.link, line.heard.pin},
                       *line.heard.bit_rate))
      files.push_back({"network/" + file.path, std::move(file.text)});
  return files;
}

}  // namespace cansync::cli
