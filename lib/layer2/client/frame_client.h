#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "can/frame.h"
#include "dds/daemon_identity.h"
#include "dds/daemon_sight.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "layer2.h"
#include "layer2/dds/topics.h"

/// A program's side of a bus of general frames.
namespace layer2::client {

using gateway::dds::NoDaemon;
/// How to find the daemon.
using Options = gateway::dds::ClientOptions;

/// How a request to send ended.
struct SendResult {
  bool replied = false;  ///< false: the daemon went away, or did not answer; `code` says nothing then
  gateway_ReplyCode code = gateway_REPLY_DONE;
  gateway_RefusalCause cause = gateway_CAUSE_NONE;  ///< of REPLY_REFUSED
  std::string reason;                               ///< empty when done
  std::int64_t sent_time = 0;                       ///< done: CLOCK_REALTIME (ns) of the frame's last bit
  std::uint32_t sent = 0;                           ///< frames of the request that were seen on the bus
  // --- of OBJECT_READ
  bool fresh = false;    ///< there was a frame, whose last bit `sent_time` is
  bool overrun = false;  ///< another one came while the object was full
  can::Frame content;    ///< what was fetched
};

/// A request that was begun; its result comes to a `Listener`.
struct Begun {
  std::uint64_t request = 0;            ///< its number; 0: it was not written
  std::optional<SendResult> not_begun;  ///< why it was not written
};

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
class FrameClient {
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
  /// May the result of a request to this start of the daemon still come? Whoever hears that it may not is
  /// taken to know that the daemon has gone.
  bool may_answer(const gateway::dds::DaemonIdentity& daemon);

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

  /// Which daemon serves the bus, as it told last; it is told once a second, and taken by every function
  /// here.
  const gateway_GatewayStatus& gateway_status() const noexcept { return *sight_.newest(); }

  /// The process image as the daemon told it last, waiting at most `time` for the first, and with `fresh` for
  /// another one; nothing: none came, for there is no mapping.
  std::optional<layer2_ProcessImage> image(std::chrono::milliseconds time, bool fresh = false);

  /// What the daemon told last of its frames, waiting at most `time` for the first; nothing: none came.
  std::optional<layer2_FrameStatus> status(std::chrono::milliseconds time);

  /// As `status`, of what was taken so far; takes nothing.
  const std::optional<layer2_FrameStatus>& newest_status() const noexcept { return newest_; }
  /// What the daemon told last of the controller and its interface; nothing: it was not told yet. Looks
  /// without waiting.
  const std::optional<gateway_BusStatus>& bus_status();

  /// A daemon serves the bus now.
  bool daemon_present() const noexcept { return replies_.matched() != 0; }

  /// For writers of topics of their own.
  const gateway::dds::Participant& participant() const noexcept { return participant_; }
  /// As this program names itself.
  const std::string& name() const noexcept { return options_.client_name; }
  /// Waits a second at most until the daemon reads what a writer writes.
  void wait_for_match(const gateway::dds::WriterBase& writer);

  /// Where the daemon was looked for, for messages.
  std::string place() const { return participant_.place(); }

 private:
  /// The daemon reads requests to message objects, and answers them; or this program may not ask.
  bool objects_reached() const;
  /// Why no request may be sent now, with its code; nothing: one may.
  std::optional<SendResult> obstacle();
  std::optional<SendResult> take_reply(std::uint64_t request);
  void take_replies(const std::function<void(std::uint64_t, const SendResult&)>& ended);
  void cancel(std::uint64_t request, const gateway::dds::DaemonIdentity& daemon);
  /// Gives the request who asks and its number, and writes it.
  template <class Request>
  Begun begin(gateway::dds::Writer<Request>& writer, Request request);
  /// Waits for the result of what was begun.
  SendResult await(const Begun& begun, std::chrono::milliseconds monitoring);
  /// Keeps what a topic told last of each number, waiting at most `time` for the first and, when some came,
  /// until no more come.
  template <class Status>
  void keep_newest(gateway::dds::Reader<Status>& reader, std::map<unsigned, Status>& newest,
                   std::chrono::milliseconds time);
  /// Waits until `ready()`, the time is over, or the daemon has gone.
  template <class Ready>
  void wait_until(std::chrono::milliseconds time, Ready&& ready);
  std::chrono::milliseconds monitoring_of(std::uint32_t timeout_ms) const;

  Options options_;
  std::array<std::uint8_t, 16> identity_;
  gateway::dds::Participant participant_;
  gateway::dds::DataSignal signal_;
  gateway::dds::Reader<layer2_SendReply> replies_;
  gateway::dds::Reader<layer2_ControlReply> control_replies_;
  gateway::dds::Reader<layer2_ObjectReply> object_replies_;
  gateway::dds::Reader<layer2_FrameBatch> batches_;
  gateway::dds::Reader<layer2_FrameStatus> status_;
  gateway::dds::Reader<layer2_TimerStatus> timer_status_;
  gateway::dds::Reader<layer2_ObjectStatus> object_status_;
  gateway::dds::Reader<layer2_ProcessImage> image_reader_;
  std::unique_ptr<gateway::dds::Reader<layer2_ModuleEvent>> events_;  ///< from the first `events` on
  gateway::dds::Reader<gateway_BusStatus> bus_reader_;
  gateway::dds::DaemonSight sight_;
  gateway::dds::Writer<layer2_SendRequest> requests_;
  gateway::dds::Writer<layer2_ControlRequest> controls_;
  gateway::dds::Writer<layer2_ObjectRequest> object_requests_;
  gateway::dds::Writer<gateway_JobCancel> cancels_;
  std::uint64_t number_ = 0;  ///< of the last request
  std::optional<layer2_FrameStatus> newest_;
  std::map<unsigned, layer2_TimerStatus> timers_;
  std::optional<gateway_BusStatus> bus_;
  std::map<unsigned, layer2_ObjectStatus> objects_;
  std::optional<layer2_ProcessImage> image_;
};

}  // namespace layer2::client
