#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/frame.h"
#include "j1939/node.h"
#include "sim/node.h"

namespace sim {

/// What a simulated node of J1939 is and does.
struct EcuSettings {
  NodeNumber number = 0;                               ///< by which faults and traces name it, 0..31
  j1939::ClaimSettings claim;                          ///< its NAME and address
  j1939::Pgn group = 0;                                ///< what it sends, and gives to who asks for it
  std::uint8_t priority = 6;                           ///< 0..7
  j1939::Address destination = j1939::kGlobalAddress;  ///< of what it sends again and again
  std::vector<std::uint8_t> data;                      ///< 0..1785 bytes; none: it sends and gives nothing
  can::Time period{0};                                 ///< between two of its messages; 0: on request alone
  bool counts = true;                                  ///< the first byte counts its periodic messages
};

/// A node that claims its address, answers requests, takes connections, and sends one message again and
/// again: in one frame, as a broadcast, or by a connection.
class EcuNode final : public Node {
 public:
  /// May allocate.
  explicit EcuNode(EcuSettings settings);

  NodeNumber node_number() const noexcept override { return number_; }
  bool accepts(const can::Frame& frame) const noexcept override { return frame.extended && !frame.remote; }
  void on_sync(can::Time) noexcept override {}
  std::optional<Transmission> on_join(can::Time now) noexcept override;
  std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override;
  std::optional<Transmission> on_sent(const can::Frame& frame, can::Time end) noexcept override;
  std::optional<can::Time> next_time() const noexcept override;
  Deed on_time(can::Time now) noexcept override;

 private:
  std::optional<Transmission> next(can::Time now) noexcept;
  void send_message(can::Time now) noexcept;

  NodeNumber number_;
  EcuSettings settings_;
  j1939::Node node_;
  can::Time next_message_ = can::Time::max();
  bool in_flight_ = false;  ///< a frame of it is on its way to the bus
  bool under_way_ = false;  ///< its message has not ended
};

}  // namespace sim
