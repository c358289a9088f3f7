#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/base/session.h"
#include "cli/cansync/parameter/parameter_request.h"
#include "cli/text/table.h"

/// What a slave answers to a request for a parameter, as text and as an object.
namespace cansync::cli {

/// Where a reading is shown.
struct Shown {
  Table* table = nullptr;            ///< gets its row (reading_columns); null: it is a line of its own
  std::optional<std::int64_t> time;  ///< CLOCK_REALTIME in ns; nothing: it has none
};

/// The columns of readings; `timed`: with the time of each.
std::vector<Table::Column> reading_columns(bool timed);

/// Shows what came; what the verb ends with.
ExitCode finish_parameter(Session& session, const KnownRequest& request, const client::ParameterReply& reply,
                          const Shown& shown = {});

}  // namespace cansync::cli
