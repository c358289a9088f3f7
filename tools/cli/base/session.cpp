#include "cli/base/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>

#include "dds/overview/every_bus.h"

namespace cansync::cli {
namespace {

constexpr double kDefaultSearch = 3.0;   // seconds
constexpr double kShortestSearch = 1.0;  // discovery itself takes some 100 ms
constexpr unsigned kHighestSlave = 31;

/// The only bus where no name was given. Throws as `Session::bus`.
std::string find_only_bus(const Globals& globals, std::chrono::milliseconds wait) {
  gateway::dds::ClientOptions options;
  options.domain = globals.domain;
  options.bus.clear();
  options.interface = globals.interface;
  options.security = globals.security;
  options.final_types = globals.final_types;
  options.wait = wait;
  options.stop = &interrupt_flag();
  try {
    return gateway::dds::only_bus(options);
  } catch (const gateway::dds::SeveralBuses& error) {
    throw UsageError(fmt::format("--bus: found none; {} (--bus NAME, or CANSYNC_BUS)", error.what()));
  } catch (const gateway::dds::NoDaemon& error) {
    if (interrupt_flag().load()) throw Interrupted();
    throw client::NoDaemon(error.what());
  } catch (const gateway::dds::SetupError& error) {
    throw client::SetupError(error.what());
  }
}

}  // namespace

Session::Session(const Globals& globals, Output& output, Connection& connection, Purpose purpose)
    : globals_(globals),
      output_(output),
      connection_(connection),
      purpose_(purpose),
      retry_(globals.retry,
             {Retry::Clock::now, [](Retry::Clock::time_point until) { return wait_until(until); },
              [&output](std::string_view text) { output.remark_now(text); }}) {}

void Session::expect_input(std::string_view path) const {
  if (path == "-" && globals_.input_is_taken)
    throw UsageError("FILE: found '-'; standard input holds the lines of the batch; allowed: a file");
  if (purpose_ == Purpose::check) throw ArgumentsAreRight();
}

const std::string& Session::bus(std::chrono::milliseconds wait) {
  if (!globals_.bus.empty()) return globals_.bus;
  if (purpose_ == Purpose::check) throw ArgumentsAreRight();
  if (connection_.bus.empty()) {
    connection_.bus = find_only_bus(globals_, wait);
    output_.remark(fmt::format("bus {}, the only one in DDS domain {} on interface {}", connection_.bus,
                               globals_.domain, globals_.interface));
  }
  globals_.bus = connection_.bus;
  return globals_.bus;
}

client::Options Session::options(std::chrono::milliseconds wait) const {
  client::Options options;
  options.domain = globals_.domain;
  options.bus = globals_.bus;
  options.interface = globals_.interface;
  options.client_name = "cansync";
  options.security = globals_.security;
  options.final_types = globals_.final_types;
  options.wait = wait;
  options.requests = !looks_;
  options.go_on = [] { return !interrupt_flag().load(); };
  return options;
}

client::Client& Session::client() {
  if (purpose_ == Purpose::check) throw ArgumentsAreRight();
  std::optional<client::Client>& client = connection_.client;
  // What a daemon that has gone told last would be taken for the present.
  if (client && fresh_ && !client->daemon_present()) client.reset();
  if (client && connection_.looks && !looks_) client.reset();
  fresh_ = false;
  while (!client) {
    try {
      static_cast<void>(bus());
      client = client::Client::connect(options(search_time()));
      connection_.looks = looks_;
    } catch (const client::OtherProtocol& error) {
      throw client::NoDaemon(other_protocol_text(globals_, error));
    } catch (const client::NoDaemon& error) {
      if (!try_again(error.what())) throw;
    }
    if (interrupt_flag().load()) throw Interrupted();
  }
  return *client;
}

bool Session::try_again(std::string_view reason) {
  const Retry::Verdict verdict =
      interrupt_flag().load() ? Retry::Verdict::interrupted : retry_.failed(reason);
  if (verdict == Retry::Verdict::interrupted) throw Interrupted();
  return verdict == Retry::Verdict::again;
}

client::Client* Session::look_for_daemon(std::chrono::milliseconds wait) {
  if (purpose_ == Purpose::check) throw ArgumentsAreRight();
  std::optional<client::Client>& client = connection_.client;
  if (client && (!client->daemon_present() || (connection_.looks && !looks_))) client.reset();
  fresh_ = false;
  try {
    if (!client) {
      static_cast<void>(bus(wait));
      client = client::Client::connect(options(wait));
      connection_.looks = looks_;
    }
  } catch (const client::SeveralDaemons&) {
    throw;
  } catch (const client::OtherProtocol& error) {
    throw client::NoDaemon(other_protocol_text(globals_, error));
  } catch (const client::NoDaemon&) {
    return nullptr;
  }
  return &*client;
}

bool Session::again(Effect effect, client::Reply& reply) {
  if (!worth_repeating(effect, reply)) return false;
  switch (retry_.failed(reply.reason.empty() ? client::name(reply.code) : std::string_view(reply.reason))) {
    case Retry::Verdict::again:
      return true;
    case Retry::Verdict::over:
      return false;
    case Retry::Verdict::interrupted:
      reply.code = client::ReplyCode::cancelled;
      reply.cause = client::RefusalCause::none;
      reply.reason = "cancelled while it was tried again, after: " + reply.reason;
      return false;
  }
  return false;
}

std::chrono::milliseconds Session::search_time() const noexcept {
  const double seconds = std::max(globals_.timeout.value_or(kDefaultSearch), kShortestSearch);
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000.0));
}

