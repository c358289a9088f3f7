#pragma once

#include <string>

namespace cansyncd {

/// docs/configuration.md, generated from the option table.
std::string options_markdown();

/// The options' part of cansync.toml(5) in mdoc: docs/man/cansync.toml.5.d/50-options.mdoc.
std::string options_man();

/// config/cansync.toml: a file with every option at its default, each explained in a comment. It is a valid
/// configuration of a simulated line with one drive.
std::string default_config();

}  // namespace cansyncd
