#include <cansync/function_blocks/init.h>
#include <cansync/topics.h>

#include <exception>
#include <utility>

#include "client/src/function_blocks/option_status.h"

namespace cansync::client::function_blocks {
namespace {

/// bit/s of us_BAUDRATE (M 4.9); 0: no such number.
std::uint32_t bit_rate_of(USINT number) {
  constexpr std::array<std::uint32_t, 4> kRates = {125'000, 250'000, 500'000, 1'000'000};
  constexpr USINT kFirst = 3;
  return number < kFirst || number >= kFirst + kRates.size() ? 0 : kRates[number - kFirst];
}

}  // namespace

INIT::~INIT() = default;

void INIT::call() {
  if (x_OK || x_ERR) return;
  if (client_) {
    if (set_up()) x_OK = true;
    return;
  }
  if (x_SL) return fail(init_error::not_completed, "client: x_SL: the daemon is a master; allowed FALSE");
  if (!connecting_.valid())
    connecting_ = std::async(std::launch::async, [options = options_] {
      Client client = Client::connect(options);
      (void)client.bus_status();  // from here on it is known, and `compare` waits for nothing
      return client;
    });
  if (connecting_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  try {
    client_.emplace(connecting_.get());
  } catch (const NoDaemon& error) {
    return fail(init_error::handshake_timeout, error.what());
  } catch (const std::exception& error) {
    return fail(init_error::not_completed, error.what());
  }
  compare();
}

void INIT::compare() {
  constexpr std::uint64_t kMillisecond = 1'000'000;  // ns
  const MasterStatus status = client_->master_status();
  const std::uint32_t bit_rate = client_->bus_status().bit_rate;
  if (us_BAUDRATE != 0 && bit_rate_of(us_BAUDRATE) != bit_rate)
    return fail(init_error::bit_timing, "client: us_BAUDRATE " + std::to_string(us_BAUDRATE) +
                                            ": the daemon has " + std::to_string(bit_rate) +
                                            " bit/s; change bus.bit_rate or this");
  if (us_SYNC_INTERVAL != 0 && us_SYNC_INTERVAL * kMillisecond != status.interval_length)
    return fail(init_error::bit_timing, "client: us_SYNC_INTERVAL " + std::to_string(us_SYNC_INTERVAL) +
                                            " ms: the daemon has " + std::to_string(status.interval_length) +
                                            " ns");
  for (std::size_t slave = 0; slave < a_SL_TYP.size(); ++slave) {
    if (a_SL_TYP[slave] != 0 && ((status.slaves_configured >> slave) & 1u) == 0)
      return fail(init_error::not_completed,
                  "client: a_SL_TYP[" + std::to_string(slave) + "]: the daemon has no such slave configured");
  }
  if (set_up()) x_OK = true;
}

/// True when x_SYNC_MODE has nothing (more) to do. A set-up that is past is no command: it would take a line
/// that runs out of active operation.
bool INIT::set_up() {
  if (!set_up_) {
    const WORD status = client_->master_status().option_status;
    if (!x_SYNC_MODE || is_synchronous(status)) return true;
    set_up_.emplace(client_->mode(Mode::setup));
  }
  const std::optional<CommandReply> reply = set_up_->wait_for(std::chrono::milliseconds(0));
  if (!reply) return false;
  if (!reply->ok()) fail(init_error::not_completed, describe(*reply));
  return reply->ok();
}

void INIT::fail(WORD bits, std::string reason) {
  set_up_.reset();
  client_.reset();
  x_OK = false;
  x_ERR = true;
  w_ERR = bits;
  error_ = std::move(reason);
}

}  // namespace cansync::client::function_blocks
