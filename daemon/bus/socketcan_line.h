#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "can/link_board.h"
#include "can/link_kernel.h"
#include "can/link_watch.h"
#include "can/socketcan/bus_sockets.h"
#include "can/socketcan/socketcan_bus.h"
#include "daemon/bus/bus_plan.h"
#include "daemon_config/daemon_config.h"

namespace cansyncd {

/// Takes what was found of an interface, on the watching thread.
using LinkListener = std::function<void(const can::LinkFacts&)>;

/// What the kernel is asked for.
can::SocketcanSettings socketcan_settings(const BusPlan& plan);

/// Why the daemon must not start on this interface; empty when it may, also when it is missing or down.
std::string interface_refusal(const BusConfig& bus, const can::LinkFacts& facts);

/// How this controller comes to one-shot mode, or what to do without.
std::string one_shot_remedy(const BusConfig& bus, const can::LinkFacts& facts);

/// What is to be said at the start of a controller without one-shot mode; empty when nothing is.
std::string one_shot_advice(const BusConfig& bus, const can::LinkFacts& facts);

/// The CAN interface of a bus with the thread that watches it. Built on the main thread; afterwards
/// `bus` belongs to the realtime thread.
class SocketcanLine {
 public:
  /// Throws std::system_error when the kernel has no SocketCAN, std::runtime_error when the interface has
  /// another adapter than bus.adapter allows, is set up with another bit rate, is not in the one-shot mode that is demanded, or is none for CAN.
  explicit SocketcanLine(const BusPlan& plan);
  ~SocketcanLine() { stop(); }
  SocketcanLine(const SocketcanLine&) = delete;
  SocketcanLine& operator=(const SocketcanLine&) = delete;

  can::Bus& bus() noexcept { return *bus_; }
  /// What people should know of the interface as it was found; empty: nothing.
  const std::string& advice() const noexcept { return advice_; }

  /// Starts the watching thread, which tells `listener` what it finds; what that uses must live until `stop`.
  void start(LinkListener listener);

  /// Ends that thread.
  void stop() noexcept;

 private:
  std::unique_ptr<can::LinkKernel> links_;
  can::LinkBoard board_;
  std::optional<can::BusSockets> sockets_;
  std::optional<can::LinkWatch> watch_;
  std::unique_ptr<can::SocketcanBus> bus_;
  std::string advice_;
  std::jthread thread_;
};

}  // namespace cansyncd
