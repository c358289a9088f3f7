#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "layer2/message_objects.h"
#include "layer2/station.h"
#include "layer2/timers.h"

namespace layer2 {

/// Settings of one message object.
struct ObjectEntry {
  std::uint8_t number = 0;  ///< 0..MessageObjects::kMost-1
  ObjectSettings settings;
};

/// What is to be done with message objects.
struct ObjectOrder {
  /// What, and the members that say more.
  enum class Kind : std::uint8_t {
    configure,  ///< `settings`, `anew`
    send,       ///< `number`, `job`
    abort,      ///< `number`
    read,       ///< `number`, `release`, `ask`
  };
  OrderId id = 0;
  Kind kind = Kind::read;
  std::uint8_t number = 0;  ///< of the object, 0..MessageObjects::kMost-1
  ObjectJob job;
  bool release = false;  ///< opens the object for the next frame
  bool ask = false;      ///< with `release`: sends a remote frame of its identifier
  bool anew = false;     ///< every object is forgotten first
  /// All of them or none. Memory of who gives the order, until it is answered.
  std::span<const ObjectEntry> settings = {};
};

/// The one answer to an order.
struct ObjectAnswer {
  OrderId id = 0;
  Refusal refusal = Refusal::none;  ///< not none: nothing has changed
  std::uint8_t place = 0;           ///< refused `configure`: position of the first wrong entry
  Outcome outcome = Outcome::done;
  Obstacle obstacle = Obstacle::none;  ///< timeout: as of `Answer`
  Time time{};                         ///< end of the frame that was sent; 0: none
  bool fresh = false;                  ///< `read`: there was a frame
  std::uint64_t job_number = 0;        ///< `send`: `ObjectState::job_number` that it was given
  ObjectReading reading;
};

/// Does orders to message objects and answers each once: a job when its frame stood on the bus or will not be
/// sent by it, one for remote frames as soon as the object holds it, everything else at once.
///
/// Realtime safe; one thread.
class ObjectOrders {
 public:
  /// `patience`, over 0: a frame in the controller that was not seen on the bus for so long is answered as
  /// `no_answer`. `objects` must outlive this.
  ObjectOrders(MessageObjects& objects, Time patience) noexcept : objects_(objects), patience_(patience) {}

  /// Another patience, over 0, for frames that are handed over from now on.
  void set_patience(Time patience) noexcept { patience_ = patience; }

  /// The answer to an order; nothing: it comes by `take_answer`. `running`: a job may be given.
  std::optional<ObjectAnswer> perform(const ObjectOrder& order, bool running, Time now) noexcept;
  /// Ends the job of an order, unless its frame is in the controller. False: there is no such order.
  bool cancel(OrderId id) noexcept;
  /// The answer to a job that has ended, in the order of the objects.
  std::optional<ObjectAnswer> take_answer() noexcept;
  /// Every job that is open ends; of those in the controller nobody knows.
  void stop() noexcept { stopped_ = true; }

  /// The bus took the frame of an object.
  void handed_over(unsigned number, Time now) noexcept;
  /// What keeps frames from the bus, as of `Station`; none: it took the last one.
  void held_back(Obstacle obstacle) noexcept { obstacle_ = obstacle; }
  /// It is `now`.
  void advance(Time now) noexcept { now_ = now; }
  /// When `advance` must be called at the latest.
  Time next_deadline() const noexcept;

 private:
  struct Open {
    OrderId id = 0;
    bool used = false;
    Time until = Time::max();  ///< of one whose frame was handed over
  };

  ObjectAnswer configure(const ObjectOrder& order) noexcept;
  ObjectAnswer read(const ObjectOrder& order) noexcept;

  MessageObjects& objects_;
  Time patience_;
  Time now_{0};
  std::array<Open, MessageObjects::kMost> open_ = {};
  std::size_t jobs_ = 0;  ///< of `open_` in use
  Obstacle obstacle_ = Obstacle::none;
  bool stopped_ = false;
};

}  // namespace layer2
