#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cli/base/restarts.h"
#include "cli/base/verbs.h"
#include "cli/connect/bus_connection.h"

/// What the verbs of a bus with another protocol than the master's do alike.
namespace cansync::cli {

/// The verb, when it is named, calls `run` with what was typed for it.
template <class Texts>
void run_when_named(CLI::App& verb, Verb& chosen, std::shared_ptr<Texts> texts,
                    ExitCode (*run)(Session&, const Texts&)) {
  verb.callback(
      [texts, run, &chosen] { chosen = [texts, run](Session& session) { return run(session, *texts); }; });
}

/// Of `--count`; 0: it was not given. Throws UsageError.
std::uint64_t parse_end_count(const std::string& text);

/// What the daemon tells of itself by a topic. Throws client::NoDaemon when it has told nothing; `place`:
/// where it was looked for.
template <class Told>
Told expect_told(std::optional<Told> told, std::string_view topic, const std::string& place) {
  if (told) return *std::move(told);
  throw client::NoDaemon("the daemon has told no " + std::string(topic) + " (" + place + ")");
}

/// Says so; what the verb ends with.
ExitCode end_without_daemon(Session& session, const std::string& place);

/// Calls `receive`, which says whether the daemon is there, until `enough` or Ctrl-C.
template <class Client, class Receive, class Enough>
ExitCode receive_until(Session& session, const Client& client, Receive&& receive, Enough&& enough) {
  while (!interrupt_flag().load() && !enough()) {
    if (!receive() && stays_gone(client)) return end_without_daemon(session, client.place());
  }
  return ExitCode::done;
}

}  // namespace cansync::cli
