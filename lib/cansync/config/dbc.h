#pragma once

#include <string>

#include "cansync/config/config.h"

namespace cansyncd {

/// The bus of a configuration as a DBC file, so that other CAN tools show names, units and scaled values:
/// action command, WRC1 and WRC2 for each slave that may be asked, and RDC1, RDC2, CC and RC of each
/// configured slave. Text in ISO-8859-1, lines end with a line feed. Names are made fit for the format
/// (letters, digits, '_', at most 32 characters, unique); the configured name of a slave or value then stands
/// in a comment. What the format cannot express is told in comments: see docs/wireshark.md. Main thread
/// (allocates).
std::string dbc_text(const Config& config);

}  // namespace cansyncd
