#include <cansync/function_blocks/init.h>
#include <cansync/topics.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "client/src/cansync_slave/slave_side.h"
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
  if (x_SL) {
    if (!connecting_slave_.valid())
      connecting_slave_ =
          std::async(std::launch::async, [options = options_] { return SlaveConnection::connect(options); });
    connect(connecting_slave_, slave_);
    if (slave_) compare_slave();
    return;
  }
  if (!connecting_.valid())
    connecting_ = std::async(std::launch::async, [options = options_] {
      Client client = Client::connect(options);
      (void)client.bus_status();  // from here on it is known, and `compare` waits for nothing
      return client;
    });
  connect(connecting_, client_);
  if (client_) compare();
}

/// Takes the connection when it is there.
template <class Connection>
void INIT::connect(std::future<Connection>& connecting, std::optional<Connection>& connection) {
  if (connecting.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  try {
    connection.emplace(connecting.get());
  } catch (const NoDaemon& error) {
    fail(init_error::handshake_timeout, error.what());
  } catch (const std::exception& error) {
    fail(init_error::not_completed, error.what());
  }
}

/// False: us_BAUDRATE or us_SYNC_INTERVAL is not the daemon's, which has these.
bool INIT::compare_rates(std::uint32_t bit_rate, std::uint64_t interval) {
  constexpr std::uint64_t kMillisecond = 1'000'000;  // ns
  if (us_BAUDRATE != 0 && bit_rate_of(us_BAUDRATE) != bit_rate) {
    fail(init_error::bit_timing, "client: us_BAUDRATE " + std::to_string(us_BAUDRATE) + ": the daemon has " +
                                     std::to_string(bit_rate) + " bit/s; change bus.bit_rate or this");
    return false;
  }
  if (us_SYNC_INTERVAL != 0 && us_SYNC_INTERVAL * kMillisecond != interval) {
    fail(init_error::bit_timing, "client: us_SYNC_INTERVAL " + std::to_string(us_SYNC_INTERVAL) +
                                     " ms: the daemon has " + std::to_string(interval) + " ns");
    return false;
  }
  return true;
}

void INIT::compare_slave() {
  constexpr std::uint64_t kBitsPerInterval = 1000;  // at every bit rate (M 3.1.1)
  constexpr std::uint64_t kSecond = 1'000'000'000;  // ns
  const std::uint64_t interval = std::max<std::uint64_t>(slave_->side().status().interval_length, 1);
  x_OK = compare_rates(static_cast<std::uint32_t>(kBitsPerInterval * kSecond / interval), interval);
}

void INIT::compare() {
  const auto status = client_->master_status(std::chrono::milliseconds(0));
  const auto bus = client_->bus_status(std::chrono::milliseconds(0));
  if (!status || !bus)
    return fail(init_error::handshake_timeout, "client: the daemon has gone (" + client_->place() + ")");
  if (!compare_rates(bus->bit_rate, status->interval_length)) return;
  for (std::size_t slave = 0; slave < a_SL_TYP.size(); ++slave) {
    if (a_SL_TYP[slave] != 0 && ((status->slaves_configured >> slave) & 1u) == 0)
      return fail(init_error::not_completed,
                  "client: a_SL_TYP[" + std::to_string(slave) + "]: the daemon has no such slave configured");
  }
  if (set_up()) x_OK = true;
}

/// True when x_SYNC_MODE has nothing (more) to do. A set-up that is past is no command: it would take a line
/// that runs out of active operation.
bool INIT::set_up() {
  if (!set_up_) {
    if (!x_SYNC_MODE) return true;
    const auto status = client_->master_status(std::chrono::milliseconds(0));
    if (status && is_synchronous(status->option_status)) return true;
    if (!status && client_->daemon_present()) return false;  // it may run
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
  slave_.reset();
  x_OK = false;
  x_ERR = true;
  w_ERR = bits;
  error_ = std::move(reason);
}

}  // namespace cansync::client::function_blocks
