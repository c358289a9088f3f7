#pragma once

#include <cansync/client.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "client/src/layer2/module_queues.h"
#include "client/src/open_requests.h"
#include "j1939/client/message_client.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// What a connection to the daemon of a bus of J1939 has told so far, and what its function blocks send. One
/// thread.
class MessageSide {
 public:
  /// A frame with its identifier and up to 8 bytes.
  struct Frame {
    std::uint32_t identifier = 0;
    std::array<std::uint8_t, 8> bytes = {};
    std::uint8_t length = 0;
  };

  /// Waits for the daemon and what it is as a node. Throws as MessageConnection::connect.
  explicit MessageSide(const Options& options);

  /// Takes what has come, and hands on what waits. Never waits for an answer.
  void look();

  /// Why nothing can be sent now; empty: it can.
  std::string obstacle();
  /// Why nothing comes; empty: what comes is received.
  std::string silence();
  /// The daemon's address; nothing: it has none.
  std::optional<std::uint8_t> address();
  /// STAT (Helmholz 7.2.5).
  std::uint16_t status_word();
  /// True once after another daemon came.
  bool take_restart() noexcept { return std::exchange(restarted_, false); }

  ModuleQueues<Frame>& queues() noexcept { return queues_; }
  j1939::client::MessageClient& client() noexcept { return client_; }
  /// A daemon is there, and has told of itself as a node.
  bool daemon_present() const noexcept {
    return client_.daemon_present() && client_.newest_status().has_value();
  }
  /// Why the frame that failed last was not sent; empty: none has.
  const std::string& failure() const noexcept { return failure_; }
  /// Frames that were taken and are known not to have been sent whole.
  std::uint32_t failures() const noexcept { return failures_; }

 private:
  std::string_view claim() const;
  void note(const j1939_MessageBatch& batch);
  bool begin(const Frame& frame);

  j1939::client::MessageClient client_;
  OpenRequests<j1939::client::MessageClient, j1939::client::Result> open_;
  ModuleQueues<Frame> queues_;
  std::uint64_t batch_ = 0;
  std::uint64_t lost_ = 0;
  bool restarted_ = false;
  std::string failure_;
  std::uint32_t failures_ = 0;
};

}  // namespace cansync::client::detail
