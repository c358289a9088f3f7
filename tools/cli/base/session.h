#pragma once

#include <cansync/client.h>
#include <cansync/topics.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/exit_codes.h"
#include "cli/base/held_names.h"
#include "cli/base/output.h"
#include "cli/base/retry.h"
#include "cli/text/values.h"

/// What every verb works with. Main thread only.
namespace cansync::cli {

/// Options of every verb.
struct Globals {
  std::uint32_t domain = 0;       ///< DDS domain, 0..230
  std::string bus;                ///< DDS partition; empty: the only bus of the domain
  std::string interface = "lo";   ///< network interface
  std::optional<double> timeout;  ///< seconds; see docs/command-line.md
  double retry = 0.0;             ///< seconds for which what did nothing is tried again; 0: not at all
  bool json = false;
  ColourUse colours = ColourUse::automatic;
  bool wide = false;            ///< lines and tables as wide as they are, also on a terminal
  bool input_is_taken = false;  ///< standard input is read already
  std::string profiles;         ///< folder of drive profiles, before the standard ones; empty: none
  std::string security;         ///< DDS Security: folder of the identity; empty: without
  bool final_types = false;     ///< the daemon's dds.types is "final"
  std::string verb;             ///< its words, such as "can dump"
};

/// Ctrl-C came before anything was sent.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("cancelled; nothing was sent") {}
};

/// Every argument that can be looked at without a daemon is right; thrown only while a session checks.
struct ArgumentsAreRight {};

/// The connection of one or more sessions, made when it is first needed.
struct Connection {
  std::optional<client::Client> client;
  bool looks = false;  ///< it can ask for nothing
  std::string bus;     ///< the only one of the domain, for which no name was given; empty: not looked for yet
};

/// What a session does with a verb.
enum class Purpose : std::uint8_t {
  run,
  check,  ///< only the arguments are looked at: asking for the daemon throws ArgumentsAreRight
};

/// One run of a verb: the connection, what was given for every verb, and the output.
class Session {
 public:
  /// `connection` outlives the session; sessions one after the other share it.
  Session(const Globals& globals, Output& output, Connection& connection, Purpose purpose = Purpose::run);

  Output& output() noexcept { return output_; }
  bool json() const noexcept { return globals_.json; }
  const Globals& globals() const noexcept { return globals_; }
  Connection& connection() noexcept { return connection_; }
  /// The bus of `--bus`; without, the only one of the domain, which is looked for and said once. Throws client::NoDaemon,
  /// client::SetupError, UsageError when there are several, Interrupted, ArgumentsAreRight.
  const std::string& bus() { return bus(search_time()); }
  const std::string& profiles() const noexcept { return globals_.profiles; }

  /// The verb asks for nothing: a connection that is made from now on needs no more than to look, and finds
  /// daemons of every protocol. Before `client`.
  void look_only() noexcept { looks_ = true; }

  /// Connects when it is called first, or when the daemon of an earlier session has gone; tries again as long
  /// as
  /// `--retry` says. Throws client::NoDaemon, client::SetupError, Interrupted, ArgumentsAreRight.
  client::Client& client();

  /// The daemon, looked for anew at most `wait` long when it is not connected; nullptr: none is there. Throws
  /// client::SetupError, client::SeveralDaemons, ArgumentsAreRight.
  client::Client* look_for_daemon(std::chrono::milliseconds wait);

  /// Call before a file is read: `path` must not be standard input ("-") when that holds the lines of a
  /// batch. Throws UsageError, ArgumentsAreRight.
  void expect_input(std::string_view path) const;

  /// How long to look for the daemon, and to wait for what it tells of its slaves.
  std::chrono::milliseconds search_time() const noexcept;

  /// Monitoring time of a job in ms; 0 = the daemon's default.
  std::uint32_t monitoring_ms() const noexcept;

  /// The slave with this number or name; a number is not looked up. Throws UsageError.
  unsigned slave(std::string_view text);

  /// The slaves of a list (slave_list.h), by rising number. One plain number is not looked up; all others
  /// must be configured. Throws UsageError.
  std::vector<unsigned> slaves(std::string_view list);
  /// Mask of a list; none has to be configured. Throws UsageError.
  std::uint32_t slave_mask(std::string_view list);
  /// Configured name of a slave, empty when it has none.
  std::string slave_name(unsigned slave);
  /// The status of every configured slave, by rising number. Throws std::runtime_error when the daemon has not told all of
  /// them within the time of a search, and as `client`.
  std::vector<client::SlaveStatus> every_slave();

  // --- What a verb was told by name is looked up once, and a reload of the daemon may give the name to another drive
  // before the request goes out.

