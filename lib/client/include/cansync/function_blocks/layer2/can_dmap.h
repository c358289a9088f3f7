#pragma once

#include <memory>
#include <string>

#include "../../frame_connection.h"
#include "../types.h"

namespace cansync::client::function_blocks {

class BlockTable;

/// SFB 413 CAN_DMAP (Saia 4.2.4, also CFG_IO): sets up the data mapping of the daemon, in place of the one
/// there was; FrameConnection::inputs and write_outputs are its process image.
///
/// The daemon's answer comes later (`open`, `error`). RetVal: 0000 the daemon was asked; 80A0 no daemon is
/// there, or CAN_CFG was not called; 80A1 the request could not be written; 80C3 over 512 entries, or 128
/// telegrams of a direction; 8187 PortID; 8189 an entry that cannot be: identifier, offset and size, a byte
/// mapped twice; 8190 NbEntries, TxTime, MsgID, or the version of the block; 8192 VA is taken, or outside the
/// image; 8F33 DBNr, or it is not loaded.
class CANSYNC_PUBLIC CAN_DMAP {
 public:
  INT PortID = 0;         ///< 0
  INT DBNr = 0;           ///< 1..32767: FrameConnection::load_data_block
  INT NbEntries = 0;      ///< entries of the table; 0 ends the mapping
  INT TxTime = 0;         ///< ms between two times of sending, at least 1; without outputs not looked at
  DWORD MsgID = 0;        ///< with Mask: identifiers of the telegrams that are received
  DWORD Mask = 0;         ///< bits of MsgID that count; 0: every identifier
  BOOL IDE = false;       ///< FALSE 11 bits, TRUE 29; of all telegrams
  BOOL TxChange = false;  ///< TRUE: after the first time only telegrams that have changed are sent
  WORD RetVal = 0;        ///< of this call

  /// Calls that the daemon has not answered yet; a call of any block takes answers. Not in the manual.
  UINT open() const noexcept;
  /// What RetVal means here, or what the daemon has refused last; empty: nothing is wrong. Not in the manual.
  const std::string& error() const noexcept;

  /// `connection` must outlive the block.
  explicit CAN_DMAP(FrameConnection& connection);
  ~CAN_DMAP();
  CAN_DMAP(const CAN_DMAP&) = delete;
  CAN_DMAP& operator=(const CAN_DMAP&) = delete;

  /// Does it once.
  void call();

 private:
  struct Asked;
  WORD configure();
  WORD map(const BlockTable& table);
  WORD ask(const std::string& sections, bool mapped);
  WORD refuse(WORD code, std::string reason);

  FrameConnection* connection_;
  std::shared_ptr<Asked> asked_;  ///< shared with the answers that have not come
};

}  // namespace cansync::client::function_blocks
