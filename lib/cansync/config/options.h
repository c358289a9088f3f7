#pragma once

#include <string_view>

#include "cansync/config/draft.h"
#include "config/print.h"
#include "config/rows.h"

namespace cansyncd {

/// The protocol's name, as `bus.protocol` has it.
inline constexpr std::string_view kMasterProtocol = "cansync-master";

/// Every option of a configuration file: the daemon's and CANsync's. Main thread.
const config::Rows<Draft>& option_rows();

/// Their table, for readers and documents.
const config::Table& options();

/// What its documents begin with.
extern const config::DocumentHeads master_document_heads;

}  // namespace cansyncd
