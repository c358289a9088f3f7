#include <cansync/topics.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "client/src/c_face/handle.h"

/// Status, modes, control words and broadcasts of the C face.
namespace {

using cansync::client::Client;
using cansync::client::MasterStatus;
using cansync::client::Mode;
using cansync::client::c_face::connected;
using cansync::client::c_face::fail;
using cansync::client::c_face::not_told;
using cansync::client::c_face::result_of;

static_assert(static_cast<int>(Mode::setup) == CANSYNC_MODE_SETUP);
static_assert(static_cast<int>(Mode::restart) == CANSYNC_MODE_RESTART);

constexpr std::uint16_t kActive = 0x0080;  // w_OPTION_STATUS
constexpr std::uint64_t kBitTimes = 1000;  // of an interval: 8 ms at 125 kbit/s to 1 ms at 1 Mbit/s

}  // namespace

namespace cansync::client::c_face {

int number_of(ReplyCode code) noexcept {
  // The numbers of these are others here.
  if (code == ReplyCode::replaced) return CANSYNC_REPLACED;
  if (code == ReplyCode::no_daemon) return CANSYNC_NO_DAEMON;
  return static_cast<int>(code);
}

int not_told(cansync_client& handle, const Client& client) {
  return client.daemon_present()
             ? fail(handle, CANSYNC_NO_DATA, "client: nothing has come yet")
             : fail(handle, CANSYNC_NO_DAEMON, "client: no daemon is there (" + client.place() + ")");
}

int result_of(cansync_client& handle, const Reply& reply) {
  handle.cause = reply.cause;
  return fail(handle, number_of(reply.code), describe(reply));
}

}  // namespace cansync::client::c_face

int cansync_get_status(cansync_client* handle, cansync_line_status* out) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (out == nullptr) return fail(open, CANSYNC_INVALID, "client: out is NULL");
    *out = {};
    const std::optional<MasterStatus> known = client.master_status(std::chrono::milliseconds(0));
    if (!known) return not_told(open, client);
    const MasterStatus& status = *known;
    out->option_status = status.option_status;
    out->interface_status = status.cansync_status;
    // Zeros are behind the text.
    const std::string_view state = cansync::client::text(status.state);
    std::copy_n(state.begin(), std::min(state.size(), sizeof out->state - 1), out->state);
    // What BusStatus says may not have come yet.
    if (status.interval_length != 0)
      out->bit_rate = static_cast<std::uint32_t>(kBitTimes * 1'000'000'000 / status.interval_length);
    out->interval_ns = status.interval_length;
    out->interval = status.interval;
    out->slaves_configured = status.slaves_configured;
    out->slaves_responding = status.slaves_responding;
    out->slaves_synchronized = status.slaves_synchronized;
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_wait_active(cansync_client* handle, uint32_t timeout_ms) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    const auto active = [](const MasterStatus& status) {
      return status.option_status == kActive && status.slaves_synchronized == status.slaves_configured;
    };
    if (client.wait_status(active, std::chrono::milliseconds(timeout_ms)))
      return static_cast<int>(CANSYNC_DONE);
    const std::optional<MasterStatus> status = client.master_status(std::chrono::milliseconds(0));
    if (!status && !client.daemon_present()) return not_told(open, client);
    return fail(open, CANSYNC_TIMEOUT,
                "client: " + (timeout_ms == 0 ? "" : "not within " + std::to_string(timeout_ms) + " ms: ") +
                    "the state is '" +
                    (status ? std::string(cansync::client::text(status->state)) : "not told yet") +
                    "'; see mode and the slaves' status");
  });
}

int cansync_find_slave(cansync_client* handle, const char* number_or_name, uint32_t* slave) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (number_or_name == nullptr || slave == nullptr)
      return fail(open, CANSYNC_INVALID, "client: number_or_name or slave is NULL");
    const cansync::client::SlaveLookup found = client.find_slave(number_or_name);
    if (!found.slave) return fail(open, CANSYNC_INVALID, "client: " + found.problem);
    *slave = *found.slave;
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_control_word(cansync_client* handle, uint32_t slave, uint32_t word) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    return result_of(open, client.control_word(slave, word).wait());
  });
}

int cansync_broadcast(cansync_client* handle, uint32_t priority, uint32_t slave_mask, uint32_t action,
                      uint32_t data_byte, uint32_t data_word) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    return result_of(open, client.broadcast({priority, slave_mask, action, data_byte, data_word, 0}).wait());
  });
}

int cansync_set_mode(cansync_client* handle, int mode, int force) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (mode < CANSYNC_MODE_SETUP || mode > CANSYNC_MODE_RESTART)
      return fail(open, CANSYNC_INVALID,
                  "client: mode " + std::to_string(mode) + ": out of range; allowed 0..4");
    return result_of(open, client.mode(static_cast<Mode>(mode), force != 0).wait());
  });
}

int cansync_release_slave(cansync_client* handle, uint32_t slave, int force) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    return result_of(open, client.release(slave, force != 0).wait());
  });
}
