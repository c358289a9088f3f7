#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// Bits of `w_ERR` of UPDOWNLOAD_SL (M 4.25).
namespace updownload_sl_error {
inline constexpr WORD timeout = 0x0001;  ///< not done within t_TIME
}  // namespace updownload_sl_error

/// CANsync_UPDOWNLOAD_SL (M 4.25): takes downloads and gives uploads in block area 1, as UPDOWNLOAD_MA asks.
///
/// The first block of a job begins at [0] whatever its start address, and each further one where the one
/// before ended. The manual does not say how the end of a job is known: here it has ended with a block of
/// less than 75 doublewords, when the arrays are full, or when no block in the same direction follows a full
/// one within t_NEXT. Blocks of more than 300 bytes, which move telegram by telegram, are refused with
/// 16#0104.
class CANSYNC_PUBLIC UPDOWNLOAD_SL {
 public:
  CANsync_UPDOWN_BMARRAY a_DOWNLOAD = {};  ///< of the newest download
  CANsync_UPDOWN_BMARRAY a_UPLOAD = {};    ///< what uploads give; lies here before the job
  TIME t_TIME = std::chrono::seconds(30);  ///< monitoring time of a job
  BOOL x_EN = false;
  BOOL x_RESET = false;

  BOOL x_UPDOWN = false;       ///< of the job: TRUE download
  BOOL x_ORDER_ACTIV = false;  ///< a job is present
  UINT u_LENGTH = 0;           ///< doublewords of the running block, 1..75
  BOOL x_BUSY = false;         ///< likewise
  BOOL x_OK = false;           ///< the job was done
  BOOL x_ERR = false;
  WORD w_ERR = 0;  ///< bits of `updownload_sl_error`

  TIME t_NEXT = std::chrono::seconds(1);  ///< how long a full block waits for the next. Not in the manual.
  UINT u_TRANSFERRED = 0;                 ///< doublewords of the whole job so far. Not in the manual.

  /// The daemon asks another program, or none yet: this one gets no jobs. Not in the manual.
  BOOL x_STANDBY = false;

  /// What went wrong, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block, and has one UPDOWNLOAD_SL at most; throws SetupError for another.
  explicit UPDOWNLOAD_SL(SlaveConnection& connection);
  ~UPDOWNLOAD_SL();
  UPDOWNLOAD_SL(const UPDOWNLOAD_SL&) = delete;
  UPDOWNLOAD_SL& operator=(const UPDOWNLOAD_SL&) = delete;

  /// One cycle. At least one a second while x_EN is TRUE.
  void call(Clock::time_point now = Clock::now());

 private:
  enum class Phase : std::uint8_t { idle, moving, pausing, locked };

  void take(const detail::BlockStep& step, Clock::time_point now);
  void begin(const detail::BlockStep& step, Clock::time_point now);
  void ended(const detail::BlockStep& step, Clock::time_point now);
  void finish();
  void cancelled(std::string reason);
  void fail(WORD bits, std::string reason);
  void lock();
  void clear();

  SlaveConnection* connection_;
  Phase phase_ = Phase::idle;
  std::uint64_t job_ = 0;
  std::array<std::uint8_t, 16> daemon_ = {};  ///< that gave it
  std::size_t bytes_ = 0;                     ///< of the running block
  std::size_t place_ = 0;                     ///< doublewords of the blocks before it
  Clock::time_point deadline_;
  Clock::time_point pause_end_;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
