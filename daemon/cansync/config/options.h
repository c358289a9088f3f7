#pragma once

#include "config/rows.h"
#include "daemon/config/draft.h"

namespace cansyncd {

/// Every option of a configuration file: the daemon's and CANsync's. Main thread.
const config::Rows<Draft>& option_rows();

/// Their table, for readers and documents.
const config::Table& options();

}  // namespace cansyncd
