#include <cansync/client.h>
#include <cansync/topics.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <deque>
#include <memory>
#include <thread>
#include <tuple>
#include <utility>

#include "client/src/connect_options.h"
#include "client/src/link.h"
#include "client/src/set_up.h"

namespace cansync::client {
namespace {

/// A slave number in decimal or 0x hexadecimal; nothing when `text` is none at all.
std::optional<unsigned> parse_number(std::string_view text) {
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (hexadecimal) text.remove_prefix(2);
  unsigned value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value, hexadecimal ? 16 : 10);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

void close(const std::shared_ptr<detail::Link>& link) {
  if (!link) return;
  if (!link->is_receiver()) return link->close();
  // A callback has released its own client: the receiver thread ends when it has returned.
  std::thread([link] { link->close(); }).detach();
}

bool is_configured(const MasterStatus& master, unsigned slave) {
  return ((master.slaves_configured >> slave) & 1u) != 0;
}

}  // namespace

NoDaemon::~NoDaemon() = default;
SeveralDaemons::~SeveralDaemons() = default;
OtherProtocol::OtherProtocol(const std::string& bus_name, const std::string& served,
                             const std::string& needed)
    : NoDaemon("bus " + bus_name + " is served as " + served + "; this program needs " + needed),
      bus(bus_name),
      served_as(served),
      needs(needed) {}
OtherProtocol::~OtherProtocol() = default;
SetupError::~SetupError() = default;

std::string_view name(ReplyCode code) noexcept {
  switch (code) {
    case ReplyCode::done:
      return "done";
    case ReplyCode::refused:
      return "refused";
    case ReplyCode::slave_error:
      return "slave_error";
    case ReplyCode::timeout:
      return "timeout";
    case ReplyCode::no_answer:
      return "no_answer";
    case ReplyCode::word_expected:
      return "word_expected";
    case ReplyCode::doubleword_expected:
      return "doubleword_expected";
    case ReplyCode::value_too_wide:
      return "value_too_wide";
    case ReplyCode::cancelled:
      return "cancelled";
    case ReplyCode::master_stopped:
      return "master_stopped";
    case ReplyCode::slave_lost:
      return "slave_lost";
    case ReplyCode::replaced:
      return "replaced";
    case ReplyCode::no_daemon:
      return "no_daemon";
    case ReplyCode::no_reply:
      break;
  }
  return "no_reply";
}

std::string_view name(Speaker speaker) noexcept {
  switch (speaker) {
    case Speaker::client:
      return "client";
    case Speaker::daemon:
      return "daemon";
    case Speaker::slave:
      return "slave";
    case Speaker::nobody:
      break;
  }
  return "nobody there";
}

std::string describe(const Reply& reply) {
  if (reply.ok()) return "";
  return std::string(name(reply.speaker)) + ": " + reply.reason;
}

Subscription::~Subscription() {
  if (!hold_) return;
  decltype(hold_->callback) callback;  // what it holds, such as the client, goes when nobody runs it
  const std::lock_guard lock(hold_->running);
  callback.swap(hold_->callback);
}

Subscription& Subscription::operator=(Subscription&& other) noexcept {
  if (this == &other) return *this;
  const Subscription ended(std::move(*this));
  hold_ = std::move(other.hold_);
  return *this;
}

Client::Client(std::shared_ptr<detail::Link> link) : link_(std::move(link)) {}
Client::Client(Client&&) noexcept = default;

Client& Client::operator=(Client&& other) noexcept {
  if (this == &other) return *this;
  // Callbacks that run until then use it.
  close(link_);
  link_ = std::move(other.link_);
  return *this;
}

Client::~Client() {
  close(link_);
}

Client Client::connect(const Options& options) {
  const Options named = detail::with_bus(options);
  Client client(detail::set_up([&] { return std::make_shared<detail::Link>(named); }));
  client.link_->connect(options.wait);
  return client;
}

std::string Client::place() const {
  return link_->participant().place();
}
bool Client::daemon_present() const {
  return link_->daemon_present();
}

std::string Client::several_daemons() const {
  return link_->several_daemons();
}

std::uint32_t Client::participants() const noexcept {
  return link_->participant().others();
}

GatewayStatus Client::gateway_status() const {
  return link_->first<GatewayStatus>("GatewayStatus");
}

std::optional<GatewayStatus> Client::gateway_status(std::chrono::milliseconds time) const {
  return link_->first_within<GatewayStatus>(time);
}

BusStatus Client::bus_status() const {
  return link_->first<BusStatus>("BusStatus");
}

std::optional<BusStatus> Client::bus_status(std::chrono::milliseconds time) const {
  return link_->first_within<BusStatus>(time);
}

RealtimeStatus Client::realtime_status() const {
  return link_->first<RealtimeStatus>("RealtimeStatus");
}

std::optional<RealtimeStatus> Client::realtime_status(std::chrono::milliseconds time) const {
  return link_->first_within<RealtimeStatus>(time);
}

MasterStatus Client::master_status() const {
  return link_->first<MasterStatus>("MasterStatus");
}

std::optional<MasterStatus> Client::master_status(std::chrono::milliseconds time) const {
  return link_->first_within<MasterStatus>(time);
}

Validity Client::validity() const {
  return link_->validity();
}

std::optional<MasterStatus> Client::wait_status(const std::function<bool(const MasterStatus&)>& fits,
                                                std::chrono::milliseconds time) const {
  // What a daemon that has gone has told last is not how the line is.
  const auto counts = [&](const MasterStatus& status) {
    return link_->is_there(gateway::dds::daemon_of(status));
  };
  return link_->open<MasterStatus>().wait_each(time, counts, fits);
}

std::vector<SlaveStatus> Client::slaves(std::chrono::milliseconds time) const {
  link_->expect_own_protocol();
  const auto end = std::chrono::steady_clock::now() + time;
  const std::optional<MasterStatus> told =
      master_status(daemon_present() ? time : std::chrono::milliseconds(0));
  if (!told && !daemon_present()) throw NoDaemon(link_->gone());
  if (!told) return {};
  const MasterStatus& master = *told;
  auto& feed = link_->open<SlaveStatus>();
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
  (void)feed.wait(left, [&](const std::vector<SlaveStatus>& known) {
    std::uint32_t mask = 0;
    for (const SlaveStatus& slave : known) mask |= 1u << (slave.slave % cansync_SLAVES);
    return (master.slaves_configured & ~mask) == 0;
  });
  if (!daemon_present()) throw NoDaemon(link_->gone());
  std::vector<SlaveStatus> slaves = feed.known();
  std::erase_if(
      slaves, [&](const SlaveStatus& slave) { return !is_configured(master, slave.slave % cansync_SLAVES); });
  std::sort(slaves.begin(), slaves.end(),
            [](const SlaveStatus& a, const SlaveStatus& b) { return a.slave < b.slave; });
  return slaves;
}

std::optional<ActualValues> Client::actual_values(std::uint8_t slave, std::chrono::milliseconds time) const {
  std::optional<ActualValues> found;
  (void)link_->open<ActualValues>().wait(time, [&](const std::vector<ActualValues>& known) {
    const auto entry = std::find_if(known.begin(), known.end(),
                                    [&](const ActualValues& values) { return values.slave == slave; });
    if (entry != known.end()) found = *entry;
    return found.has_value();
  });
  return found;
}

SlaveLookup Client::find_slave(std::string_view number_or_name) const {
  if (const auto number = parse_number(number_or_name)) {
    if (*number < cansync_SLAVES) return {static_cast<std::uint8_t>(*number), ""};
    return {std::nullopt,
            "slave " + std::string(number_or_name) + ": out of range; allowed 0..31 or a slave's name"};
  }
  std::string names;
  SlaveLookup found;
  const std::vector<SlaveStatus> told = slaves();
  for (const SlaveStatus& slave : told) {
    const std::string_view slave_name = text(slave.name);
    if (slave_name.empty()) continue;
    if (slave_name == number_or_name) {
      // Each slave has a sample of its own: while names are exchanged two bear the same one.
      if (found.slave)
        return {std::nullopt, "slave '" + std::string(number_or_name) + "': slaves " +
                                  std::to_string(*found.slave) + " and " + std::to_string(slave.slave) +
                                  " bear this name at the moment; ask again, or give a number"};
      found.slave = slave.slave;
    }
    names += names.empty() ? "" : ", ";
    names += slave_name;
  }
  if (found.slave) return found;
  const auto master = master_status(std::chrono::milliseconds(0));
  if (!master || told.size() < static_cast<std::size_t>(std::popcount(master->slaves_configured)))
    return {std::nullopt,
            "slave '" + std::string(number_or_name) +
                "': the daemon has not told the names of all slaves yet; ask again, or give a number"};
  return {std::nullopt, "slave '" + std::string(number_or_name) +
                            "': no slave has this name; allowed 0..31 or " +
                            (names.empty() ? "a name, but no slave has one" : names)};
}

std::vector<Event> Client::recent_events(std::chrono::milliseconds quiet) const {
  auto& feed = link_->open<Event>();
  // What the daemon has kept comes at once; on a line where something always happens it is never quiet.
  constexpr std::chrono::milliseconds kMost{2000};
  feed.wait_quiet(quiet, kMost);
  std::vector<Event> events = feed.known();
  // Each level has a writer of its own.
  std::sort(events.begin(), events.end(), [](const Event& one, const Event& other) {
    return std::tie(one.time, one.number) < std::tie(other.time, other.number);
  });
  return events;
}

Subscription Client::on_actual_values(std::function<void(const ActualValues&)> callback) {
  return link_->subscribe<ActualValues>(std::move(callback));
}
Subscription Client::on_gateway_status(std::function<void(const GatewayStatus&)> callback) {
  return link_->subscribe<GatewayStatus>(std::move(callback));
}
Subscription Client::on_bus_status(std::function<void(const BusStatus&)> callback) {
  return link_->subscribe<BusStatus>(std::move(callback));
}
Subscription Client::on_realtime_status(std::function<void(const RealtimeStatus&)> callback) {
  return link_->subscribe<RealtimeStatus>(std::move(callback));
}
Subscription Client::on_master_status(std::function<void(const MasterStatus&)> callback) {
  return link_->subscribe<MasterStatus>(std::move(callback));
}
Subscription Client::on_restart(std::function<void(const GatewayStatus&)> callback) {
  using gateway::dds::DaemonIdentity;
  std::deque<DaemonIdentity> known;
  if (const auto start = link_->told_start()) known.push_back(*start);
  return on_gateway_status([callback = std::move(callback), known = std::move(known),
                            link = std::weak_ptr(link_)](const GatewayStatus& status) mutable {
    const DaemonIdentity start = gateway::dds::daemon_of(status);
    // Of two daemons that both live, each is told once.
    constexpr std::size_t kKnown = 32;
    if (std::find(known.begin(), known.end(), start) != known.end()) return;
    known.push_back(start);
    if (known.size() == 1) return;
    if (known.size() > kKnown) known.pop_front();
    // Also for what the program asks for in it.
    if (const auto to = link.lock()) to->program_told_of(start);
    callback(status);
  });
}
Subscription Client::on_slave_status(std::function<void(const SlaveStatus&)> callback) {
  return link_->subscribe<SlaveStatus>(std::move(callback));
}
Subscription Client::on_event(std::function<void(const Event&)> callback) {
  return link_->subscribe<Event>(std::move(callback));
}
Subscription Client::on_timing(std::function<void(const Timing&)> callback) {
  return link_->subscribe<Timing>(std::move(callback));
}
Subscription Client::on_interval(std::function<void(const Interval&)> callback) {
  return link_->subscribe<Interval>(std::move(callback));
}

}  // namespace cansync::client