std::uint32_t Session::monitoring_ms() const noexcept {
  // 0 would ask for the daemon's default.
  return globals_.timeout ? std::max(1u, static_cast<std::uint32_t>(*globals_.timeout * 1000.0)) : 0u;
}

unsigned Session::slave(std::string_view text) {
  if (looks_like_number(text)) return static_cast<unsigned>(parse_integer(text, "SLAVE", 0, kHighestSlave));
  hold_names();
  const client::SlaveLookup found = client().find_slave(text);
  if (!found.slave) throw UsageError(fmt::format("SLAVE: {}", found.problem));
  return *found.slave;
}

ExitCode Session::finish(const client::Reply& reply, JsonObject object, std::string_view where,
                         std::string_view done) {
  if (json()) {
    add_end(object, reply);
    output_.object(object);
  }
  if (!reply.ok()) {
    const std::string_view reason =
        reply.reason.empty() ? client::name(reply.code) : std::string_view(reply.reason);
    output_.remark(fmt::format("{}: {}", where, reason));
  } else if (!json() && !done.empty()) {
    output_.remark(done);
  }
  return exit_code(reply.code);
}

std::string other_protocol_text(const Globals& globals, const client::OtherProtocol& error) {
  return fmt::format("bus {} is served as {}; `{}` needs {}", error.bus, error.served_as, globals.verb,
                     error.needs);
}

void add_end(JsonObject& object, const client::Reply& reply) {
  object.add("result", client::name(reply.code)).add("reason", reply.reason);
  if (reply.code == client::ReplyCode::refused) {
    object.add("cause", client::name(reply.cause));
  } else {
    object.add_null("cause");
  }
}

RawForm raw_form(const cansync_ValueName& name) noexcept {
  // A daemon older than these members says 0 and false.
  if (name.width == 0) return {};
  return {name.width == 16 ? Width::word : Width::doubleword, name.is_signed};
}

bool same_values(const client::SlaveStatus& one, const client::SlaveStatus& other) {
  const auto same = [](const cansync_ValueName& a, const cansync_ValueName& b) {
    return client::text(a.name) == client::text(b.name) &&
           client::text(a.unit_symbol) == client::text(b.unit_symbol) && a.factor == b.factor &&
           a.offset == b.offset && a.width == b.width && a.is_signed == b.is_signed;
  };
  return client::text(one.name) == client::text(other.name) &&
         std::equal(std::begin(one.actual_mapping), std::end(one.actual_mapping), other.actual_mapping) &&
         std::equal(std::begin(one.actual_value), std::end(one.actual_value), other.actual_value, same);
}

ValueLookup value_lookup(const cansync_ValueName (&names)[8]) {
  std::array<std::string, 8> copy;
  for (std::size_t i = 0; i < copy.size(); ++i) copy[i] = names[i].name;
  return [copy](std::string_view name) -> std::optional<unsigned> {
    const auto found = std::find(copy.begin(), copy.end(), name);
    if (name.empty() || found == copy.end()) return std::nullopt;
    return static_cast<unsigned>(found - copy.begin());
  };
}

client::MappingBytes mapping_bytes(const std::uint8_t (&bytes)[8]) noexcept {
  client::MappingBytes out{};
  std::copy(std::begin(bytes), std::end(bytes), out.begin());
  return out;
}

std::uint8_t mapped_values(const std::uint8_t (&bytes)[8]) noexcept {
  unsigned mask = 0;
  for (const std::uint8_t byte : bytes)
    if ((byte & 1u) != 0) mask |= 1u << ((byte >> 2) & 0x1Fu);
  return static_cast<std::uint8_t>(mask);
}

std::string cursor_text(std::int32_t code) {
  if (code == client::kAutomatic) return "automatic";
  if (code == client::kNobody) return "nobody";
  return fmt::format("slave {}", code);
}

std::string date_text() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const std::string text = time_text(std::chrono::nanoseconds(now).count(), true);
  return text.substr(0, text.find('.'));
}

std::string time_text(std::int64_t nanoseconds, bool date) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const auto seconds = static_cast<std::time_t>(nanoseconds / kSecond);
  // Of a recording thousands of frames have the same second, whose text takes the longest.
  static thread_local std::optional<std::time_t> known;
  static thread_local std::array<char, 32> text{};
  if (known != seconds) {
    known.reset();
    std::tm parts{};
    if (localtime_r(&seconds, &parts) == nullptr) return "?";
    if (std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &parts) == 0) return "?";
    known = seconds;
  }
  const std::string_view whole(text.data());
  const std::int64_t millis = nanoseconds % kSecond / 1'000'000;
  std::string out(date ? whole : whole.substr(whole.find(' ') + 1));
  out += '.';
  for (const std::int64_t place : {100, 10, 1}) out += static_cast<char>('0' + millis / place % 10);
  return out;
}

}  // namespace cansync::cli
