#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "../slave_connection.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// CANsync_PAR_SL (M 4.13): reports the master's parameter jobs and answers them with what the program gives.
///
/// While x_EN is TRUE the block takes over parameters of the daemon; without it the daemon answers as
/// configured. What its parameter table refuses, or has of another format, does not come here, nor do
/// parameters of sub-slaves. What is asked of a parameter but its value (minimum, maximum and so on) is
/// answered with "not available" by the block. Each call shows one step of the jobs, so that x_RESET_JOB, or
/// x_READ and x_WRITE = FALSE, stand for one cycle at least between two jobs.
class CANSYNC_PUBLIC PAR_SL {
 public:
  UDINT ud_PAR_VALUE_READ = 0;     ///< value of a read; of a word its 16 bits, with or without sign
  BOOL x_PAR_FORMAT_READ = false;  ///< and its format: TRUE doubleword
  INT i_ERR = 0;                   ///< error number, for x_ERR_IN; 0: 16#FFFF, "unspecified"
  BOOL x_ERR_IN = false;           ///< the job failed; counts before x_OK_IN
  BOOL x_OK_IN = false;            ///< the job is done; looked at from the call after x_ACTIV rose on
  BOOL x_EN = false;
  BOOL x_RESET = false;

  BOOL x_RESET_JOB = false;         ///< the master cancelled or changed the job; FALSE with the next one
  BOOL x_READ = false;              ///< a read is pending
  BOOL x_WRITE = false;             ///< a write is pending
  UINT u_PAR_NR = 0;                ///< number of the job, 0..4095
  BOOL x_PAR_FORMAT_WRITE = false;  ///< format of a write: TRUE doubleword
  UDINT ud_PAR_VALUE_WRITE = 0;     ///< value of a write
  BOOL x_ACTIV = false;             ///< waits for x_OK_IN or x_ERR_IN
  BOOL x_BUSY = false;              ///< likewise, or the answer is ready and not fetched
  BOOL x_OK = false;                ///< the master has fetched the answer, also one with an error

  /// The daemon asks another program, or none yet: this one gets no jobs. Not in the manual.
  BOOL x_STANDBY = false;

  /// What could not be taken over or answered, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return error_; }

  /// `connection` must outlive the block, and has one PAR_SL at most; throws SetupError for another.
  /// `numbers`: that are taken over, 0..4095; empty: all but the daemon's status word.
  explicit PAR_SL(SlaveConnection& connection, std::vector<UINT> numbers = {});
  ~PAR_SL();
  PAR_SL(const PAR_SL&) = delete;
  PAR_SL& operator=(const PAR_SL&) = delete;

  /// One cycle. At least one a second while x_EN is TRUE, or the daemon answers without the program.
  void call();

 private:
  enum class Phase : std::uint8_t { idle, asked, answered, locked };

  void next_step();
  void answer();
  void end(bool fetched);
  void clear();
  const std::vector<UINT>& numbers();

  SlaveConnection* connection_;
  std::vector<UINT> numbers_;
  bool all_;          ///< none were given: all but the status word
  UINT without_ = 0;  ///< the status word that `numbers_` leaves out
  Phase phase_ = Phase::idle;
  std::uint64_t job_ = 0;
  std::array<std::uint8_t, 16> daemon_ = {};  ///< that gave it
  std::string error_;
};

}  // namespace cansync::client::function_blocks
