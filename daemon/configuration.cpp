#include "daemon/configuration.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "config/document.h"
#include "config/settings.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

constexpr auto kBus = std::to_array<config::Section>({{"bus", "", ""}});

/// Where `adapter` of a file is given as option bus.adapter, for itself or in a level; of the whole file when
/// it is not.
config::Position place_of_pin(const std::string& path, const std::string& adapter) {
  for (const config::Node& node : config::read_document(path).nodes) {
    if (node.kind != config::Node::Kind::value || node.path.size() < 2 || node.name() != "adapter") continue;
    const auto* text = config::scalar<std::string>(node.value);
    if (text != nullptr && *text == adapter) return node.where;
  }
  return {path, 0, 0};
}

/// The protocol that is chosen; null with what is wrong with the choice.
struct Choice {
  const ProtocolInfo* protocol = nullptr;
  std::vector<config::Problem> problems;
};

std::string names_of(Protocols protocols) {
  std::string names;
  for (const ProtocolInfo* protocol : protocols)
    names += (names.empty() ? "" : "|") + std::string(protocol->name);
  return names;
}

/// Where a document says which protocol it is for; everything else is that protocol's own.
config::Document protocol_alone(config::Document document) {
  std::erase_if(document.nodes, [](const config::Node& node) {
    return node.kind != config::Node::Kind::value || node.path.size() != 2 ||
           node.path.front().name != "bus" || node.name() != "protocol";
  });
  document.problems.clear();
  return document;
}

Choice choose(const config::Document& document, std::span<const std::string> overrides, Protocols protocols) {
  const std::string names = names_of(protocols);
  const config::Table table(kBus, {rows::protocol_option(names, "")});
  config::Settings settings = config::resolve(document, table);
  for (const std::string& assignment : overrides) {
    if (assignment.starts_with("bus.protocol=")) config::override_setting(settings, assignment, table);
  }
  if (settings.items.empty()) return {protocols.front(), {}};
  const config::Setting& given = settings.items.back();
  if (!config::takes(*given.option, given.value))
    return {nullptr, {{given.where, given.key, config::mismatch_text(*given.option, given.value)}}};
  const auto& name = *config::scalar<std::string>(given.value);
  return {*std::find_if(protocols.begin(), protocols.end(),
                        [&](const ProtocolInfo* protocol) { return protocol->name == name; }),
          {}};
}

}  // namespace

LoadedConfig load_configuration(const config::Source& source, std::span<const std::string> overrides,
                                Protocols protocols) {
  // A file that cannot be read, or is not TOML, is told by the protocol's own reader.
  // Read once: what is checked is what runs, and what is kept of it.
  const config::Source whole = source.text ? source : config::read_source(source.path);
  Choice choice = choose(protocol_alone(config::read_document(whole)), overrides, protocols);
  LoadedConfig loaded;
  if (choice.protocol != nullptr) {
    loaded = choice.protocol->load(whole, overrides);
  } else {
    loaded.problems = std::move(choice.problems);
  }
  loaded.path = whole.path;
  loaded.text = whole.text;
  return loaded;
}

std::vector<config::Problem> check_together(std::span<const LoadedConfig> files) {
  std::vector<config::Problem> problems;
  struct Served {
    const std::string& path;
    const DaemonConfig& config;
  };
  std::vector<Served> buses;
  for (const LoadedConfig& file : files) {
    for (const DaemonConfig& config : file.served()) buses.push_back({file.path, config});
  }
  // What two buses cannot have both; nothing: this bus does not have it.
  const auto apart = [&](std::string_view key, const auto& of, std::string_view remedy) {
    for (std::size_t i = 1; i < buses.size(); ++i) {
      const std::optional<std::string> mine = of(buses[i].config);
      for (std::size_t j = 0; j < i && mine; ++j) {
        if (of(buses[j].config) != mine) continue;
        const std::string other = buses[j].path == buses[i].path ? "another bus of this file" : buses[j].path;
        problems.push_back({{buses[i].path, 0, 0},
                            std::string(key),
                            fmt::format("{} is that of {}, too; {}", *mine, other, remedy)});
        break;
      }
    }
  };
  apart(
      "bus.name",
      [](const DaemonConfig& config) -> std::optional<std::string> {
        return fmt::format("{} in DDS domain {}", config.dds.partition, config.dds.domain);
      },
      "clients could not tell the two apart: each bus needs a name of its own");
  apart(
      "bus.interface",
      [](const DaemonConfig& config) {
        return config.bus.kind == BusKind::simulated ? std::nullopt : std::optional(config.bus.interface);
      },
      "one interface is one bus, with one file");
  apart(
      "metrics.file",
      [](const DaemonConfig& config) {
        return config.metrics.file.empty() ? std::nullopt : std::optional(config.metrics.file);
      },
      "each bus writes a file of its own");
  apart(
      "sim.trace",
      [](const DaemonConfig& config) {
        return config.sim.trace.empty() ? std::nullopt : std::optional(config.sim.trace);
      },
      "each bus writes a file of its own");
  return problems;
}

std::vector<config::Problem> check_adapters(std::span<const LoadedConfig> files,
                                            const std::vector<can::InterfaceAdapter>& there) {
  std::vector<config::Problem> problems;
  for (const LoadedConfig& file : files) {
    for (const DaemonConfig& config : file.served()) {
      const std::string& adapter = config.bus.adapter;
      if (adapter.empty()) continue;
      const auto found = can::interfaces_of(can::read_pin(adapter).pin, there);
      if (found.size() < 2) continue;
      problems.push_back({place_of_pin(file.path, adapter), "bus.adapter",
                          fmt::format("found \"{}\", which the adapters of {} have; allowed: what only one "
                                      "has, such as a channel or the path of its port, too",
                                      adapter, fmt::join(found, " and "))});
    }
  }
  return problems;
}

std::string print_default_config(std::span<const std::string> overrides, Protocols protocols) {
  const Choice choice = choose({}, overrides, protocols);
  if (choice.protocol == nullptr) throw std::runtime_error(config::to_string(choice.problems.front()));
  return config::default_file(choice.protocol->options(), choice.protocol->heads->file);
}

std::string print_options_markdown(Protocols protocols) {
  std::string out;
  for (const ProtocolInfo* protocol : protocols)
    out += config::options_markdown(protocol->options(), protocol->heads->markdown);
  return out;
}

std::string print_options_man(Protocols protocols) {
  std::string out;
  for (const ProtocolInfo* protocol : protocols)
    out += config::options_man(protocol->options(), protocol->heads->man);
  return out;
}

}  // namespace cansyncd
