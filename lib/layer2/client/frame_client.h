#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "can/frame.h"
#include "dds/ask/request_client.h"
#include "dds/endpoint.h"
#include "dds/newest.h"
#include "layer2.h"
#include "layer2/dds/topics.h"

/// A program's side of a bus of general frames.
namespace layer2::client {

using gateway::dds::NoDaemon;
/// How to find the daemon.
using Options = gateway::dds::ClientOptions;

/// How a request ended.
struct SendResult : gateway::dds::Ended {
  std::int64_t sent_time = 0;    ///< done: CLOCK_REALTIME (ns) of the frame's last bit
  std::uint32_t sent = 0;        ///< frames of the request that were seen on the bus
  std::uint64_t job_number = 0;  ///< of OBJECT_SEND: number of the job; 0: it was not taken
  // --- of OBJECT_READ
  bool fresh = false;    ///< there was a frame, whose last bit `sent_time` is
  bool overrun = false;  ///< another one came while the object was full
  can::Frame content;    ///< what was fetched
};
using gateway::dds::Begun;

/// What a program is told that never waits; each may be empty.
struct Listener {
  std::function<void(std::uint64_t request, const SendResult& result)> ended;
  std::function<void(const layer2_FrameBatch& batch)> batch;
  std::function<void(const layer2_ObjectStatus& status)> object;
  std::function<void(const layer2_ProcessImage& image)> image;
};

/// How a frame waits to be sent.
struct SendChoice {
  bool high_priority = false;  ///< in the queue of high priority
  bool by_identifier = false;  ///< in front of those that lose the arbitration against it
  std::int64_t deadline = 0;   ///< CLOCK_REALTIME (ns), ends the monitoring time when it is earlier; 0: none
};

/// A connection to the daemon of one bus. One thread.
class FrameClient : public gateway::dds::RequestClient {
 public:
  /// Waits until a daemon serves the bus and everything is matched with it, so that nothing is lost. Throws
  /// NoDaemon when `options.wait` is over, `stop` is set or several daemons serve the bus,
  /// gateway::dds::SetupError when DDS cannot be set up.
  explicit FrameClient(const Options& options);

  /// Sends a frame and waits for the reply. `timeout_ms`: monitoring time, 0 = the daemon's default. When
  /// `stop` is set, or no reply has come 5 s after the monitoring time, the request is taken back, and the
  /// reply says whether that was in time. Without one 5 s later it gives up: the frame may have been sent, or
  /// be sent yet. A request is for the start of the daemon that this client knows: after another start the
  /// first is refused here, and every one while several daemons serve the bus.
  SendResult send(const can::Frame& frame, std::uint32_t timeout_ms, const SendChoice& choice = {});

  /// Sends frames one after the other, from one place in the queue and with one reply, as `send` does; its
  /// `sent` says how many stood on the bus. 1..64 of them.
  SendResult send(std::span<const can::Frame> frames, std::uint32_t timeout_ms,
                  const SendChoice& choice = {});

  /// Has the daemon do what `wanted` says, and waits for the reply as `send` does; `sent_time` is 0. Who asks
  /// need not stand in it.
  SendResult control(const layer2_ControlRequest& wanted);

  /// Like `send` and `control`, without waiting: `look` tells how it ended. Which daemon is asked goes by the
  /// last `look`. A daemon that has gone tells nothing more (`may_answer`). Waits at most 1 s when the daemon
  /// takes no samples.
  Begun begin_send(const can::Frame& frame, std::uint32_t timeout_ms, const SendChoice& choice = {});
  /// Of several, 1..64.
  Begun begin_send(std::span<const can::Frame> frames, std::uint32_t timeout_ms,
                   const SendChoice& choice = {});
  /// Likewise.
  Begun begin_control(const layer2_ControlRequest& wanted);
  /// Likewise; not begun while no daemon reads such requests.
  Begun begin_object(const layer2_ObjectRequest& wanted);
  /// Waits a second at most for a daemon that has message objects; older ones do not. Only while nothing is
  /// open.
  void wait_for_objects();
  /// Takes what has come, without waiting.
  void look(const Listener& listener);

