#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "j1939/identifier.h"
#include "j1939/message.h"
#include "j1939/transport.h"

namespace j1939 {

/// Counts since the start; they never fall.
struct ReceiverCounters {
  std::uint64_t completed = 0;  ///< messages put together
  std::uint64_t broken = 0;     ///< begun and not completed: gap, time-out, aborted, replaced by another
  std::uint64_t refused = 0;    ///< announced and not begun: no room, too long, a connection already
};

/// Puts messages together out of packets: of each source one broadcast and one connection at a time, of all
/// together kSessions. What is to be answered goes into a `FrameQueue`. Realtime safe; one thread.
class TransportReceiver {
 public:
  static constexpr std::size_t kSessions = 16;

  /// `window`: packets asked for at once, 1..255. The queue must outlive the receiver.
  TransportReceiver(std::uint8_t window, FrameQueue& answers) noexcept
      : window_(window == 0 ? std::uint8_t{1} : window), answers_(answers) {}

  /// A broadcast is announced (control byte 32).
  void announce(const Identifier& from, const can::Frame& frame, Time now) noexcept;
  /// A connection to `own`, the address of this node, is asked for (control byte 16).
  void request(const Identifier& from, const can::Frame& frame, Address own, Time now) noexcept;
  /// `source` breaks its connection off.
  void aborted(Address source, Pgn number) noexcept;
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
  /// Messages that are being put together, 0..kSessions.
  std::size_t open() const noexcept;

 private:
  struct Session {
    bool used = false;
    bool broadcast = false;
    Address source = 0;
    Address own = 0;  ///< of a connection: to whom it was asked for
    Pgn number = 0;
    std::uint8_t priority = 7;
    std::uint16_t size = 0;
    std::uint8_t packets = 0;
    std::uint8_t most = 255;      ///< packets of one window, as the sender wants it
    std::uint8_t next = 1;        ///< number of the packet that is waited for; packets + 1 does not occur
    std::uint8_t window_end = 0;  ///< last one of the window
    bool gap = false;             ///< one of the window was missed
    std::uint8_t repeats = 0;
    Time until{};
    std::array<std::uint8_t, kMostBytes> data = {};
  };

  Session* find(Address source, bool broadcast) noexcept;
  Session* begin(const Identifier& from, const can::Frame& frame, bool broadcast, Time now) noexcept;
  void give_up(Session& session) noexcept;
  void ask(Session& session, Time now) noexcept;
  void ask_again(Session& session, Time now) noexcept;

  std::uint8_t window_;
  FrameQueue& answers_;
  std::array<Session, kSessions> sessions_ = {};
  ReceiverCounters counters_;
};

}  // namespace j1939
