#include <cansync/function_blocks/pd_cfg_read_sl.h>
#include <cansync/function_blocks/pd_cfg_sl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

#include "client/src/function_blocks/slaves.h"
#include "client/src/slave_side.h"

namespace cansync::client::function_blocks {
namespace {

/// A number over 3 in telegram 1, or under 4 in telegram 2; empty: none.
std::string misplaced(const SINT_4_BMARRAY& one, const SINT_4_BMARRAY& two) {
  const auto outside = [](SINT from, SINT to) {
    return [from, to](SINT number) { return number != -1 && (number < from || number > to); };
  };
  if (std::any_of(one.begin(), one.end(), outside(0, 3)))
    return "client: telegram 1 has a value number other than 0..3 and -1";
  if (std::any_of(two.begin(), two.end(), outside(4, 7)))
    return "client: telegram 2 has a value number other than 4..7 and -1";
  return {};
}

/// How the wanted mapping differs from that of the daemon; empty: not at all. `first` and `second`: the
/// options of the daemon's file.
std::string difference(const Mapping& wanted, std::span<const std::uint8_t, 8> found, const char* first,
                       const char* second) {
  if (!wanted.problem.empty()) return wanted.problem;
  if (std::equal(wanted.bytes.begin(), wanted.bytes.end(), found.begin())) return {};
  const std::span<const std::uint8_t> bytes(wanted.bytes);
  return fmt::format(
      "client: the daemon has another mapping, 0x{:02X}; write {} = [{}] and {} = [{}] in its configuration",
      fmt::join(found, " 0x"), first, fmt::join(bytes.first(4), ", "), second,
      fmt::join(bytes.last(4), ", "));
}

}  // namespace

void PD_CFG_SL::call() {
  detail::SlaveSide& side = connection_->side();
  side.look();
  error_ = misplaced(a_WRC1, a_WRC2);
  if (error_.empty()) error_ = misplaced(a_RDC1, a_RDC2);
  if (error_.empty())
    error_ = difference(mapping_of(a_WRC1, a_HL_WRC1, a_WRC2, a_HL_WRC2), side.status().reference_mapping,
                        "slave.reference_registers_1", "slave.reference_registers_2");
  if (error_.empty())
    error_ = difference(mapping_of(a_RDC1, a_HL_RDC1, a_RDC2, a_HL_RDC2), side.status().actual_mapping,
                        "slave.actual_registers_1", "slave.actual_registers_2");
  in_effect_ = error_.empty();
}

void PD_CFG_READ_SL::call() {
  detail::SlaveSide& side = connection_->side();
  side.look();
  in_effect_ = false;
  const int slave = number(si_SL_NR);
  if (slave < 0 || slave > 31) {
    error_ = fmt::format("client: slave {}: out of range; allowed 0..31", slave);
    return;
  }
  if (slave == side.status().slave_number) {
    error_ = fmt::format("client: slave {}: is this slave itself; allowed: the others", slave);
    return;
  }
  const detail::SlaveSide::Telegrams& other = side.monitored(static_cast<std::size_t>(slave));
  if (!other.known) {
    error_ = fmt::format(
        "client: slave {}: the daemon does not listen to it; write a section [[monitored]] with number = {} in "
        "its configuration",
        slave, slave);
    return;
  }
  error_ = misplaced(a_RDC1, a_RDC2);
  if (error_.empty())
    error_ = difference(mapping_of(a_RDC1, a_HL_RDC1, a_RDC2, a_HL_RDC2), other.mapping, "actual_registers_1",
                        "actual_registers_2");
  in_effect_ = error_.empty();
}

}  // namespace cansync::client::function_blocks