  /// Has the daemon take sections of a configuration file over, all of them or nothing, until it is
  /// restarted; `reason` says the place and what is wrong. At most 131072 bytes.
  SendResult configure(std::string_view toml);

  /// Has the daemon do what `wanted` says with message objects, and waits for the reply as `send` does. Who
  /// asks need not stand in it.
  SendResult object(const layer2_ObjectRequest& wanted);

  /// What the daemon told last of its message objects that are configured, by number; none: it has told of
  /// none within `time`, which is waited for the first.
  std::vector<layer2_ObjectStatus> objects(std::chrono::milliseconds time);

  /// Waits at most `time` for events of objects and queues, and calls `on_event` for each that came. False:
  /// the daemon has gone.
  bool events(std::chrono::milliseconds time, const std::function<void(const layer2_ModuleEvent&)>& on_event);

  /// What the daemon told last of its timers that are set up, by number; none: it has told of none within
  /// `time`, which is waited for the first.
  std::vector<layer2_TimerStatus> timers(std::chrono::milliseconds time);

  /// Waits at most `time` for frames that the daemon received, and calls `on_batch` for each batch that came.
  /// False: the daemon has gone.
  bool receive(std::chrono::milliseconds time, const std::function<void(const layer2_FrameBatch&)>& on_batch);

  /// The process image as the daemon told it last, waiting at most `time` for the first, and with `fresh` for
  /// another one; nothing: none came, for there is no mapping.
  std::optional<layer2_ProcessImage> image(std::chrono::milliseconds time, bool fresh = false);

  /// What the daemon told last of its frames, waiting at most `time` for the first; nothing: none came, or the daemon
  /// has gone.
  std::optional<layer2_FrameStatus> status(std::chrono::milliseconds time);

  /// As `status`, without waiting.
  const std::optional<layer2_FrameStatus>& take_status();
  /// As `status`, of what was taken so far; takes nothing.
  const std::optional<layer2_FrameStatus>& newest_status() const noexcept { return newest_.told(); }

  /// Waits a second at most until the daemon reads what a writer writes.
  void wait_for_match(const gateway::dds::WriterBase& writer);

 private:
  /// The daemon reads requests to message objects, and answers them; or this program may not ask.
  bool objects_reached() const;
  void take_replies(const std::function<void(std::uint64_t, const SendResult&)>& ended);
  /// Waits for the result of what was begun.
  SendResult await(const Begun& begun, std::chrono::milliseconds monitoring);
  /// Keeps what a topic told last of each number, waiting at most `time` for the first and, when some came,
  /// until no more come.
  template <class Status>
  void keep_newest(gateway::dds::Reader<Status>& reader, std::map<unsigned, Status>& newest,
                   std::chrono::milliseconds time);
  /// As `wait_until`, taking the replies too.
  template <class Came>
  bool look_until(std::chrono::milliseconds time, Came&& came);
  std::chrono::milliseconds monitoring_of(std::uint32_t timeout_ms) const;

  gateway::dds::Reader<layer2_SendReply> replies_;
  gateway::dds::Reader<layer2_ControlReply> control_replies_;
  gateway::dds::Reader<layer2_ObjectReply> object_replies_;
  gateway::dds::Reader<layer2_FrameBatch> batches_;
  gateway::dds::Reader<layer2_FrameStatus> status_;
  gateway::dds::Reader<layer2_TimerStatus> timer_status_;
  gateway::dds::Reader<layer2_ObjectStatus> object_status_;
  gateway::dds::Reader<layer2_ProcessImage> image_reader_;
  std::unique_ptr<gateway::dds::Reader<layer2_ModuleEvent>> events_;  ///< from the first `events` on
  gateway::dds::Writer<layer2_SendRequest> requests_;
  gateway::dds::Writer<layer2_ControlRequest> controls_;
  gateway::dds::Writer<layer2_ObjectRequest> object_requests_;
  gateway::dds::Writer<gateway_JobCancel> cancels_;
  gateway::dds::Newest<layer2_FrameStatus> newest_;
  std::map<unsigned, layer2_TimerStatus> timers_;
  std::map<unsigned, layer2_ObjectStatus> objects_;
  std::optional<layer2_ProcessImage> image_;
};

}  // namespace layer2::client
