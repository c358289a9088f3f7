#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "can/frame.h"
#include "j1939/codec.h"
#include "j1939/identifier.h"
#include "j1939/transport.h"

namespace j1939 {

/// How the sending of a message ended.
enum class SendEnd : std::uint8_t {
  done,       ///< acknowledged; a broadcast: its last packet stood on the bus
  aborted,    ///< the receiver broke it off
  no_answer,  ///< the receiver did not go on in time, or what was sent is not known
};

/// Sends messages in packets: to each destination one at a time, of all together kSessions. Realtime safe;
/// one thread.
class TransportSender {
 public:
  static constexpr std::size_t kSessions = 8;

  /// What is to be sent; the data stay where they are until it has ended.
  struct Job {
    std::uint64_t id = 0;  ///< over 0, by which its end is told
    Pgn number = 0;
    std::uint8_t priority = 7;  ///< of the announcement and the packets, 0..7
    Address source = 0;
    Address destination = 0;             ///< kGlobalAddress: a broadcast
    std::span<const std::uint8_t> data;  ///< 9..1785 bytes; to one destination more: in the extended form
  };
  /// How a job ended; once for each.
  struct Ended {
    std::uint64_t id = 0;  ///< of the job
    SendEnd end = SendEnd::done;
    std::uint8_t reason = 0;  ///< aborted: the receiver's AbortReason, or another number
    Time sent{};              ///< done: end of the last frame
  };

  /// `spacing`: between two packets of a broadcast, 10..200 ms. The queue must outlive the sender.
  TransportSender(Time spacing, FrameQueue& answers) noexcept : spacing_(spacing), answers_(answers) {}

  /// There is room for a message to this destination.
  bool has_room(Address destination) const noexcept;
  /// Begins a message, for which there must be room.
  void begin(const Job& job, Time now) noexcept;
  /// Breaks one off that has been begun; it ends without an entry in `take_ended`. False: there is none.
  bool cancel(std::uint64_t id) noexcept;
  /// Ends everything as `SendEnd::no_answer`, without a word on the bus.
  void drop() noexcept;

  /// The frame of session `index` that is due at the time last told; nothing: none.
  std::optional<can::Frame> next_frame(std::size_t index) const noexcept;
  /// The bus took it at `now`.
  void handed_over(std::size_t index, Time now) noexcept;
  /// It stood on the bus until `end`.
  void sent(std::size_t index, Time end) noexcept;
  /// It is not waited for any more at `now`, and nobody knows whether it stood on the bus. A broadcast ends as
  /// `SendEnd::no_answer`; of a connection the receiver says what it has.
  void unseen(std::size_t index, Time now) noexcept;

  /// The receiver asks for packets; `extended`: it says so by the extended form, as in the next two.
  void clear_to_send(Address from, Pgn number, const ClearToSend& said, bool extended, Time now) noexcept;
  /// The receiver has all of them.
  void acknowledged(Address from, Pgn number, bool extended, Time now) noexcept;
  /// The receiver breaks it off.
  void aborted(Address from, Pgn number, const Abort& said, bool extended) noexcept;

  /// It is `now`: ends what the receiver left.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max(): no time is waited for.
  Time next_deadline() const noexcept;
  /// The first end that was not taken yet.
  std::optional<Ended> take_ended() noexcept;
  /// The job of session `index`; 0: none.
  std::uint64_t job_at(std::size_t index) const noexcept;
  /// Something of the job has been handed over.
  bool begun(std::uint64_t id) const noexcept;
  /// Messages that are being sent, 0..kSessions.
  std::size_t open() const noexcept;

 private:
  enum class Step : std::uint8_t {
    free,
    announce,  ///< RTS or BAM is to be sent
    wait,      ///< for the receiver
    offset,    ///< extended: the receiver is to be told which packets follow
    packets,   ///< of the window
    finished,  ///< broadcast: the last one is in the controller
    over,      ///< `ended` has not been taken
  };
  struct Session {
    Step step = Step::free;
    Job job;
    bool extended = false;
    std::uint32_t packets = 0;
    std::uint32_t next = 1;         ///< packet to be sent
    std::uint32_t offset = 0;       ///< what the numbers of packets count from
    std::uint32_t window_end = 0;   ///< last one of the window
    std::uint32_t highest = 0;      ///< last packet that was ever sent
    std::uint32_t asked_again = 0;  ///< furthest packet that was asked for again
    unsigned repeats = 0;           ///< times that one, or one before it, was
    bool in_controller = false;     ///< a frame was handed over and not seen yet
    Time not_before{};              ///< of its next frame
    Time until = Time::max();       ///< the receiver must have said something
    Ended ended;
  };

  Session* find(Address destination, Pgn number, bool extended) noexcept;
  static can::Frame announcement(const Session& session) noexcept;
  void end(Session& session, SendEnd how, std::uint8_t reason, Time sent) noexcept;
  /// Says to the receiver why it is broken off.
  void say_abort(const Session& session, AbortReason reason) noexcept;
  void break_off(Session& session, AbortReason reason) noexcept;
  bool ready(const Session& session) const noexcept;

  Time spacing_;
  FrameQueue& answers_;
  std::array<Session, kSessions> sessions_ = {};
  Time now_{};
};

}  // namespace j1939