  /// Something is looked up by name: from now on `ask`, `settle` and `for_each` send nothing when names mean something
  /// else. `slave`, `slaves` and the like do it for the names of slaves. Throws as `every_slave`.
  void hold_names();
  /// What held names mean else by now, in words; empty: nothing, or the daemon is away or has not told all of them.
  std::string names_changed();
  /// For a verb that goes on for long: calls `look_up` when held names mean something else, and says so unless `quiet`.
  /// False: not now, since they are just being changed and `look_up` found none; then try again soon. Throws what
  /// `look_up` throws when that lasts.
  bool follow_names(const std::function<void()>& look_up, bool quiet = false);
  /// The file that a slave's part of a verb reads or writes: `pattern` with {slave} and {name} filled in.
  /// Throws UsageError when there are several slaves and it has neither.
  std::vector<std::string> files(std::string_view pattern, const std::vector<unsigned>& slaves);

  /// How lines and remarks of several slaves are written.
  enum class Lines : std::uint8_t {
    each,              ///< at once, one for each slave
    grouped,           ///< when all slaves are done, one for those that have the same
    failures_grouped,  ///< at once; those of slaves that fail as `grouped`
  };
  /// Does `one` for each slave by rising number, also when one fails; data of several begin with the slave.
  /// Ends early only at Ctrl-C. The code of the first that failed.
  ExitCode for_each(const std::vector<unsigned>& slaves,
                    const std::function<ExitCode(std::size_t index)>& one, Lines lines = Lines::each);
  /// Are there several slaves in the running `for_each`?
  bool several() const noexcept { return several_; }

  /// Mask of these slaves, each a list; of every configured one when `texts` is empty. Throws UsageError
  /// for one that is not configured.
  std::uint32_t configured_slaves(const std::vector<std::string>& texts);

  /// No daemon was there: true after a pause when `--retry` allows another look. Throws Interrupted.
  bool try_again(std::string_view reason);

  /// Waits for a request's reply; Ctrl-C cancels it on the bus.
  template <class R>
  R wait(const client::Job<R>& job, const client::OnProgress& on_progress = {}) const;

  /// Sends a request and waits for its reply; as long as `--retry` allows it again and again, when that
  /// changes nothing twice (worth_repeating). `submit` gives a job each time.
  template <class Submit>
  auto ask(Effect effect, const Submit& submit, const client::OnProgress& on_progress = {}) {
    expect_names();
    return settle(wait(submit(), on_progress), effect, submit, on_progress);
  }
  /// The same when the first reply is there already.
  template <class R, class Submit>
  R settle(R reply, Effect effect, const Submit& submit, const client::OnProgress& on_progress = {}) {
    while (again(effect, reply)) {
      expect_names();
      reply = wait(submit(), on_progress);
    }
    return reply;
  }

  /// Ends a request: `object` gets how it ended (`add_end`) and is written with --json; without, `done` is
  /// written as a remark unless it is empty. What went wrong is written as a remark that begins with `where`.
  ExitCode finish(const client::Reply& reply, JsonObject object, std::string_view where,
                  std::string_view done = {});

 private:
  /// The same, looked for at most `wait` long.
  const std::string& bus(std::chrono::milliseconds wait);
  /// Where the daemon is looked for.
  client::Options options(std::chrono::milliseconds wait) const;
  /// True when the request is to be sent again; a reply at Ctrl-C becomes `cancelled`.
  bool again(Effect effect, client::Reply& reply);
  /// Throws UsageError unless all of them are configured.
  void expect_configured(std::uint32_t slaves);
  /// As HeldNames::change_to; nothing: the daemon is away, or has not told all slaves within `time`.
  std::optional<std::string> change_of_names(std::chrono::milliseconds time);
  /// Throws Ended when held names mean something else.
  void expect_names();

  Globals globals_;
  Output& output_;
  Connection& connection_;
  Purpose purpose_;
  Retry retry_;
  bool looks_ = false;
  bool fresh_ = true;  ///< the connection was not looked at by this session yet
  bool several_ = false;
  std::optional<HeldNames> held_;
  /// Names are being changed since then.
  std::optional<std::chrono::steady_clock::time_point> unsettled_since_;
};

/// "bus mill is served as layer2; `read` needs cansync-master".
std::string other_protocol_text(const Globals& globals, const client::OtherProtocol& error);

/// How a request ended: `result`, `reason`, and `cause`, null unless it was refused.
void add_end(JsonObject& object, const client::Reply& reply);

/// How the number of a value stands in its raw value, by what the daemon says of it.
RawForm raw_form(const cansync_ValueName& name) noexcept;

/// Has the slave the same name in both, and its actual values the same mapping, names, units and scaling?
bool same_values(const client::SlaveStatus& one, const client::SlaveStatus& other);

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

#include "cli/base/interrupt.h"

template <class R>
R cansync::cli::Session::wait(const client::Job<R>& job, const client::OnProgress& on_progress) const {
  return job.wait(interrupt_flag(), on_progress);
}
