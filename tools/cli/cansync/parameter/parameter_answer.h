#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/base/session.h"
#include "cli/cansync/parameter/parameter_request.h"

/// What a slave answers to a request for a parameter, as text and as an object.
namespace cansync::cli {

/// How a reading stands among others.
struct Shown {
  std::string before;                ///< what its line begins with
  std::optional<std::int64_t> time;  ///< CLOCK_REALTIME in ns, for its object; nothing: it has none
};

/// Shows what came; what the verb ends with.
ExitCode finish_parameter(Session& session, const KnownRequest& request, const client::ParameterReply& reply,
                          const Shown& shown = {});

}  // namespace cansync::cli
