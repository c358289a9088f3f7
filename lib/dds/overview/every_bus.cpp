#include "dds/overview/every_bus.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <tuple>

#include "dds/bounded_text.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace gateway::dds {

std::vector<gateway_GatewayStatus> daemons_of_every_bus(const ClientOptions& options) {
  using Clock = std::chrono::steady_clock;
  ParticipantOptions wide = options.participant();
  wide.all_partitions = {"*"};
  const Participant participant(wide);
  DataSignal signal;
  Reader<gateway_GatewayStatus> reader(participant, Partitions{"*"}, &signal);
  std::map<dds_instance_handle_t, gateway_GatewayStatus> newest;  // by writer
  const auto end = Clock::now() + options.wait;
  while (Clock::now() < end && !options.stopped()) {
    (void)signal.wait(DaemonSight::kLookMs);
    signal.clear();
    (void)reader.take_batch([&](const gateway_GatewayStatus& sample, const dds_sample_info_t& info) {
      if (info.valid_data)
        newest[info.publication_handle] = sample;
      else if (info.instance_state != DDS_IST_ALIVE)
        newest.erase(info.publication_handle);
    });
  }
  std::vector<gateway_GatewayStatus> found;
  found.reserve(newest.size());
  for (const auto& [writer, status] : newest) found.push_back(status);
  std::sort(found.begin(), found.end(), [](const auto& one, const auto& other) {
    const auto order = [](const auto& status) {
      return std::tuple(text(status.bus), text(status.host), status.process);
    };
    return order(one) < order(other);
  });
  return found;
}

}  // namespace gateway::dds
