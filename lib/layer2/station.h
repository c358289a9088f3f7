#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "can/bounded_list.h"
#include "can/frame.h"
#include "can/job_ending.h"
#include "can/obstacle.h"
#include "layer2/bounded_queue.h"
#include "layer2/range_filter.h"
#include "layer2/timers.h"

namespace layer2 {

/// By which a send order is answered; chosen by whoever gives it.
using OrderId = std::uint64_t;

/// Sizes of a station.
struct StationSettings {
  std::uint16_t queue = 400;  ///< orders of normal priority that may wait to be handed over, 1..kMostQueue
  std::uint16_t high_queue = 20;                ///< likewise, of high priority
  Overflow overflow = Overflow::refuse_newest;  ///< of a queue that is full
  RangeFilter filter;
  std::optional<NodeFilter> node;  ///< in place of the ranges
};

/// The queue that a frame waits in.
enum class Priority : std::uint8_t {
  normal,
  high,  ///< goes before every one of normal priority
};

/// Where in its queue an order is put.
enum class Placing : std::uint8_t {
  last,
  /// In front of the first whose identifier loses the arbitration against its own, but not in front of the
  /// first one (Saia 4.2.3).
  by_identifier,
};

/// A frame to be sent.
struct SendOrder {
  OrderId id = 0;
  can::Frame frame;
  Time timeout{};  ///< monitoring time from `submit` until the frame stands on the bus; 0 or less: too late
  Priority priority = Priority::normal;
  Placing placing = Placing::last;
  /// Frames sent after `frame`, in this order, at most kMostFollowing; memory of who gives the order, until
  /// it is answered. They have one place in the queue, and one answer.
  std::span<const can::Frame> following = {};

  static constexpr std::size_t kMostFollowing = 63;
};

/// Whose frame an own one is.
enum class Sender : std::uint8_t { order, timer, script, object, mapping };

/// An own frame that stood on the bus.
struct OwnFrame {
  Sender sender = Sender::order;
  std::uint8_t number = 0;    ///< of the timer, object or telegram; else 0
  std::uint32_t handing = 0;  ///< of an object: what `MessageObjects::handed_over` said
};

/// Why an order is not taken; nothing was sent.
enum class Refusal : std::uint8_t {
  none,
  queue_full,        ///< as many orders are open as there is room for: try again when one has been answered
  too_late,          ///< its deadline has passed
  bad_frame,         ///< no frame that can be sent: identifier or length too large, or an error frame
  stopped,           ///< the station has been stopped
  not_running,       ///< the module is in stop
  not_led,           ///< run and stop follow a program that is not there or says stop
  no_timer,          ///< there is no such timer, or it was not given what it sends
  bus_full,          ///< the bus cannot carry a timer beside the others and the process image
  no_image,          ///< there is no process image, or not at that address
  image_owned,       ///< the process image belongs to another program, or is another one by now
  not_permitted,     ///< the controller cannot be reset: a right of the system is missing
  no_controller,     ///< likewise: the interface is missing or down, or its driver cannot
  queue_in_use,      ///< more waits in a queue than there would be room for
  script_under_way,  ///< a script that is to be replaced has not ended
  reset_under_way,   ///< likewise: it is being reset
  object_reserved,   ///< the message object belongs to another service
  object_direction,  ///< it receives, or sends, or is not configured
  object_pending,    ///< it has a job that has not ended, or a frame that asks
  object_frame,      ///< the frame is of another width than the object, or no data frame
};

using can::JobEnd;
using can::JobKnown;
using can::Obstacle;

/// How an order ended.
enum class Outcome : std::uint8_t {
  done,       ///< the frame stood on the bus; of several all
  no_answer,  ///< handed over, but not seen on the bus in time: it may have been sent, or be sent yet; of
              ///< several one of them
  timeout,    ///< not handed over in time; it will not be sent
  cancelled,  ///< taken back before it was handed over; it will not be sent
  stopped,    ///< the station was stopped before it was handed over; it will not be sent
  displaced,  ///< deleted for a newer one, because the queue was full; it will not be sent
  deleted,    ///< the queues were emptied before it was handed over; it will not be sent
};

/// The outcome of an order without its echo (can/job_ending.h). Pure; realtime safe.
Outcome outcome_of(JobKnown known, JobEnd end) noexcept;

/// The one answer to an order that was taken.
struct Answer {
  OrderId id = 0;
  Outcome outcome = Outcome::done;
  Time sent{};  ///< done: end of the frame's last bit
  Obstacle obstacle =
      Obstacle::none;     ///< timeout: what kept the frame from the bus last; none: earlier frames
  std::uint8_t seen = 0;  ///< frames of the order that were seen on the bus; done: all
};

/// Counts since the start; they never fall.
struct StationCounters {
  std::uint64_t received = 0;    ///< frames of others, taken by a range or not
  std::uint64_t taken = 0;       ///< of them, taken by a range
  std::uint64_t sent = 0;        ///< own frames that stood on the bus
  std::uint64_t unanswered = 0;  ///< orders that ended with `Outcome::no_answer`
  std::uint64_t not_sent = 0;    ///< orders that ended without their frame being handed over
};

/// A station of layer 2, without interpretation of any frame: what it receives goes through ranges of
/// identifiers, what it is to send is answered when it stands on the bus.
///
/// Sans-IO: it is told what came and when, asked what to send, and asked when it must be told the time again.
/// Frames of high priority are handed over first, those of one priority in the order of their queue, at most
/// `kMostHandedOver` without an echo. One whose echo is missed keeps its place after its answer, for it may
/// stand in the controller still; it loses it by its late echo, by that of a later frame (the controller
/// keeps the order), when the controller is empty, or when echoes were lost, for then nobody knows whether
/// its own was one of them. Realtime safe after its construction; one thread.
class Station {
 public:
  static constexpr std::size_t kMostQueue = 1024;
  static constexpr std::size_t kMostHandedOver = 8;
  static constexpr std::size_t kMostDisplaced = 64;  ///< orders displaced at a time whose answers have room

