#pragma once

#include <chrono>
#include <string>

#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/reply_partition.h"
#include "dds/signal.h"
#include "support/free_domain.h"
#include "support/long_wait.h"

/// Two places in one process that see each other over the loopback network only, like two programs: `here`
/// and `there` have their own Cyclone domain each, with the same number on the network.
class TwoPlaces {
 public:
  explicit TwoPlaces(const std::string& bus = "testbus") {
    here.domain = network_.get();
    here.partition = bus;
    there.domain = inside_.get();
    there.partition = bus;
    const std::string discovery = "<Discovery>";
    there.xml = gateway::dds::configuration(here);
    there.xml.insert(there.xml.find(discovery) + discovery.size(),
                     "<ExternalDomainId>" + std::to_string(network_.get()) + "</ExternalDomainId>");
    here.serves = true;
  }

 private:
  FreeDomain network_;
  FreeDomain inside_;

 public:
  gateway::dds::ParticipantOptions here;  ///< where the daemon is
  gateway::dds::ParticipantOptions there;
};

/// Where replies to the identities of tests are heard, the first byte of which is any and the rest 0.
inline gateway::dds::Partitions replies_to_all(const gateway::dds::ParticipantOptions& place) {
  gateway::dds::Partitions partitions;
  for (unsigned n = 0; n < 256; ++n)
    partitions.push_back(gateway::dds::reply_partition(place.partition, {static_cast<std::uint8_t>(n)}));
  return partitions;
}

/// Waits until `condition` holds, asking after each raise of `signal`; false when it does not within 20 s.
template <class Condition>
bool eventually(gateway::dds::DataSignal& signal, Condition&& condition) {
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  while (!condition()) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    (void)signal.wait(static_cast<int>(left.count()));
    signal.clear();
  }
  return true;
}
