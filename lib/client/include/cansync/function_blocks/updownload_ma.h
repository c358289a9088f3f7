#pragma once

#include <optional>
#include <string>

#include "../client.h"
#include "enable.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// Bits of `b_ERR` of UPDOWNLOAD_MA (M 4.24).
namespace transfer_error {
inline constexpr BYTE slave = 0x01;  ///< w_ERR_SL has the slave's error, else `error()` says what
inline constexpr BYTE length_zero = 0x02;
inline constexpr BYTE timeout = 0x04;
}  // namespace transfer_error

/// CANsync_UPDOWNLOAD_MA (M 4.24): uploads or downloads up to 2048 doublewords, in blocks as long as the
/// daemon knows the slave to take them (`slaves[].block_limit`, 75 doublewords by default).
///
/// Here the caller gives the start address, because the one that UPDOWNLOAD_SL expects is not in the manual.
/// The block repeats the job (not only the block that failed) when the slave did not answer in time, until
/// us_MAX_NR_OF_COMM attempts or us_MAX_NR_OF_COMM * t_TIME are over. A refusal that passes soon (`retry`),
/// as of a full queue, is asked again every 100 ms within that time and is no attempt. What is not the
/// slave's error, such as any other refusal of the daemon, is b_ERR bit 0 with w_ERR_SL = 0; so is an upload
/// that the slave made shorter: u_RECEIVED says how much of a_UPLOAD is new.
class CANSYNC_PUBLIC UPDOWNLOAD_MA {
 public:
  CANsync_UPDOWN_BMARRAY a_DOWNLOAD = {};
  CANsync_UPDOWN_BMARRAY a_UPLOAD = {};
  SINT si_SL_NR = 0;            ///< 0..31
  BOOL x_UPDOWN = false;        ///< FALSE: upload, TRUE: download
  UINT u_LENGTH = 0;            ///< doublewords, 1..2048; more counts as 2048
  USINT us_MAX_NR_OF_COMM = 1;  ///< attempts; 0 counts as 1
  TIME t_TIME{30000};           ///< monitoring time of one attempt, 1 ms .. 24 days
  BOOL x_EN = false;
  BOOL x_RESET = false;
  UDINT ud_ADDRESS = 0x100;  ///< start address, 0x100 and more. Not in the manual

  BOOL x_BUSY = false;
  WORD w_ERR_SL = 0;  ///< the slave's error number
  BOOL x_ERR_SL = false;
  BYTE b_ERR = 0;  ///< bits of `transfer_error`
  BOOL x_ERR = false;
  BOOL x_OK = false;
  UINT u_RECEIVED = 0;  ///< doublewords that an upload has entered in a_UPLOAD. Not in the manual

  /// Who refused and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return error_; }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return cause_; }

  /// `client` must outlive the block.
  explicit UPDOWNLOAD_MA(Client& client) : client_(&client) {}
  UPDOWNLOAD_MA(const UPDOWNLOAD_MA&) = delete;
  UPDOWNLOAD_MA& operator=(const UPDOWNLOAD_MA&) = delete;

  /// One cycle: begins, follows or gives up the job, and fills a_UPLOAD when an upload is done. `now` counts
  /// t_TIME.
  void call(Clock::time_point now = Clock::now());

 private:
  void start(Clock::time_point now);
  void attempt();
  void proceed(Clock::time_point now);
  void take(const TransferReply& reply, Clock::time_point now);
  void submit();
  void fail(BYTE bits, WORD number, std::string reason, RefusalCause cause = RefusalCause::none);
  void give_up();
  void clear();

  Client* client_;
  Enable enable_;
  TransferRequest request_;
  std::optional<TransferJob> job_;
  unsigned attempts_left_ = 0;
  Clock::time_point deadline_;
  std::optional<Clock::time_point> again_;  ///< when a refused job is asked for again
  RefusalCause cause_ = RefusalCause::none;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
