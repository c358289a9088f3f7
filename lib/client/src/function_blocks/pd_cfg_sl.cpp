#include <cansync/function_blocks/pd_cfg_read_sl.h>
#include <cansync/function_blocks/pd_cfg_sl.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "client/src/cansync_slave/slave_side.h"
#include "client/src/function_blocks/slaves.h"

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

/// What is wrong with the numbers of a pair of telegrams; empty: nothing.
std::string problem_of(const Mapping& mapping, const SINT_4_BMARRAY& one, const SINT_4_BMARRAY& two) {
  std::string problem = misplaced(one, two);
  return problem.empty() ? mapping.problem : problem;
}

bool same(const MappingBytes& wanted, const std::uint8_t (&found)[8]) {
  return std::equal(wanted.begin(), wanted.end(), std::begin(found));
}

/// Has it to be entered (again)?
template <class Wanted>
bool is_new(const Wanted& wanted, const std::optional<Wanted>& entered, const SlaveCommandSlot& slot) {
  if (slot.open()) return false;
  return !entered || !(*entered == wanted) || slot.other_daemon() || slot.passes();
}

}  // namespace

void PD_CFG_SL::call() {
  detail::SlaveSide& side = connection_->side();
  side.look();
  slot_.poll();
  in_effect_ = false;
  const Mapping references = mapping_of(a_WRC1, a_HL_WRC1, a_WRC2, a_HL_WRC2);
  const Mapping actuals = mapping_of(a_RDC1, a_HL_RDC1, a_RDC2, a_HL_RDC2);
  std::string problem = problem_of(references, a_WRC1, a_WRC2);
  if (problem.empty()) problem = problem_of(actuals, a_RDC1, a_RDC2);
  if (!problem.empty()) {
    entered_.reset();
    return slot_.refuse(RefusalCause::field, std::move(problem));
  }
  const Wanted wanted{references.bytes, actuals.bytes};
  const detail::SlaveSide::Status& status = side.status();
  in_effect_ = side.daemon_present() && same(wanted.references, status.reference_mapping) &&
               same(wanted.actual_values, status.actual_mapping);
  if (in_effect_) slot_.clear();
  if (in_effect_ || !is_new(wanted, entered_, slot_)) return;
  entered_ = wanted;
  slot_.mapping(wanted.references, wanted.actual_values);
}

void PD_CFG_READ_SL::call() {
  detail::SlaveSide& side = connection_->side();
  side.look();
  slot_.poll();
  in_effect_ = false;
  const Mapping actuals = mapping_of(a_RDC1, a_HL_RDC1, a_RDC2, a_HL_RDC2);
  const int slave = number(si_SL_NR);
  std::string problem = slave < 0 || slave > 31
                            ? fmt::format("client: slave {}: out of range; allowed 0..31", slave)
                            : problem_of(actuals, a_RDC1, a_RDC2);
  if (!problem.empty()) {
    entered_.reset();
    return slot_.refuse(RefusalCause::field, std::move(problem));
  }
  const Wanted wanted{slave, actuals.bytes};
  in_effect_ = side.daemon_present() &&
               wanted.actual_values == side.monitored(static_cast<std::size_t>(slave)).mapping;
  if (in_effect_) slot_.clear();
  if (in_effect_ || !is_new(wanted, entered_, slot_)) return;
  entered_ = wanted;
  slot_.listen(static_cast<std::uint8_t>(slave), wanted.actual_values);
}

}  // namespace cansync::client::function_blocks
