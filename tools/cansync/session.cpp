#include "cansync/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>

namespace cansync::cli {
namespace {

constexpr double kDefaultSearch = 3.0;   // seconds
constexpr double kShortestSearch = 1.0;  // discovery itself takes some 100 ms
constexpr unsigned kHighestSlave = 31;

}  // namespace

client::Client& Session::client() {
  if (!client_) {
    client::Options options;
    options.domain = globals_.domain;
    options.bus = globals_.bus;
    options.interface = globals_.interface;
    options.client_name = "cansync";
    options.security = globals_.security;
    options.wait = search_time();
    client_ = client::Client::connect(options);
    if (interrupt_flag().load()) throw Interrupted();
  }
  return *client_;
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
  static_cast<void>(client().slaves(search_time()));  // the names come with the status of the slaves
  const client::SlaveLookup found = client().find_slave(text);
  if (!found.slave) throw UsageError(fmt::format("SLAVE: {}", found.problem));
  return *found.slave;
}

std::uint32_t Session::configured_slaves(const std::vector<std::string>& texts) {
  std::uint32_t wanted = 0;
  for (const std::string& text : texts) wanted |= 1u << slave(text);
  const std::uint32_t configured = client().master_status().slaves_configured;
  if (texts.empty()) return configured;
  if ((wanted & ~configured) == 0) return wanted;
  throw UsageError(fmt::format("SLAVE: {} not configured; configured are {}",
                               format_slave_set(wanted & ~configured), format_slave_set(configured)));
}

ExitCode Session::finish(const client::Reply& reply, JsonObject object, std::string_view where,
                         std::string_view done) {
  if (json()) {
    object.add("result", client::name(reply.code)).add("reason", reply.reason);
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
  std::tm parts{};
  if (localtime_r(&seconds, &parts) == nullptr) return "?";
  std::array<char, 32> text{};
  if (std::strftime(text.data(), text.size(), date ? "%Y-%m-%d %H:%M:%S" : "%H:%M:%S", &parts) == 0)
    return "?";
  return fmt::format("{}.{:03d}", text.data(), nanoseconds % kSecond / 1'000'000);
}

}  // namespace cansync::cli
