#pragma once

#include <string>

namespace cansyncd {

/// docs/configuration.md, generated from the option table.
std::string options_markdown();

/// config/cansync.toml: a file with every option at its default, each explained in a comment. It is a valid
/// configuration of a simulated line with one drive.
std::string default_config();

}  // namespace cansyncd
