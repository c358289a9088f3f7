#include <cansync/function_blocks/pd_cfg_ma.h>
#include <cansync/function_blocks/pd_cfg_read_ma.h>

#include <utility>

#include "client/src/function_blocks/slaves.h"

namespace cansync::client::function_blocks {

void PD_CFG_MA::call() {
  const Inputs inputs = {a_WRC1, a_WRC2, a_HL_WRC1, a_HL_WRC2};
  if (inputs != entered_) {
    entered_ = inputs;
    Mapping mapping = mapping_of(a_WRC1, a_HL_WRC1, a_WRC2, a_HL_WRC2);
    if (mapping.problem.empty())
      slot_.enter([bytes = mapping.bytes](Client& client) { return client.map_references(bytes); },
                  mapping.bytes);
    else
      slot_.refuse(RefusalCause::field, std::move(mapping.problem));
  }
  slot_.poll();
}

void PD_CFG_READ_MA::call() {
  const Inputs inputs = {si_SL_NR, a_RDC1, a_RDC2, a_HL_RDC1, a_HL_RDC2};
  // A reload of the daemon adds slaves.
  const bool was_missing = slot_.cause() == RefusalCause::slave_not_configured && slot_.may_repeat() &&
                           !slave_problem(*client_, si_SL_NR);
  if (inputs != entered_ || was_missing) {
    entered_ = inputs;
    Mapping mapping = mapping_of(a_RDC1, a_HL_RDC1, a_RDC2, a_HL_RDC2);
    auto problem = slave_problem(*client_, si_SL_NR);
    if (!problem && !mapping.problem.empty())
      problem = InputProblem{RefusalCause::field, std::move(mapping.problem)};
    if (!problem)
      slot_.enter([slave = static_cast<std::uint32_t>(number(si_SL_NR)),
                   bytes = mapping.bytes](Client& client) { return client.map_actuals(slave, bytes); });
    else
      slot_.refuse(problem->cause, std::move(problem->reason));
  }
  slot_.poll();
}

}  // namespace cansync::client::function_blocks
