#include <cansync/topics.h>

#include <algorithm>

#include "client/src/c_face/handle.h"

/// Actual values, reference values and events of the C face.
namespace {

using cansync::client::ActualValues;
using cansync::client::Client;
using cansync::client::Event;
using cansync::client::Subscription;
using cansync::client::c_face::connected;
using cansync::client::c_face::fail;
using cansync::client::c_face::not_told;

cansync_actual_values to_c(const ActualValues& from) {
  cansync_actual_values to = {};
  to.slave = from.slave;
  std::copy(std::begin(from.raw), std::end(from.raw), std::begin(to.raw));
  std::copy(std::begin(from.scaled), std::end(from.scaled), std::begin(to.scaled));
  std::copy(std::begin(from.interval), std::end(from.interval), std::begin(to.interval));
  to.arrived = from.arrived;
  to.receive_time_ns = from.receive_time;
  return to;
}

cansync_event to_c(const Event& from) {
  return {from.number, from.time, from.interval, static_cast<std::int32_t>(from.severity),
          from.slave,  from.code, from.text};
}

}  // namespace

int cansync_get_actual_values(cansync_client* handle, uint32_t slave, uint32_t timeout_ms,
                              cansync_actual_values* out) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (out == nullptr || slave >= cansync_SLAVES)
      return fail(open, CANSYNC_INVALID, "client: out is NULL, or slave is out of range; allowed 0..31");
    const auto values =
        client.actual_values(static_cast<std::uint8_t>(slave), std::chrono::milliseconds(timeout_ms));
    if (!values && !client.daemon_present()) return not_told(open, client);
    if (!values) {
      return fail(open, CANSYNC_NO_DATA,
                  "client: no actual values of slave " + std::to_string(slave) + " within " +
                      std::to_string(timeout_ms) + " ms; is the line in run?");
    }
    *out = to_c(*values);
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_subscribe_actual_values(cansync_client* handle, cansync_on_actual_values callback,
                                    void* user) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    open.actual_values = Subscription();
    if (callback == nullptr) return static_cast<int>(CANSYNC_DONE);
    open.actual_values = client.on_actual_values([callback, user](const ActualValues& values) {
      const cansync_actual_values converted = to_c(values);
      callback(user, &converted);
    });
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_subscribe_events(cansync_client* handle, cansync_on_event callback, void* user) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    open.events = Subscription();
    if (callback == nullptr) return static_cast<int>(CANSYNC_DONE);
    open.events = client.on_event([callback, user](const Event& event) {
      const cansync_event converted = to_c(event);
      callback(user, &converted);
    });
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_take_references(cansync_client* handle, int32_t strength) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (strength < 0 && strength != cansync::client::kTakeOver)
      return fail(
          open, CANSYNC_INVALID,
          "client: strength " + std::to_string(strength) + ": allowed 0 and more, or CANSYNC_TAKE_OVER");
    open.writer.reset();
    open.writer.emplace(client, strength);
    open.writer->take_up();  // this program knows which start it is for
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_give_references(cansync_client* handle, uint8_t telegram, const int32_t value[4], uint8_t valid,
                            uint32_t release_intervals, uint64_t from_interval) noexcept {
  return connected(handle, [&](cansync_client& open, Client&) {
    if (!open.writer)
      return fail(open, CANSYNC_INVALID,
                  "client: no right to give values; call cansync_take_references() first");
    if (value == nullptr) return fail(open, CANSYNC_INVALID, "client: value is NULL");
    std::array<std::int32_t, 4> values = {};
    std::copy_n(value, values.size(), values.begin());
    std::string failed = open.writer->write(telegram, values, valid, release_intervals, from_interval);
    if (failed.empty()) return static_cast<int>(CANSYNC_DONE);
    if (open.writer->standing() != cansync::client::ReferenceStanding::current) {
      // Asked again, for it may have changed since: nothing is written, and the reason is that of the result.
      failed = open.writer->write(telegram, values, valid, release_intervals, from_interval);
      return fail(open, CANSYNC_TAKE_UP, "client: " + failed);
    }
    return fail(open, open.writer->waits() ? CANSYNC_REFUSED : CANSYNC_FAILED, "client: " + failed);
  });
}

int cansync_leave_references(cansync_client* handle) noexcept {
  return connected(handle, [&](cansync_client& open, Client&) {
    open.writer.reset();
    return static_cast<int>(CANSYNC_DONE);
  });
}