  /// A depth outside its range counts as the nearest inside. Allocates.
  explicit Station(const StationSettings& settings);

  /// Another filter, other depths and rule; what waits stays. `fits` must have said so.
  void set(const StationSettings& settings) noexcept;
  /// No queue has more waiting than it would have room for.
  bool fits(const StationSettings& settings) const noexcept {
    return normal_.size() <= settings.queue && high_.size() <= settings.high_queue;
  }

  // --- receiving

  /// A frame of another node came. Position of the range that takes it, 0..kMostRanges-1, with a node filter
  /// 0; nothing: it is not received.
  std::optional<std::uint8_t> receive(const can::Frame& frame) noexcept;
  /// A frame of another node came that the ranges are not asked about.
  void count_received() noexcept { ++counters_.received; }
  /// Priority of what the range at a position takes.
  Priority priority_of(std::uint8_t range) const noexcept;

  // --- sending

  /// Takes an order, which is then answered exactly once (`take_answer`), or says why not.
  Refusal submit(const SendOrder& order, Time now) noexcept;
  /// Takes an order back that still waits; it is answered as cancelled. False: it is not waiting (any more).
  bool cancel(OrderId id) noexcept;

  /// Ends every order that waits, as deleted.
  void clear_queues() noexcept;
  /// Forgets that queues overflowed.
  void reset_overflow() noexcept;

