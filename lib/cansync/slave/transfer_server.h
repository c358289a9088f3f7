#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "cansync/slave/block_phase.h"
#include "cansync/slave/slave_application.h"
#include "cansync/telegram/errors.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// A slave's uploads and downloads, a block at a time (M 3.2.1.3, "Start of an upload or download" and following). A telegram
/// that was answered well and comes again gets the same answer. Realtime safe; one thread.
class TransferServer {
 public:
  /// What a telegram is answered.
  struct Answer {
    can::Frame frame;
    bool busy = false;  ///< the master sends the same telegram again
  };

  /// Of the slave with this number; a block has at most `block_limit` bytes, 1..4095. `application` must outlive the server.
  TransferServer(SlaveNumber number, std::uint16_t block_limit, SlaveApplication& application) noexcept
      : number_(number), block_limit_(block_limit), application_(application) {}

  /// Answers a telegram to this slave: TransferInitialise, UploadBlock or DownloadBlock.
  template <class Command>
  Answer serve(const Command& command) noexcept;
  /// The newest answer, other than busy, was on the bus.
  void answered() noexcept;
  /// The slave leaves synchronous operation: what is open is dropped.
  void stop() noexcept;
  /// True while an upload or download block is open.
  bool open() const noexcept { return block_.phase == BlockPhase::open; }

 private:
  struct Block {
    BlockPhase phase = BlockPhase::none;
    TransferInitialise initialise;
    std::uint16_t length = 0;
    std::uint16_t expected = 0;  ///< next offset
  };

  void enter(BlockEvent event) noexcept;
  template <class Command>
  bool is_answered(const Command& command) noexcept;
  TransferReply answer(const TransferInitialise& initialise) noexcept;
  TransferReply answer(const UploadBlock& block) noexcept;
  TransferReply answer(const DownloadBlock& block) noexcept;
  TransferError check_length(const TransferInitialise& initialise) const noexcept;
  TransferError check_order(TransferInitialise::Direction direction, BlockOffset offset,
                            bool last) const noexcept;
  /// The reply to a block telegram with the application's answer; moves on to the next block.
  TransferReply block_done(BlockOffset offset, bool last,
                           const SlaveApplication::BlockAnswer& answer) noexcept;
  TransferReply refuse(BlockOffset offset, TransferError error) const noexcept;
  void drop() noexcept;
  void drop_last_answer() noexcept;
  std::size_t bytes_due() const noexcept;

  SlaveNumber number_;
  std::uint16_t block_limit_;
  SlaveApplication& application_;
  Block block_;
  bool ending_ = false;               ///< the last answer to a complete block was not on the bus yet
  std::optional<Telegram> answered_;  ///< telegram answered last, without busy or error
  can::Frame last_answer_;            ///< its answer
};

}  // namespace cansync
