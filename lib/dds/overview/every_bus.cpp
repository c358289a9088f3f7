#include "dds/overview/every_bus.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

#include "dds/bounded_text.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "text/counts.h"

namespace gateway::dds {
namespace {

using Clock = std::chrono::steady_clock;

ParticipantOptions of_all_partitions(const ClientOptions& options) {
  ParticipantOptions wide = options.participant();
  if (wide.partition.empty()) wide.partition = "sim";  // of what it would write: nothing
  wide.all_partitions = {"*"};
  return wide;
}

/// What the daemons of all buses told last.
class EveryBus {
 public:
  explicit EveryBus(const ClientOptions& options)
      : participant_(of_all_partitions(options)), reader_(participant_, Partitions{"*"}, &signal_) {}

  /// Takes what has come, after at most `DaemonSight::kLookMs`.
  void look() {
    (void)signal_.wait(DaemonSight::kLookMs);
    signal_.clear();
    (void)reader_.take_batch([&](const gateway_GatewayStatus& sample, const dds_sample_info_t& info) {
      if (info.valid_data)
        newest_[info.publication_handle] = sample;
      else if (info.instance_state != DDS_IST_ALIVE)
        newest_.erase(info.publication_handle);
    });
  }

  /// By bus, host and process.
  std::vector<gateway_GatewayStatus> found() const {
    std::vector<gateway_GatewayStatus> found;
    found.reserve(newest_.size());
    for (const auto& [writer, status] : newest_) found.push_back(status);
    std::sort(found.begin(), found.end(), [](const auto& one, const auto& other) {
      const auto order = [](const auto& status) {
        return std::tuple(text(status.bus), text(status.host), status.process);
      };
      return order(one) < order(other);
    });
    return found;
  }

  std::set<std::string> buses() const {
    std::set<std::string> names;
    for (const auto& [writer, status] : newest_) names.emplace(text(status.bus));
    return names;
  }

 private:
  Participant participant_;
  DataSignal signal_;
  Reader<gateway_GatewayStatus> reader_;
  std::map<dds_instance_handle_t, gateway_GatewayStatus> newest_;  // by writer
};

std::string where(const ClientOptions& options) {
  return fmt::format("DDS domain {} on interface {}", options.domain, options.interface);
}

/// "mill (cansync-master), press (cansync-slave)".
std::string names_of(const std::vector<gateway_GatewayStatus>& daemons) {
  std::string names;
  std::string_view before;
  for (const gateway_GatewayStatus& status : daemons) {
    if (text(status.bus) == before) continue;
    before = text(status.bus);
    names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", before, text(status.protocol));
  }
  return names;
}

}  // namespace

std::vector<gateway_GatewayStatus> daemons_of_every_bus(const ClientOptions& options) {
  EveryBus every(options);
  const auto end = Clock::now() + options.wait;
  while (Clock::now() < end && !options.stopped()) every.look();
  return every.found();
}

std::string only_bus(const ClientOptions& options) {
  constexpr std::chrono::milliseconds kSettle{500};
  EveryBus every(options);
  auto end = Clock::now() + options.wait;
  std::set<std::string> buses;
  while (Clock::now() < end && !options.stopped()) {
    every.look();
    if (auto now = every.buses(); now != buses) {
      buses = std::move(now);
      if (!buses.empty()) end = Clock::now() + kSettle;
    }
  }
  if (buses.size() == 1 && Clock::now() >= end) return *buses.begin();
  if (buses.size() > 1)
    throw SeveralBuses(fmt::format("{} are served in {}: {}; name one of them",
                                   text::counted(buses.size(), "bus", "buses"), where(options),
                                   names_of(every.found())));
  throw NoDaemon(fmt::format(
      "no daemon found: looked for {} for a daemon of any bus in {}; is cansyncd running, with the same domain and "
      "interface in its [dds] section? A daemon with DDS Security is not seen without an identity",
      text::duration_text(options.wait), where(options)));
}

}  // namespace gateway::dds
