#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "can/frame.h"
#include "layer2/bounded_queue.h"
#include "layer2/data_mapping.h"
#include "layer2/message_objects.h"
#include "layer2/object_orders.h"
#include "layer2/script.h"
#include "layer2/station.h"
#include "layer2/status_image.h"
#include "layer2/timers.h"

namespace layer2 {

/// Everything a module of general frames is set up with.
struct ModuleSettings {
  StationSettings station;
  std::uint16_t receive_queue = 400;  ///< frames of normal priority that wait to be fetched, 1..kMostQueue
  std::uint16_t receive_high_queue = 20;  ///< likewise, of high priority
  Overflow receive_overflow = Overflow::delete_oldest;
  std::array<std::optional<TimerSettings>, Timers::kMost> timers = {};  ///< index: number - 1
  WindowSettings window;
  std::uint32_t bits_per_second = 500'000;  ///< of the bus, over 0
  Script power_on;                          ///< without problems, as the other two
  Script run;
  Script stop;
  std::array<std::optional<ObjectSettings>, MessageObjects::kMost> objects = {};
  Time object_patience =
      std::chrono::seconds(1);  ///< a job whose frame was handed over, until it is answered as `no_answer`
  bool starts_in_run = true;    ///< false: it stays in stop until it is told to run
  MappingSettings mapping;
  std::vector<MappedBytes>
      mapped;  ///< in which `DataMapping::check` finds nothing; none: there is no mapping
};

/// Settings for a module that runs: made by whoever may allocate, and exchanged with those of the module,
/// which are here afterwards.
struct PreparedSettings {
  /// Makes them ready. Allocates.
  explicit PreparedSettings(ModuleSettings prepared);

  /// Which of `settings` count.
  struct Parts {
    bool station = false;  ///< filters, send queues
    bool receive_queues = false;
    bool timers = false;  ///< all of them: those that are not there are forgotten
    bool window = false;
    bool scripts = false;
    bool objects = false;  ///< all of them
    bool mapping = false;
  };
  ModuleSettings settings;
  DataMapping mapping;  ///< with the table
  Parts parts;
};

/// What a module is told to do besides sending.
enum class Control : std::uint8_t {
  run,
  stop,
  start_timer,       ///< `number`
  stop_timer,        ///< `number`
  set_timer,         ///< `number`, `timer`
  reset_controller,  ///< not the module's: of whoever has the bus
  clear_queues,
  reset_overflow,
  configure,    ///< `prepared`
  write_image,  ///< `address`, `size`, `bytes`; done by whoever has the image, who says so by `written`
};

/// An order to control.
struct ControlOrder {
  static constexpr std::size_t kMostBytes = 64;
  OrderId id = 0;
  Control what = Control::run;
  std::uint8_t number = 0;  ///< of a timer, 1..kMost
  TimerSettings timer;
  std::uint16_t address =
      0;  ///< first byte in the image that is sent; address + size at most DataMapping::kBytes
  std::uint8_t size = 0;                 ///< bytes, 1..kMostBytes
  PreparedSettings* prepared = nullptr;  ///< of who gives the order, until it is answered
  bool led = true;                       ///< `run`: false: who leads run and stop says stop
  /// Table of the image that has them; nothing: it is not for requests to write.
  std::optional<std::uint32_t> written = {};
  std::array<std::uint8_t, kMostBytes> bytes = {};  ///< those from `size` on do not count
};

/// A frame that waits to be fetched.
struct WaitingFrame {
  can::Frame frame;
  Time end{};              ///< of its last bit
  std::uint8_t range = 0;  ///< position of the range that takes it
  Priority priority = Priority::normal;
};

/// What happened to a message object that tells, or to the send queues.
struct ModuleEvent {
  /// What it was.
  enum class Kind : std::uint8_t {
    object_received,
    object_sent,
    send_queue_empty,  ///< the last order that waited was handed over or ended
  };
  Kind kind = Kind::send_queue_empty;
  std::uint8_t number = 0;  ///< of an object
  can::Frame frame;         ///< likewise
  Time time{};              ///< end of the frame
};

/// All services of a module together: filters and queues (`Station`), timers, synchronous window, scripts,
/// message objects and data mapping.
///
/// A frame of another node goes to the first that takes it: message objects, data mapping, queues (Saia 3.5).
/// Frames are handed over in the order timers, scripts, message objects, data mapping, orders of high and
/// orders of normal priority. The synchronous window holds orders alone.
///
/// In stop no order is taken, nothing is received, timers and mapping stand still; what a script of `stop`
/// starts goes on. What is under way when a module is stopped is deleted. Sans-IO, as `Station`; realtime
/// safe after its construction; one thread.
class Module {
 public:
  /// Allocates. Depths outside their range count as the nearest inside.
  explicit Module(const ModuleSettings& settings);

  /// It is powered up: its script begins, and the module runs when it is set up so.
  void begin(Time now) noexcept;
  /// Changes between run and stop; nothing when it is there already.
  void set_running(bool running, Time now) noexcept;
  /// It is in run.
  bool running() const noexcept { return running_; }
  /// A script is under way.
  bool script_runs() const noexcept { return runner_.runs(); }

  // --- receiving

