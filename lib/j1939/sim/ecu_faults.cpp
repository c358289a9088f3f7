#include "j1939/sim/ecu_faults.h"

namespace sim {
namespace {

class EcuFaults final : public FaultProtocol {
 public:
  std::string_view node_word() const noexcept override { return "ecu"; }
  std::span<const ChannelName> channels() const noexcept override { return {}; }
  std::optional<NodeNumber> node_of(const can::Frame&) const noexcept override { return std::nullopt; }
  bool is_answer(const can::Frame&) const noexcept override { return false; }
  void make_wrong(can::Frame&) const noexcept override {}
  void make_busy(can::Frame&) const noexcept override {}
};

}  // namespace

const FaultProtocol& ecu_faults() noexcept {
  static const EcuFaults faults;
  return faults;
}

}  // namespace sim
