#include <cansync/function_blocks/layer2/can_cfg.h>
#include <cansync/function_blocks/layer2/can_status.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "client/src/function_blocks/layer2/saia_checks.h"
#include "client/src/layer2/frame_side.h"

namespace cansync::client::function_blocks {
namespace {

constexpr std::array<DINT, 8> kBitRates = {10'000,  20'000,  50'000,  100'000,
                                           125'000, 250'000, 500'000, 1'000'000};
constexpr DINT kFastest = 1'000'000;

/// Both tables of Saia 4.2.1; the first is not for 1 Mbit/s.
constexpr bool is_bit_timing(INT number, DINT bit_rate) noexcept {
  return (number >= 7 && number <= 14 && bit_rate != kFastest) || (number >= 258 && number <= 262);
}

}  // namespace

void CAN_CFG::call() {
  connection_->side().look();
  error_.clear();
  RetVal = configure();
}

WORD CAN_CFG::configure() {
  detail::FrameSide& side = connection_->side();
  if (PortID != 0) return refuse(can_status::wrong_port, kOnlyPort);
  if (std::find(kBitRates.begin(), kBitRates.end(), Baudrate) == kBitRates.end())
    return refuse(can_status::wrong_bit_rate,
                  fmt::format("client: Baudrate {}: allowed 10000, 20000, 50000, 100000, 125000, 250000, "
                              "500000, 1000000",
                              Baudrate));
  if (!is_bit_timing(TimeSeg1, Baudrate))
    return refuse(can_status::wrong_parameter,
                  fmt::format("client: TimeSeg1 {}: allowed 258..262{}", TimeSeg1,
                              Baudrate == kFastest ? " with 1 Mbit/s" : ", 7..14"));
  for (const INT routine : {RxIntOB, TxIntOB})
    if (routine != 0 && !is_routine(routine))
      return refuse(can_status::wrong_parameter,
                    fmt::format("client: RxIntOB, TxIntOB {}: allowed 40..47, or 0 for none", routine));
  if (!side.daemon_present()) return refuse(can_status::refused, "client: no daemon serves the bus");
  if (side.bit_rate() != static_cast<std::uint32_t>(Baudrate))
    return refuse(can_status::refused,
                  fmt::format("client: Baudrate {}: the daemon has {}; write bus.bit_rate in its file",
                              Baudrate, side.bit_rate()));
  side.begin_anew({.receive = {RxIntOB, RxIntPrm, RxIntOB != 0}, .send = {TxIntOB, TxIntPrm, TxIntOB != 0}});
  return can_status::done;
}

WORD CAN_CFG::refuse(WORD code, std::string reason) {
  error_ = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
