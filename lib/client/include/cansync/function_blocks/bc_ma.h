#pragma once

#include "command_slot.h"
#include "types.h"

namespace cansync::client::function_blocks {

/// What the three blocks for broadcasts have in common. Every call with x_EN = TRUE enters the command for
/// sending, so set x_EN for one cycle only. While one is on its way, the newest entered one waits for it.
class CANSYNC_PUBLIC BroadcastBlock {
 public:
  USINT us_BC_CMD_NR = 0;  ///< 1 (control word in i_BC_WORD) or 128..255; 2..127 are reserved and refused
  SINT si_BC_BYTE = 0;     ///< data byte; its 8 bits go out as they are
  INT i_BC_WORD = 0;       ///< data word, all 16 bits; us_BC_CMD_NR 1: the control word
  DWORD d_SL_MASK = 0;     ///< bit n: slave n; 16#FFFFFFFF: every slave on the bus
  BOOL x_EN = false;

  BOOL x_OK = false;  ///< the broadcast entered last was seen on the bus

  /// Who refused the one entered last and why, in words; empty without an error. Not in the manual.
  const std::string& error() const noexcept { return slot_.error(); }
  /// Why the daemon, or the block, refused it; none without a refusal. Not in the manual.
  RefusalCause cause() const noexcept { return slot_.cause(); }

  /// One cycle: enters the command when x_EN is TRUE, and takes the reply to the one before when it is there.
  void call();

 protected:
  BroadcastBlock(Client& client, std::uint32_t range) : slot_(client), range_(range) {}
  ~BroadcastBlock() = default;

 private:
  CommandSlot slot_;
  std::uint32_t range_;
};

/// CANsync_BC_MA0 (M 4.2): broadcast in transmission range 0, before everything else.
class CANSYNC_PUBLIC BC_MA0 : public BroadcastBlock {
 public:
  /// `client` must outlive the block.
  explicit BC_MA0(Client& client) : BroadcastBlock(client, 0) {}
};
/// CANsync_BC_MA1 (M 4.3): broadcast in transmission range 1.
class CANSYNC_PUBLIC BC_MA1 : public BroadcastBlock {
 public:
  /// `client` must outlive the block.
  explicit BC_MA1(Client& client) : BroadcastBlock(client, 1) {}
};
/// CANsync_BC_MA2 (M 4.4): broadcast in transmission range 2.
class CANSYNC_PUBLIC BC_MA2 : public BroadcastBlock {
 public:
  /// `client` must outlive the block.
  explicit BC_MA2(Client& client) : BroadcastBlock(client, 2) {}
};

}  // namespace cansync::client::function_blocks
