#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "cansync/exit_codes.h"
#include "cansync/output.h"
#include "cansync/values.h"
#include "client/client.h"

/// What every verb works with. Main thread only.
namespace cansync::cli {

/// Options of every verb.
struct Globals {
  std::uint32_t domain = 0;       ///< DDS domain, 0..230
  std::string bus = "sim";        ///< DDS partition
  std::string interface = "lo";   ///< network interface
  std::optional<double> timeout;  ///< seconds; see docs/command-line.md
  bool json = false;
  std::string profiles;  ///< folder of drive profiles, before the standard ones; empty: none
  std::string security;  ///< DDS Security: folder of the identity; empty: without
};

/// Ctrl-C came before anything was sent.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("cancelled; nothing was sent") {}
};

/// One run of the program: the connection, made when it is first needed, and the output.
class Session {
 public:
  Session(const Globals& globals, Output& output) : globals_(globals), output_(output) {}

  Output& output() noexcept { return output_; }
  bool json() const noexcept { return globals_.json; }
  const std::string& bus() const noexcept { return globals_.bus; }
  const std::string& profiles() const noexcept { return globals_.profiles; }

  /// Connects when it is called first. Throws client::NoDaemon, client::SetupError, Interrupted.
  client::Client& client();

  /// Monitoring time of a job in ms; 0 = the daemon's default.
  std::uint32_t monitoring_ms() const noexcept;

  /// The slave with this number or name; a number is not looked up. Throws UsageError.
  unsigned slave(std::string_view text);

  /// Mask of these slaves, numbers or names; of every configured one when `texts` is empty. Throws UsageError
  /// for one that is not configured.
  std::uint32_t configured_slaves(const std::vector<std::string>& texts);

  /// Waits for a request's reply; Ctrl-C cancels it on the bus.
  template <class R>
  R wait(const client::Job<R>& job, const client::OnProgress& on_progress = {}) const;

  /// Ends a request: `object` gets `result` and `reason` and is written with --json; without, `done` is
  /// written as a remark unless it is empty. What went wrong is written as a remark that begins with `where`.
  ExitCode finish(const client::Reply& reply, JsonObject object, std::string_view where,
                  std::string_view done = {});

 private:
  /// How long to look for the daemon, and to wait for what it tells of its slaves.
  std::chrono::milliseconds search_time() const noexcept;

  Globals globals_;
  Output& output_;
  std::optional<client::Client> client_;
};

/// Which of the eight values has this name.
ValueLookup value_lookup(const cansync_ValueName (&names)[8]);

/// Register bytes as the client takes them.
client::MappingBytes mapping_bytes(const std::uint8_t (&bytes)[8]) noexcept;

/// Bit n: value n has at least one word in these register bytes.
std::uint8_t mapped_values(const std::uint8_t (&bytes)[8]) noexcept;

/// "automatic", "nobody", or "slave 3" for a polling or cursor code.
std::string cursor_text(std::int32_t code);

/// Local date and time of now, to the second.
std::string date_text();

/// Local date and time with milliseconds of a CLOCK_REALTIME instant in ns; `date` false: the time alone.
std::string time_text(std::int64_t nanoseconds, bool date);

}  // namespace cansync::cli

#include "cansync/interrupt.h"

template <class R>
R cansync::cli::Session::wait(const client::Job<R>& job, const client::OnProgress& on_progress) const {
  return job.wait(interrupt_flag(), on_progress);
}
