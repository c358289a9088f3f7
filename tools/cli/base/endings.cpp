#include "cli/base/endings.h"

#include "cli/base/session.h"

namespace cansync::cli {

ExitCode code_of(const std::exception& error) noexcept {
  if (const auto* ended = dynamic_cast<const Ended*>(&error)) return ended->code();
  if (dynamic_cast<const UsageError*>(&error) != nullptr) return ExitCode::usage;
  if (dynamic_cast<const Interrupted*>(&error) != nullptr) return ExitCode::cancelled;
  if (dynamic_cast<const client::NoDaemon*>(&error) != nullptr) return ExitCode::not_reachable;
  if (dynamic_cast<const client::SetupError*>(&error) != nullptr) return ExitCode::not_reachable;
  return ExitCode::failed;
}

}  // namespace cansync::cli
