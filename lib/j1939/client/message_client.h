#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "dds/ask/request_client.h"
#include "dds/endpoint.h"
#include "dds/newest.h"
#include "j1939.h"
#include "j1939/dds/topics.h"

/// A program's side of a bus of J1939.
namespace j1939::client {

using gateway::dds::NoDaemon;
/// How to find the daemon.
using Options = gateway::dds::ClientOptions;

/// What is sent, or asked for.
struct Message {
  std::uint32_t pgn = 0;           ///< 0..0x3FFFF
  std::uint8_t priority = 6;       ///< 0..7
  std::uint8_t destination = 255;  ///< 0..253, or 255: all
  std::vector<std::uint8_t> data;  ///< 0..1048576 bytes; none when a group is asked for
};

/// How a request ended.
struct Result : gateway::dds::Ended {
  std::int64_t sent_time = 0;      ///< done: CLOCK_REALTIME (ns)
  std::uint8_t answer_code = 0;    ///< of REPLY_SLAVE_ERROR
  std::vector<std::uint8_t> data;  ///< of the answer
};
using gateway::dds::Begun;

/// What a program is told that never waits; each may be empty.
struct Listener {
  std::function<void(std::uint64_t request, const Result& result)> ended;
  std::function<void(const j1939_MessageBatch& batch)> batch;
};

/// The faults that a node tells of.
struct Faults {
  j1939_FaultList list = {};             ///< its `codes` are empty
  std::vector<j1939_TroubleCode> codes;  ///< in the order of the message
};

/// A connection to the daemon of one bus. One thread.
class MessageClient : public gateway::dds::RequestClient {
 public:
  /// Waits until a daemon serves the bus and everything is matched with it, so that nothing is lost. Throws
  /// NoDaemon when `options.wait` is over, `stop` is set or several daemons serve the bus,
  /// gateway::dds::SetupError when DDS cannot be set up.
  explicit MessageClient(const Options& options);

  /// Sends a message (MESSAGE_SEND) or asks for a group (MESSAGE_ASK), and waits for the reply. `timeout_ms`:
  /// monitoring time, 0 = the daemon's default. When `stop` is set, or no reply has come 5 s after the
  /// monitoring time (asking one node, 4 min: its answer may be coming in packets), the request is taken back,
  /// and the reply says whether that was in time.
  Result request(j1939_MessageKind kind, const Message& message, std::uint32_t timeout_ms);

  /// Like `request`, without waiting: `look` tells how it ended. Which daemon is asked goes by the last
  /// `look`. A daemon that has gone tells nothing more
  /// (`may_answer`). Waits at most 1 s when the daemon takes no samples.
  Begun begin(j1939_MessageKind kind, const Message& message, std::uint32_t timeout_ms);
  /// Takes what has come, without waiting.
  void look(const Listener& listener);

  /// Waits at most `time` for messages that the daemon received, and calls `on_batch` for each batch that
  /// came, `on_long` for each message of over 1785 bytes. False: the daemon has gone.
  bool receive(std::chrono::milliseconds time, const std::function<void(const j1939_MessageBatch&)>& on_batch,
               const std::function<void(const j1939_LongMessage&)>& on_long = {});

  /// What the daemon told last of itself as a node, waiting at most `time` for the first; nothing: none came, or the
  /// daemon has gone. So do the next ones.
  std::optional<j1939_NodeStatus> status(std::chrono::milliseconds time);
  /// As `status`, of what was taken so far; takes nothing.
  const std::optional<j1939_NodeStatus>& newest_status() const noexcept { return newest_.told(); }
  /// The addresses that were claimed, rising; waits as `status`. Nothing: none were told.
  std::optional<std::vector<j1939_ClaimedAddress>> addresses(std::chrono::milliseconds time);
  /// The faults told of so far, by source, and whether they are active; looks for `time`.
  const std::map<std::pair<std::uint8_t, bool>, Faults>& faults(std::chrono::milliseconds time);

 private:
  bool matched() const noexcept;
  void take_replies(const std::function<void(std::uint64_t, const Result&)>& ended);
  /// Takes all but the messages.
  void take_state();
  /// Takes everything until `there`, the daemon has gone, or `time` is over.
  void look_until(std::chrono::milliseconds time, const std::function<bool()>& there);

  gateway::dds::Reader<j1939_MessageReply> replies_;
  gateway::dds::Reader<j1939_MessageBatch> batches_;
  gateway::dds::Reader<j1939_LongMessage> long_messages_;
  gateway::dds::Reader<j1939_NodeStatus> status_;
  gateway::dds::Reader<j1939_AddressTable> tables_;
  gateway::dds::Reader<j1939_FaultList> faults_;
  gateway::dds::Writer<j1939_MessageRequest> requests_;
  gateway::dds::Writer<gateway_JobCancel> cancels_;
  gateway::dds::Newest<j1939_NodeStatus> newest_;
  std::optional<std::vector<j1939_ClaimedAddress>> addresses_;
  std::map<std::pair<std::uint8_t, bool>, Faults> told_;
};

}  // namespace j1939::client
