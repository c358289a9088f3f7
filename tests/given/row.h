#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace given {

/// Who gives.
enum class Giver : std::uint8_t {
  first,
  second,  ///< is stronger, where one writer has a topic
};

/// One thing that may be given to a daemon, with the daemon that it is given to: a row of the table. Time passes in
/// `run` alone.
class Row {
 public:
  virtual ~Row() = default;
  Row() = default;
  Row(const Row&) = delete;
  Row& operator=(const Row&) = delete;

  /// It is a job, which ends with its answer; false: a state, which stays until something ends it.
  virtual bool is_job() const = 0;

  /// So many are a burst: more than the daemon takes at a time, and no more than it must take.
  virtual unsigned burst() const { return 100; }

  // --- the giver

  virtual void give(Giver giver) = 0;
  /// It ends what it has given, by its own word.
  virtual void end(Giver giver) = 0;
  /// It goes, leaving what it has given to others.
  virtual void leave(Giver giver) { end(giver); }
  /// Its program dies.
  virtual void kill(Giver giver) = 0;

  // --- what happens to the daemon

  virtual void set_read_only(bool read_only) = 0;
  /// The file is read again and says something else of what is given.
  virtual void reload() = 0;
  /// The daemon ends and begins anew; programs find the new one with what they give next.
  virtual void restart() = 0;
  /// The module or the line is stopped, and runs again.
  virtual void set_running(bool running) = 0;
  virtual void take_bus_off() = 0;
  virtual void bring_bus_back() = 0;
  virtual void set_listens_only() = 0;
  /// The controller has no room.
  virtual void set_full(bool full) = 0;
  /// Frames stay in the controller; false: they go on the bus.
  virtual void keep_in_controller(bool keep) = 0;
  virtual void run(std::chrono::milliseconds span) = 0;

  /// The daemon takes what has been given so far, while no time passes on the bus; its answers are taken.
  virtual void let_it_be_seen() = 0;

  // --- what is seen of it, since the last call

  /// On the bus.
  virtual std::string on_bus() = 0;
  /// By the first giver.
  virtual std::string told() = 0;
  /// By everybody: events.
  virtual std::string events() = 0;

  /// Requests of the first giver without an answer so far.
  virtual std::uint64_t unanswered() const = 0;
};

}  // namespace given
