#include "daemon/desk/second_daemon.h"

#include <fmt/format.h>

#include <utility>

namespace cansyncd {

SecondDaemon::SecondDaemon(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
                           EventPublisher& events, std::string bus, const gateway::dds::DaemonIdentity& own)
    : others_(participant, own, &signal), events_(events), bus_(std::move(bus)) {}

void SecondDaemon::look(SteadyTime now) {
  const auto news = others_.look();
  for (const auto& other : news.came) {
    events_.publish(
        {gateway_SEVERITY_ERROR, "second_daemon", -1,
         fmt::format("another daemon serves bus {}: {}; clients ask neither until one is stopped, or has a "
                     "bus.name of its own",
                     bus_, other.name),
         std::nullopt},
        now);
  }
  for (const auto& other : news.gone) {
    events_.publish({gateway_SEVERITY_INFO, "second_daemon_gone", -1,
                     fmt::format("the other daemon of bus {} is gone: {}", bus_, other.name), std::nullopt},
                    now);
  }
}

}  // namespace cansyncd
