#include "daemon/segment/bus_network.h"

#include <fmt/format.h>

#include <utility>

#include "daemon/segment/bus_participants.h"
#include "dds/entity.h"

namespace cansyncd {

using std::chrono::steady_clock;

BusNetwork::BusNetwork(std::span<const DaemonConfig> buses) : buses_(buses) {
  const DdsConfig& dds = buses.front().dds;
  if (dds.xml.empty()) watch_.emplace(dds.interface);
}

bool BusNetwork::look() {
  if (!watch_) return false;
  const bool moved = watch_->look();
  const bool due = !taken_by_.empty() && steady_clock::now() >= look_for_name_at_;
  if (!moved && !due) return false;
  const std::string before = taken_by_;
  look_for_name(moved);
  return moved || before != taken_by_;
}

NetworkPlace BusNetwork::place() const {
  if (!watch_) return {};
  if (taken_by_.empty()) return watch_->place();
  return {"lo", "",
          fmt::format("the daemon of computer {} has the name of bus {} on the network of interface {}: only "
                      "clients of this computer are served",
                      taken_by_, buses_.front().bus.name, watch_->place().interface)};
}

void BusNetwork::set_taken_by(std::string computer) {
  taken_by_ = std::move(computer);
  look_for_name_at_ = steady_clock::now() + kLookForName;
  free_looks_ = 0;
}

void BusNetwork::look_for_name(bool anew) {
  if (watch_->place().interface == "lo") return set_taken_by({});
  try {
    std::string computer = name_taken_by(buses_, watch_->place());
    if (!anew && computer.empty() && ++free_looks_ < kFreeLooks) {
      look_for_name_at_ = steady_clock::now() + kLookAgain;
      return;
    }
    set_taken_by(std::move(computer));
  } catch (const gateway::dds::SetupError&) {
    // The gateway meets the same when it goes there, and says so.
    set_taken_by({});
  }
}

}  // namespace cansyncd
