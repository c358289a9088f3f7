#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "can/frame.h"
#include "j1939/codec.h"
#include "j1939/identifier.h"
#include "j1939/message.h"
#include "j1939/session_state.h"
#include "j1939/transport.h"

namespace j1939 {

/// Counts since the start; they never fall.
struct ReceiverCounters {
  std::uint64_t completed = 0;  ///< messages put together
  std::uint64_t broken = 0;     ///< begun and not completed: gap, time-out, aborted, replaced by another
  // Announced and not begun.
  std::uint64_t impossible = 0;    ///< of a size, a number of packets or a group that cannot be
  std::uint64_t busy = 0;          ///< of a sender that has a connection already
  std::uint64_t no_room = 0;       ///< too many at once, or too long for this node
  std::uint64_t wrong_length = 0;  ///< packets that have not 8 bytes

  /// Announced and not begun.
  std::uint64_t refused() const noexcept { return impossible + busy + no_room; }
};

/// Puts messages together out of packets: of each source one broadcast, one connection and one of the
/// extended form at a time, of all together kSessions, and kExtended of the last kind. What is to be answered
/// goes into a `FrameQueue`. Memory is allocated by the constructor alone; the rest is realtime safe. One
/// thread.
class TransportReceiver {
 public:
  static constexpr std::size_t kSessions = 16;

  static constexpr std::size_t kExtended = 2;

  /// `window`: packets asked for at once, 1..255. `most`: bytes of a message of the extended form; up to 1785
  /// there is none. The queue must outlive the receiver.
  TransportReceiver(std::uint8_t window, std::size_t most, FrameQueue& answers);

  /// A broadcast of this group is announced.
  void announce(const Identifier& from, Pgn number, const Announcement& said, Time now) noexcept;
  /// A connection to `own`, the address of this node, is asked for; `extended`: of that form.
  void request(const Identifier& from, Pgn number, const RequestToSend& said, bool extended, Address own,
               Time now) noexcept;
  /// `source` says which packets follow.
  void offset(Address source, Pgn number, const DataOffset& said, Time now) noexcept;
  /// `source` breaks its connection off; `extended`: that of the extended form.
  void aborted(Address source, Pgn number, bool extended) noexcept;
  /// Of a connection that this receiver only listens to: its destination clears `source` to send, or holds it;
  /// packets or another such message follow within kT2.
  void cleared_to_send(Address source, Pgn number, bool extended, Time now) noexcept;
  /// A packet, for all or for this node. The message that it completes, whose data stay until the next call.
  std::optional<Message> packet(const Identifier& from, const can::Frame& frame, Time end) noexcept;
  /// This node has lost its address: ends the connections to it without a word.
  void drop_connections() noexcept;

  /// Ends what was waited for too long, or asks for its packets again.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max(): no time is waited for.
  Time next_deadline() const noexcept;

  /// As of now.
  const ReceiverCounters& counters() const noexcept { return counters_; }
  /// A message of this group that is being put together out of packets of `source`; 0: none.
  std::uint64_t coming(Pgn number, Address source) const noexcept;
  /// That message is being put together still.
  bool is_coming(std::uint64_t message) const noexcept;
  /// Messages that are being put together, 0..kSessions.
  std::size_t open() const noexcept;

 private:
  enum class Kind : std::uint8_t { broadcast, connection, extended };
  struct Session {
    SessionState state = SessionState::free;
    std::uint64_t message = 0;  ///< over 0, each its own
    Kind kind = Kind::connection;
    Address source = 0;
    Address own = 0;  ///< of a connection: to whom it was asked for
    Pgn number = 0;
    std::uint8_t priority = 7;
    std::uint32_t size = 0;
    std::uint32_t packets = 0;
    std::uint8_t most = 255;        ///< packets of one window, as the sender wants it
    std::uint32_t next = 1;         ///< number of the packet that is waited for; packets + 1 does not occur
    std::uint32_t window_end = 0;   ///< last one of the window
    std::uint32_t offset = 0;       ///< extended: what the numbers of packets count from
    std::uint32_t asked_again = 0;  ///< packet that was asked for again last
    unsigned repeats = 0;           ///< times it was
    Time until{};
    std::span<std::uint8_t> data;  ///< memory for the message
    std::array<std::uint8_t, kMostBytes> own_memory = {};

    bool used() const noexcept { return state != SessionState::free; }
    void enter(SessionEvent event) noexcept { state = j1939::next(state, event).value_or(state); }
  };

  Session* find(Address source, Kind kind) noexcept;
  Session* begin(const Identifier& from, Pgn number, std::uint32_t size, Kind kind, Time now) noexcept;
  std::span<std::uint8_t> free_memory() noexcept;
  /// Why a connection cannot be begun; nothing: it can.
  std::optional<AbortReason> obstacle(Address source, Pgn number, const RequestToSend& said,
                                      bool extended) noexcept;
  /// Of connections that were refused for this reason.
  std::uint64_t& count_of(AbortReason reason) noexcept;
  void answer(const Session& session, const TransportControl::What& what) noexcept;
  void break_off(Session& session, AbortReason reason) noexcept;
  Message finish(Session& session, Time end) noexcept;
  void give_up(Session& session) noexcept;
  void ask(Session& session, Time now) noexcept;
  void ask_again(Session& session, Time now) noexcept;

  std::uint8_t window_;
  FrameQueue& answers_;
  std::array<Session, kSessions> sessions_ = {};
  std::size_t most_;
  std::vector<std::uint8_t> extended_memory_;  ///< kExtended times `most_`
  ReceiverCounters counters_;
  std::uint64_t messages_ = 0;  ///< begun so far
};

}  // namespace j1939
