#include <cansync/topics.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <utility>

#include "client/src/c_face/handle.h"

/// A topic that a program of the C face follows.
struct cansync_subscription {
  explicit cansync_subscription(cansync::client::Subscription of_topic) : subscription(std::move(of_topic)) {}

  cansync::client::Subscription subscription;
};

namespace {

using cansync::client::Client;
using cansync::client::SlaveStatus;
using cansync::client::Subscription;
using cansync::client::c_face::connected;
using cansync::client::c_face::fail;
using cansync::client::c_face::not_told;

/// Copies a sample, or says that there is none.
template <class Sample>
int give(cansync_client& open, const Client& client, const std::optional<Sample>& sample, void* out,
         std::size_t size) {
  if (size != sizeof(Sample)) {
    return fail(open, CANSYNC_INVALID,
                "client: size " + std::to_string(size) + ": the struct of this topic has " +
                    std::to_string(sizeof(Sample)) +
                    " bytes; was the program built with the headers of another version?");
  }
  if (!sample) return not_told(open, client);
  std::memcpy(out, &*sample, sizeof(Sample));
  return CANSYNC_DONE;
}

std::optional<SlaveStatus> slave_status(const Client& client, std::uint32_t number,
                                        std::chrono::milliseconds time) {
  for (const SlaveStatus& status : client.slaves(time)) {
    if (status.slave == number) return status;
  }
  return std::nullopt;
}

std::optional<Subscription> follow(Client& client, int topic, cansync_on_sample callback, void* user) {
  const auto forward = [callback, user](const auto& sample) { callback(user, &sample); };
  switch (topic) {
    case CANSYNC_TOPIC_MASTER_STATUS:
      return client.on_master_status(forward);
    case CANSYNC_TOPIC_GATEWAY_STATUS:
      return client.on_gateway_status(forward);
    case CANSYNC_TOPIC_BUS_STATUS:
      return client.on_bus_status(forward);
    case CANSYNC_TOPIC_REALTIME_STATUS:
      return client.on_realtime_status(forward);
    case CANSYNC_TOPIC_SLAVE_STATUS:
      return client.on_slave_status(forward);
    case CANSYNC_TOPIC_ACTUAL_VALUES:
      return client.on_actual_values(forward);
    case CANSYNC_TOPIC_EVENT:
      return client.on_event(forward);
    case CANSYNC_TOPIC_TIMING:
      return client.on_timing(forward);
    case CANSYNC_TOPIC_INTERVAL:
      return client.on_interval(forward);
    default:
      return std::nullopt;
  }
}

}  // namespace

int cansync_get_sample(cansync_client* handle, int topic, uint32_t slave, uint32_t timeout_ms, void* out,
                       size_t size) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (out == nullptr || slave >= cansync_SLAVES)
      return fail(open, CANSYNC_INVALID, "client: out is NULL, or slave is out of range; allowed 0..31");
    const std::chrono::milliseconds time(timeout_ms);
    switch (topic) {
      case CANSYNC_TOPIC_MASTER_STATUS:
        return give(open, client, client.master_status(time), out, size);
      case CANSYNC_TOPIC_GATEWAY_STATUS:
        return give(open, client, client.gateway_status(time), out, size);
      case CANSYNC_TOPIC_BUS_STATUS:
        return give(open, client, client.bus_status(time), out, size);
      case CANSYNC_TOPIC_REALTIME_STATUS:
        return give(open, client, client.realtime_status(time), out, size);
      case CANSYNC_TOPIC_SLAVE_STATUS:
        return give(open, client, slave_status(client, slave, time), out, size);
      case CANSYNC_TOPIC_ACTUAL_VALUES:
        return give(open, client, client.actual_values(static_cast<std::uint8_t>(slave), time), out, size);
      default:
        return fail(
            open, CANSYNC_INVALID,
            "client: topic " + std::to_string(topic) +
                ": allowed the status of the master, of slaves, and actual values; follow the others");
    }
  });
}

cansync_subscription* cansync_subscribe(cansync_client* handle, int topic, cansync_on_sample callback,
                                        void* user) noexcept {
  std::unique_ptr<cansync_subscription> made;
  (void)connected(handle, [&](cansync_client& open, Client& client) {
    if (callback == nullptr) return fail(open, CANSYNC_INVALID, "client: callback is NULL");
    auto subscription = follow(client, topic, callback, user);
    if (!subscription)
      return fail(open, CANSYNC_INVALID, "client: topic " + std::to_string(topic) + ": allowed 0..8");
    made = std::make_unique<cansync_subscription>(std::move(*subscription));
    return static_cast<int>(CANSYNC_DONE);
  });
  return made.release();
}

void cansync_unsubscribe(cansync_subscription* subscription) noexcept {
  delete subscription;
}
