#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `can image`, which shows, watches and writes the process image, added to `can`.
void add_image_verb(CLI::App& can, Verb& chosen);
/// `can lead`, which lets the module run as long as it runs, added to `can`.
void add_lead_verb(CLI::App& can, Verb& chosen);

}  // namespace cansync::cli
