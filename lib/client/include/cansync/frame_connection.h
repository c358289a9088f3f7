#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "client.h"

namespace cansync::client {

namespace detail {
class FrameSide;
}  // namespace detail

/// Bits of the identifiers of a project: the blocks of a CAN 300 PRO have one width.
enum class IdentifierWidth : std::uint8_t { bits_11, bits_29 };

/// What a routine for interrupts is told (Saia 4.2.2 to 4.2.4): the local data of the organisation block.
struct Interrupt {
  std::uint16_t parameter = 0;  ///< RxIntPrm or TxIntPrm
  std::int16_t object = 0;      ///< message object; of the queues 30 (receive) and 31 (send)
  std::int16_t port = 0;        ///< always 0
};

/// A connection to a daemon of general CAN frames (bus.protocol = "layer2"), for the function blocks of
/// layer 2. It and its blocks belong to one thread; each call of a block takes what has come and hands on
/// what waits.
class CANSYNC_PUBLIC FrameConnection {
 public:
  /// Waits until a daemon serves the bus. Of `options`, `grace` and `requests` mean nothing here.
  /// Throws NoDaemon when `options.wait` is over or several daemons serve the bus, SetupError when DDS cannot
  /// be set up.
  static FrameConnection connect(const Options& options);

  /// The one moved from has no connection any more; its blocks must be gone by then.
  FrameConnection(FrameConnection&& other) noexcept;
  /// Likewise; ends the connection there was.
  FrameConnection& operator=(FrameConnection&& other) noexcept;
  /// Ends the mapping that SFB 413 has set up, too, as the end of its program does (Saia 3.4); waits for the daemon, 0.5 s at most.
  ~FrameConnection();

  /// A daemon serves the bus now.
  bool daemon_present() const;

  /// In the place of organisation block `number`, 40..47: `routine` is called within the call of a block, on
  /// the connection's thread, and must not call blocks of it. An empty one takes it away; of other numbers
  /// none is ever called.
  void on_interrupt(int number, std::function<void(const Interrupt&)> routine);

  /// Data block `number` is loaded from now on, in place of the one before: SFB 402 and 413 read their tables
  /// in it. Bytes as in the PLC, the high one first; `data_block` makes them
  /// (function_blocks/layer2/data_blocks.h).
  void load_data_block(int number, std::vector<std::uint8_t> bytes);

  /// What came by the process image (Saia 3.4), as the daemon told it last, every 10 ms at most. Each call of
  /// a block takes it: between two calls it stays as it is.
  std::span<const std::uint8_t, 1024> inputs() const noexcept;
  /// Writes bytes of the process image that is sent, `address` 0..1023, after SFB 413 has set up a mapping.
  /// Between two telegrams all of them are in the image or none; those never written are 0. Nothing is sent before the
  /// first call. While the connection lives it owns the image, if no stronger writer does. Returns why nothing was
  /// written; empty: it was handed to DDS.
  std::string write_outputs(std::uint16_t address, std::span<const std::uint8_t> bytes);

  /// The library's own, for its function blocks.
  detail::FrameSide& side() noexcept { return *side_; }

 private:
  explicit FrameConnection(std::unique_ptr<detail::FrameSide> side) noexcept;

  std::unique_ptr<detail::FrameSide> side_;
};

}  // namespace cansync::client