  /// A frame of another node came.
  void receive(const can::Frame& frame, Time end) noexcept;
  /// The next frame to be fetched, high priority first.
  std::optional<WaitingFrame> take_received() noexcept;
  /// The state of a receive queue.
  Station::QueueState receive_queue(Priority priority) const noexcept;

  // --- sending, as `Station` says

  /// As `Station::submit`; in stop refused.
  Refusal submit(const SendOrder& order, Time now) noexcept;
  /// As `Station::cancel`.
  bool cancel(OrderId id) noexcept { return station_.cancel(id); }
  /// As `Station::next_frame`, of all services.
  std::optional<can::Frame> next_frame() noexcept;
  /// The bus took what `next_frame` said.
  void handed_over() noexcept;
  /// As `Station::held_back`.
  void held_back(Obstacle obstacle) noexcept {
    station_.held_back(obstacle);
    orders_.held_back(obstacle);
  }
  /// An own frame stood on the bus until `end`.
  void echo(const can::Frame& frame, Time end) noexcept;
  /// As `Station::controller_emptied`.
  void controller_emptied() noexcept;
  /// As `Station::echoes_lost`.
  void echoes_lost() noexcept;
  /// As `Station::take_answer`.
  std::optional<Answer> take_answer() noexcept { return station_.take_answer(); }

  // --- message objects

  /// As `ObjectOrders::perform`; a job is refused in stop.
  std::optional<ObjectAnswer> perform(const ObjectOrder& order, Time now) noexcept {
    return orders_.perform(order, running_, now);
  }
  /// As `ObjectOrders::cancel`.
  bool cancel_object(OrderId id) noexcept { return orders_.cancel(id); }
  /// As `ObjectOrders::take_answer`.
  std::optional<ObjectAnswer> take_object_answer() noexcept { return orders_.take_answer(); }
  /// The next event; those that nobody takes are lost when there are more than a few.
  std::optional<ModuleEvent> take_event() noexcept;

  // --- control

  /// Does what an order says; Refusal::none when it is done.
  Refusal control(const ControlOrder& order, Time now) noexcept;
  /// Takes settings over, all of their parts or none. Timers and objects that stay as they are go on.
  Refusal configure(PreparedSettings& prepared, Time now) noexcept;
  /// False: the timer is not configured, or belongs to the window and does not exist. Any state.
  bool start_timer(unsigned number, Time now) noexcept;
  /// False: there is no such timer.
  bool stop_timer(unsigned number) noexcept;
  /// Gives a timer what it sends and when; as `Timers::configure`.
  bool configure_timer(unsigned number, const TimerSettings& settings) noexcept;
  /// As `Timers::set_frame`.
  bool set_timer_frame(unsigned number, const can::Frame& frame) noexcept;
  /// Deletes what waits in every queue (Helmholz 7.2.4, function 6).
  void clear_queues() noexcept;
  /// Forgets that queues overflowed (function 7).
  void reset_overflow() noexcept;

  // --- time and state

  /// It is `now`: does what is due.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest.
  Time next_deadline() const noexcept;
  /// Takes no more orders, and ends those that are open.
  void end() noexcept {
    station_.stop();
    orders_.stop();
  }

  /// Filters, orders and counters.
  const Station& station() const noexcept { return station_; }
  /// Frames that message objects took, since the start.
  std::uint64_t taken_by_objects() const noexcept { return taken_by_objects_; }
  /// The timers, as they are.
  const Timers& timers() const noexcept { return timers_; }
  /// The synchronous window, as it is.
  const SyncWindow& window() const noexcept { return window_; }
  /// The message objects.
  MessageObjects& objects() noexcept { return objects_; }
  const MessageObjects& objects() const noexcept { return objects_; }
  /// It was set up with telegrams to map.
  bool has_mapping() const noexcept { return !settings_.mapped.empty(); }
  /// The data mapping.
  DataMapping& mapping() noexcept { return mapping_; }
  const DataMapping& mapping() const noexcept { return mapping_; }
  /// The part of the status bytes that the module knows: queues, whether it runs, the node filter.
  StatusFacts status() const noexcept;

 private:
  void step_script() noexcept;
  void start_script(const Script& script) noexcept;
  bool orders_may_go() const noexcept;
  void pass_lost() noexcept;
  bool has_room(unsigned number, const TimerSettings& settings) const noexcept;
  Refusal objection(const PreparedSettings& prepared) const noexcept;
  void configure_mapping(PreparedSettings& prepared, Time now) noexcept;
  void tell(ModuleEvent::Kind kind, unsigned number, const can::Frame& frame, Time time) noexcept;

  ModuleSettings settings_;
  Station station_;
  Timers timers_;
  SyncWindow window_;
  ScriptRunner runner_;
  MessageObjects objects_;
  ObjectOrders orders_;
  DataMapping mapping_;
  BoundedQueue<WaitingFrame> received_;
  BoundedQueue<WaitingFrame> received_high_;
  BoundedQueue<ModuleEvent> events_;
  std::uint64_t taken_by_objects_ = 0;
  std::uint64_t emptied_for_ = 0;        ///< orders submitted when the send queues were last told to be empty
  const Script* next_script_ = nullptr;  ///< begins when the one under way has ended
  std::optional<ScriptCommand> script_frame_;
  OwnFrame offered_own_;
  can::Frame offered_;
  Time now_{0};
  bool running_ = false;
};

}  // namespace layer2
