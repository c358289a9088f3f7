#pragma once

#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "cansync/slave/slave.h"
#include "cansync_slave/config/config.h"
#include "daemon/cansync_slave/exchange.h"

namespace cansyncd {

/// Sets the slave up by itself, as its application would (M 3.2.3.3), and does what programs ask of it.
/// Realtime thread only; realtime safe.
class SlaveCommands {
 public:
  /// `of_cluster`: programs may do no more than reset its controller. All must outlive this object.
  SlaveCommands(cansync::Slave& slave, can::Bus& bus, SlaveExchange& exchange, SlaveTarget target,
                bool of_cluster) noexcept
      : slave_(slave), bus_(bus), exchange_(exchange), target_(target), of_cluster_(of_cluster) {}

  /// From start-up to the configured state.
  void set_up() noexcept;

  /// Does the next thing that a program has asked for, and gives the answer, which is to be told; nothing:
  /// none waits. What is refused has changed nothing.
  std::optional<SlaveOrderDone> take() noexcept;

  /// The slave is stopped: gives the answer to the next order without an end; nothing: all have one. No order is
  /// carried out any more.
  std::optional<SlaveOrderDone> take_stopped() noexcept;

 private:
  SlaveRefusal give(const SlaveModeOrder& order) noexcept;
  void set(const SlaveOrder& order) noexcept;
  SlaveRefusal command(cansync::ControlCommand command) noexcept;
  void wait_for_start() noexcept;
  SlaveRefusal end_reset(can::ResetResult result) noexcept;

  cansync::Slave& slave_;
  can::Bus& bus_;
  SlaveExchange& exchange_;
  const SlaveTarget target_;
  const bool of_cluster_;
  std::optional<SlaveModeOrder> reset_;  ///< the controller is being reset for it
};

}  // namespace cansyncd
