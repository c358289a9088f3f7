#pragma once

#include <memory>

#include "client.h"

namespace cansync::client {

namespace detail {
class MessageSide;
}  // namespace detail

/// A connection to a daemon that is a node of SAE J1939 (bus.protocol = "j1939"), for the function blocks of
/// that. It and its blocks belong to one thread; each call of a block takes what has come and hands on what
/// waits.
class CANSYNC_PUBLIC MessageConnection {
 public:
  /// Waits until a daemon serves the bus. Of `options`, `grace` and `requests` mean nothing here.
  /// Throws NoDaemon when `options.wait` is over or several daemons serve the bus, SetupError when DDS cannot
  /// be set up.
  static MessageConnection connect(const Options& options);

  /// The one moved from has no connection any more; its blocks must be gone by then.
  MessageConnection(MessageConnection&& other) noexcept;
  /// Likewise; ends the connection there was.
  MessageConnection& operator=(MessageConnection&& other) noexcept;
  ~MessageConnection();

  /// A daemon serves the bus now.
  bool daemon_present() const;

  /// The library's own, for its function blocks.
  detail::MessageSide& side() noexcept { return *side_; }

 private:
  explicit MessageConnection(std::unique_ptr<detail::MessageSide> side) noexcept;

  std::unique_ptr<detail::MessageSide> side_;
};

}  // namespace cansync::client
