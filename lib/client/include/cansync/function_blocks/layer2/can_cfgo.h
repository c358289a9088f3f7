#pragma once

#include <memory>
#include <string>
#include <vector>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

/// SFB 402 CAN_CFGO (Saia 4.2.2): sets up message objects, anew with each call, all that it names or none.
///
/// The daemon's answer comes later (`open`, `error`); what it refuses is not set up: SFB 400 and 401 say
/// 80C0. RetVal: 0000 the daemon was asked; 80A0 no daemon is there, or CAN_CFG was not called; 80C0 ObjID
/// belongs to the mapping (28, 29) or to the queues (30, 31); 8186 ObjID or MsgID; 8187 PortID; 8190 Offset
/// and NbObj, the version of the block, Timeout, or EnableInt without a routine of CAN_CFG; 8F33 DBNr; 8F3A
/// it is not loaded.
class CANSYNC_PUBLIC CAN_CFGO {
 public:
  INT PortID = 0;   ///< 0
  INT DBNr = 0;     ///< 1..32767: FrameConnection::load_data_block
  INT Offset = 0;   ///< first entry of the table, from 0
  INT NbObj = 0;    ///< entries from there, at least 1
  WORD RetVal = 0;  ///< of this call

  /// Calls that the daemon has not answered yet; a call of any block takes answers. Not in the manual.
  UINT open() const noexcept;
  /// What RetVal means here, or what the daemon has refused last; empty: nothing is wrong. Not in the manual.
  const std::string& error() const noexcept;

  /// `connection` must outlive the block.
  explicit CAN_CFGO(FrameConnection& connection);
  ~CAN_CFGO();
  CAN_CFGO(const CAN_CFGO&) = delete;
  CAN_CFGO& operator=(const CAN_CFGO&) = delete;

  /// Does it once.
  void call();

 private:
  struct Asked;
  WORD configure();
  WORD refuse(WORD code, std::string reason);

  FrameConnection* connection_;
  std::shared_ptr<Asked> asked_;  ///< shared with the answers that have not come
};

}  // namespace cansync::client::function_blocks
