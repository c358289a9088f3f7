#pragma once

#include <span>
#include <string>
#include <vector>

#include "can/adapter/adapters.h"
#include "daemon/segment/protocol.h"

/// Configuration files whatever their protocol, and what is printed of all options. Main thread.
namespace cansyncd {

using Protocols = std::span<const ProtocolInfo* const>;

/// Reads and checks `source` as the protocol does that its option `bus.protocol` names; without it, as the
/// first of `protocols`. `overrides` are "KEY=VALUE" and win over the file. A name that no protocol has is
/// the only problem then. Never throws for a wrong file.
LoadedConfig load_configuration(const config::Source& source, std::span<const std::string> overrides,
                                Protocols protocols);

/// What keeps files from being served by one process: two buses of one name in a DDS domain, on one
/// interface, or with one file to write. Each problem names both files.
std::vector<config::Problem> check_together(std::span<const LoadedConfig> files);

/// Pins of adapters (bus.adapter) that allow more than one of `there`, so that these could be exchanged
/// unseen: where each is given, and the interfaces.
std::vector<config::Problem> check_adapters(std::span<const LoadedConfig> files,
                                            const std::vector<can::InterfaceAdapter>& there);

/// The default configuration of the protocol that `overrides` name, else of the first. Throws
/// std::runtime_error, which says what is allowed, for a name that none has.
std::string print_default_config(std::span<const std::string> overrides, Protocols protocols);

/// docs/configuration.md: what each protocol says of its options.
std::string print_options_markdown(Protocols protocols);

/// The options' part of cansync.toml(5) in mdoc, likewise.
std::string print_options_man(Protocols protocols);

}  // namespace cansyncd
