#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>

#include "can/frame.h"
#include "j1939/codec.h"
#include "j1939/message.h"
#include "j1939/transport.h"
#include "j1939/transport_receiver.h"

/// Messages of a recording. Allocates; one thread.
namespace j1939::client {

/// Assembles the messages of recorded buses: those in one frame, broadcasts, and the connections between any two
/// nodes. Each destination is a receiver of its own, whose answers are not sent. Memory is bounded, whatever is
/// in the recording: at most kMostReceivers, kMostExtended of them for messages over 1785 bytes.
class RecordedBus {
 public:
  static constexpr std::size_t kMostReceivers = 1024;
  static constexpr std::size_t kMostExtended = 8;
  /// Bytes of the longest message of the extended transport protocol that is assembled.
  static constexpr std::size_t kMostLongBytes = std::size_t{1} << 20;

  /// Counts since the beginning of the recording.
  struct Counters {
    std::uint64_t foreign =
        0;  ///< frames that are not J1939: identifiers of 11 bits, remote and error frames
    std::uint64_t incomplete =
        0;                      ///< multi-packet messages of which packets are missing, or that were aborted
    std::uint64_t refused = 0;  ///< multi-packet messages that were announced wrongly, or found no memory
  };

  /// The next frame of `bus`, a number of the caller's, with its time stamp, which may go back. The message that
  /// it completes; its data stay until the next call.
  std::optional<j1939::Message> receive(std::uint32_t bus, const can::Frame& frame, Time time);

  /// As of now; at the end of the recording what is still open is incomplete.
  Counters counters() const;

 private:
  /// The answers of a receiver, which go nowhere, and the receiver.
  struct Destination {
    explicit Destination(std::size_t most) : receiver(kWindow, most, answers) {}
    FrameQueue answers;
    TransportReceiver receiver;
  };
  /// A recorded clock, without what it goes back.
  struct Clock {
    Time now{};
    std::optional<Time> last;
  };
  struct Key {
    std::uint32_t bus = 0;
    Address address = 0;
    bool extended = false;
    friend bool operator<(const Key& a, const Key& b) noexcept {
      return std::tie(a.bus, a.address, a.extended) < std::tie(b.bus, b.address, b.extended);
    }
  };
  /// As many packets as the sender likes: the recorded receiver says how many.
  static constexpr std::uint8_t kWindow = 255;

  Time clock(std::uint32_t bus, Time time);
  /// The receiver of this destination, with its time; null: there is none yet.
  TransportReceiver* find(const Key& key, Time now);
  /// The same; a new one where there is none. Null: there are too many, which is counted.
  TransportReceiver* find_or_make(const Key& key, Time now);
  void control(std::uint32_t bus, const TransportControl& said, const Identifier& from, Time now);

  std::map<std::uint32_t, Clock> clocks_;
  std::map<Key, Destination> destinations_;
  std::size_t extended_ = 0;  ///< of the destinations
  Counters counters_;
  can::Frame last_;  ///< memory of a message in one frame
};

}  // namespace j1939::client
