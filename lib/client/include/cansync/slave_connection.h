#pragma once

#include <memory>

#include "client.h"

namespace cansync::client {

namespace detail {
struct BlockStep;
class SlaveSide;
}  // namespace detail

/// A connection to a daemon that is a slave of CANsync (bus.protocol = "cansync-slave"), for the function
/// blocks of a slave. It and its blocks belong to one thread; each call of a block takes what has come.
class CANSYNC_PUBLIC SlaveConnection {
 public:
  /// Waits until a daemon serves the bus. Of `options`, `grace` and `requests` mean nothing here.
  /// Throws NoDaemon when `options.wait` is over or several daemons serve the bus, SetupError when DDS cannot
  /// be set up.
  static SlaveConnection connect(const Options& options);

  /// The one moved from has no connection any more; its blocks must be gone by then.
  SlaveConnection(SlaveConnection&& other) noexcept;
  /// Likewise; ends the connection there was.
  SlaveConnection& operator=(SlaveConnection&& other) noexcept;
  ~SlaveConnection();

  /// A daemon serves the bus now.
  bool daemon_present() const;

  /// The library's own, for its function blocks.
  detail::SlaveSide& side() noexcept { return *side_; }

 private:
  explicit SlaveConnection(std::unique_ptr<detail::SlaveSide> side) noexcept;

  std::unique_ptr<detail::SlaveSide> side_;
};

}  // namespace cansync::client