  /// The frame to be handed to the bus next; nothing: none now. Say what became of it by `handed_over` or
  /// `held_back`. Without `normal` or `high`, frames of that priority stay back: the synchronous window keeps
  /// them from the bus, unless something was said to do so before.
  std::optional<can::Frame> next_frame(bool normal = true, bool high = true) noexcept;
  /// A frame that is nobody's order may be handed over now: there is a place for it.
  bool has_place() const noexcept { return !handed_over_.full(); }
  /// The bus took a frame that is nobody's order; `has_place` must have said so. It is counted as sent when
  /// its echo comes, and answered to nobody.
  void own_handed_over(const can::Frame& frame, const OwnFrame& own) noexcept;
  /// The bus took what `next_frame` said.
  void handed_over() noexcept;
  /// What keeps the first waiting order from the bus, which waits on: the bus did not take what `next_frame`
  /// said, or takes nothing more while `kMostHandedOver` stand in the controller.
  void held_back(Obstacle obstacle) noexcept;
  /// An own frame stood on the bus until `end`. Whose it was; nothing: nobody's that is known.
  std::optional<OwnFrame> echo(const can::Frame& frame, Time end) noexcept;
  /// Whatever was handed over is gone from the controller: it was reset, or its interface went.
  void controller_emptied() noexcept;
  /// Frames were lost on their way here, echoes perhaps too: what was handed over so far may have been sent,
  /// and keeps no place beyond its answer.
  void echoes_lost() noexcept;
  /// Frames that are nobody's orders and lost their places without an echo, in the order of their handing
  /// over, each once: they may have been sent. Not those of `controller_emptied`.
  can::BoundedList<OwnFrame, kMostHandedOver> take_lost() noexcept;

  // --- time and answers

  /// It is `now`: ends orders whose monitoring time has passed.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max() when nothing waits for time to pass.
  Time next_deadline() const noexcept;
  /// The oldest answer that was not taken yet.
  std::optional<Answer> take_answer() noexcept;
  /// Takes no more orders, and ends those that are open.
  void stop() noexcept;

  /// As of now.
  const StationCounters& counters() const noexcept { return counters_; }
  /// Orders that were taken since the start.
  std::uint64_t submitted() const noexcept { return submitted_; }
  /// Orders that wait to be handed over, of every priority.
  std::size_t waiting() const noexcept { return normal_.size() + high_.size(); }
  /// The state of a queue: its size, whether it is half full, whether it overflowed.
  struct QueueState {
    std::uint16_t size = 0;   ///< elements that wait
    std::uint16_t depth = 0;  ///< room
    bool half_full = false;
    bool overflowed = false;  ///< since the last reset
    std::uint64_t lost = 0;   ///< elements lost since the start
  };
  /// Of the queue of a priority.
  QueueState queue(Priority priority) const noexcept;
  /// Frames handed over that were not seen on the bus, answered ones included, 0..kMostHandedOver.
  std::size_t handed_over_count() const noexcept { return handed_over_.size(); }

 private:
  struct Open {
    OrderId id = 0;
    can::Frame frame;
    Time until{};
    OwnFrame own = {};
    bool answered = false;   ///< handed over, and its echo missed; of nobody's order from the start
    bool overtaken = false;  ///< handed over; a later frame was seen on the bus, or its echo may be lost
    // --- of an order of several frames
    std::span<const can::Frame> more = {};  ///< those after `frame`
    bool piece = false;  ///< handed over, and not the last: the order stands elsewhere, `answered` is set
    std::uint8_t frames = 1;          ///< to be seen before it is done
    std::uint8_t seen = 0;            ///< on the bus; of a piece nothing
    Outcome ends_as = Outcome::done;  ///< once all of `frames` were seen
  };

  std::size_t open() const noexcept { return waiting() + handed_over_.size() + answers_.size(); }
  BoundedQueue<Open>& queue_of(Priority priority) noexcept {
    return priority == Priority::high ? high_ : normal_;
  }
  void end(const Open& order, Outcome outcome, Time sent = {}) noexcept;
  void end_waiting(const Open& order, Outcome outcome) noexcept;
  void seen(const Open& frame, Time end_of_frame) noexcept;
  void lose_piece(OrderId id) noexcept;
  void overtake(std::size_t count) noexcept;
  void end_handed_over(Time now) noexcept;

  RangeFilter filter_;
  std::optional<NodeFilter> node_;
  BoundedQueue<Open> normal_;
  BoundedQueue<Open> high_;
  Priority offered_ = Priority::normal;  ///< queue of what `next_frame` said
  can::BoundedList<Open, kMostHandedOver> handed_over_;
  can::BoundedList<OwnFrame, kMostHandedOver> lost_;  ///< own frames
  BoundedQueue<Answer> answers_;
  Obstacle obstacle_ = Obstacle::none;  ///< of the first waiting order
  StationCounters counters_;
  std::uint64_t submitted_ = 0;
  bool stopped_ = false;
};

}  // namespace layer2
