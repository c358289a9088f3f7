#pragma once

#include <optional>
#include <string>

#include "../client.h"
#include "enable.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// Bits of `b_ERR` of the blocks for parameters (M 4.12, 4.14).
namespace parameter_error {
inline constexpr BYTE communication = 0x01;  ///< the slave's error is in i_ERR, else `error()` says what
inline constexpr BYTE timeout = 0x02;        ///< no answer, also of a slave that is lost
inline constexpr BYTE doubleword_expected = 0x04;  ///< reading only
inline constexpr BYTE word_expected = 0x08;        ///< reading only
inline constexpr BYTE invalid_slave = 0x10;        ///< not 0..31, or not configured
}  // namespace parameter_error

/// What PAR_READ_MA and PAR_WRITE_MA have in common.
///
/// Unlike in the option module the monitoring time counts from the call that starts the job, and in the
/// daemon from the moment the job is the first of its slave; whichever is over first ends it. An error that
/// is not the slave's (the daemon refused, nobody there) is b_ERR bit 0 with i_ERR = 0.
class CANSYNC_PUBLIC ParameterBlock {
 public:
  SINT si_SL_NR = 0;          ///< 0..31
  UINT u_PAR_NR = 0;          ///< 0..4095
  BOOL x_PAR_FORMAT = false;  ///< FALSE: word, TRUE: doubleword
  INT i_SUB_SL = 0;           ///< sub-slave address; reserved in the manual, 0: the slave itself
  TIME t_TIME{3000};          ///< monitoring time, 1 ms .. 24 days
  BOOL x_EN = false;
  BOOL x_RESET = false;

  BOOL x_BUSY = false;
  BYTE b_ERR = 0;  ///< bits of `parameter_error`
  INT i_ERR = 0;   ///< the slave's error number; 0: none
  BOOL x_ERR = false;
  BOOL x_OK = false;

  /// Who refused and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return error_; }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return cause_; }

  ParameterBlock(const ParameterBlock&) = delete;
  ParameterBlock& operator=(const ParameterBlock&) = delete;

 protected:
  explicit ParameterBlock(Client& client) : client_(&client) {}
  ~ParameterBlock() = default;

  /// One cycle. The reply when the job has ended well in this one.
  std::optional<ParameterReply> step(bool write, UDINT value, Clock::time_point now);

 private:
  void start(bool write, UDINT value, Clock::time_point now);
  std::optional<ParameterReply> proceed(Clock::time_point now);
  void fail(BYTE bits, INT number, std::string reason, RefusalCause cause = RefusalCause::none);
  void take_error(const ParameterReply& reply);
  void give_up();
  void clear();

  Client* client_;
  Enable enable_;
  bool write_ = false;
  std::optional<ParameterJob> job_;
  Clock::time_point deadline_;
  RefusalCause cause_ = RefusalCause::none;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
