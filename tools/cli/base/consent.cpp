#include "cli/base/consent.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <bit>

#include "cli/base/endings.h"
#include "cli/base/interrupt.h"
#include "text/counts.h"
#include "text/visible.h"

namespace cansync::cli {
namespace {

/// The first character of a line from the terminal; 0: an empty one, or its end. Throws Interrupted.
char typed_answer() {
  constexpr int kLook = 20;  // ms, for Ctrl-C
  pollfd input{STDIN_FILENO, POLLIN, 0};
  while (!interrupt_flag().load()) {
    if (::poll(&input, 1, kLook) <= 0) continue;
    std::array<char, 256> line{};
    const ssize_t length = ::read(STDIN_FILENO, line.data(), line.size());
    return length > 0 && line.front() != '\n' ? line.front() : '\0';
  }
  throw Interrupted();
}

}  // namespace

void add_yes_option(CLI::App& verb, bool& yes) {
  verb.add_flag("--yes", yes, "do not ask; needed where there is no terminal to ask on");
}

void add_consent_options(CLI::App& verb, Consent& consent) {
  add_yes_option(verb, consent.yes);
  verb.add_flag("--dry-run", consent.dry_run, "say what would be done, and do nothing");
}

void ask_consent(Session& session, const Consent& consent, std::string_view effect, Unasked unasked) {
  if (consent.yes) return;
  const bool terminal =
      ::isatty(STDIN_FILENO) == 1 && ::isatty(STDERR_FILENO) == 1 && !session.globals().input_is_taken;
  if (!terminal) {
    if (unasked == Unasked::done) return;
    throw UsageError(fmt::format("{}: there is no terminal to ask on; nothing was sent; add --yes", effect));
  }
  session.expect_input("");
  static_cast<void>(
      std::fputs(fmt::format("cansync: {}. Go on? [y/N] ", text::visible(effect)).c_str(), stderr));
  static_cast<void>(std::fflush(stderr));
  const char answer = typed_answer();
  if (answer == 'y' || answer == 'Y') return;
  throw Ended(ExitCode::cancelled, "not done; nothing was sent");
}

std::string reached_line(Session& session) {
  const client::GatewayStatus gateway = session.client().gateway_status();
  const client::MasterStatus master = session.client().master_status();
  return fmt::format("bus {} (process {} on host {}) is in {} with {}", session.bus(), gateway.process,
                     client::text(gateway.host), client::text(master.state),
                     text::counted_of(std::popcount(master.slaves_responding),
                                      std::popcount(master.slaves_configured), "slave"));
}

}  // namespace cansync::cli
