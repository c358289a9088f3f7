#pragma once

#include <future>
#include <optional>
#include <string>

#include "../client.h"
#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// Bits of `w_ERR` of INIT (M 4.9).
namespace init_error {
inline constexpr WORD handshake_timeout = 0x0001;  ///< no daemon serves the bus
inline constexpr WORD bit_timing = 0x0002;         ///< us_BAUDRATE or us_SYNC_INTERVAL is not the daemon's
inline constexpr WORD not_completed = 0x0800;      ///< everything else, `error()` says what
}  // namespace init_error

/// CANsync_INIT with CANsync_SL_TYP_INIT (M 4.9): connects to the daemon.
///
/// What the option module is told here is the daemon's configuration file; the inputs are compared with it,
/// and nothing is changed on the line but its mode, with x_SYNC_MODE. x_SYNC_IN, x_ASYNC_MODE0 and 1, the bit
/// timing registers and the acceptance filter have no counterpart. Connecting runs on a thread of its own;
/// call until x_OK or x_ERR. Of a slave a_SL_TYP means nothing (M 4.9), and x_SYNC_MODE has no effect: the
/// daemon sets its mode by itself.
class CANSYNC_PUBLIC INIT {
 public:
  BOOL x_SL = false;              ///< TRUE: the daemon is a slave, and `slave()` the connection
  USINT us_BAUDRATE = 0;          ///< 3 125 kbit/s, 4 250, 5 500, 6 1 Mbit/s; 0: whatever the daemon has
  USINT us_SYNC_INTERVAL = 0;     ///< 8, 4, 2, 1 ms; 0: whatever the daemon has
  BOOL x_SYNC_MODE = false;       ///< TRUE: the line is set up, unless it is set up or active
  BYTE_32_BMARRAY a_SL_TYP = {};  ///< not 0: that slave must be configured; all 0: whatever the daemon has

  WORD w_ERR = 0;  ///< bits of `init_error`
  BOOL x_ERR = false;
  BOOL x_OK = false;

  /// What went wrong, in words. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// The connection, when x_OK and x_SL is FALSE; for the other blocks of a master. Lives as long as this
  /// block.
  Client& client() { return *client_; }
  /// The connection, when x_OK and x_SL is TRUE; for the other blocks of a slave. Lives as long as this
  /// block.
  SlaveConnection& slave() { return *slave_; }

  /// Where the daemon is looked for; connects with the first `call`, not here.
  explicit INIT(Options options) : options_(std::move(options)) {}
  /// Waits until a connecting thread has ended, at most `options.wait`.
  ~INIT();
  INIT(const INIT&) = delete;
  INIT& operator=(const INIT&) = delete;

  /// One cycle: begins to connect, compares the inputs once that is done, and has the line set up. Does
  /// nothing after x_OK or x_ERR; another attempt takes another block. Throws std::system_error when no
  /// thread can be started.
  void call();

 private:
  void fail(WORD bits, std::string reason);
  template <class Connection>
  void connect(std::future<Connection>& connecting, std::optional<Connection>& connection);
  void compare();
  void compare_slave();
  bool compare_rates(std::uint32_t bit_rate, std::uint64_t interval);
  bool set_up();

  Options options_;
  std::future<Client> connecting_;
  std::optional<Client> client_;
  std::future<SlaveConnection> connecting_slave_;
  std::optional<SlaveConnection> slave_;
  std::optional<CommandJob> set_up_;  ///< asked for with x_SYNC_MODE
  std::string error_;
};

}  // namespace cansync::client::function_blocks
