#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/cansync/exchange.h"
#include "ledger.h"
#include "memory_truth.h"
#include "parameter_truth.h"
#include "plan.h"
#include "recovery.h"
#include "witness.h"
#include "word_truth.h"

namespace cansyncd::campaign {

/// Actual values as the gateway got them in the interval that has just ended.
struct ActualSeen {
  cansync::SlaveNumber slave;
  ActualReport report;
};

/// Everything there is to judge one interval by.
struct Scene {
  const Plan& plan;
  const Witness& witness;
  const Ledger& ledger;
  const ParameterTruth& parameters;
  const MemoryTruth& memories;
  const Recovery& recovery;
  const WordTruth& words;
  MasterSnapshot before;  ///< at the end of the interval before
  MasterSnapshot now;     ///< at the end of this one
  std::vector<ActualSeen> actual;
  std::array<std::array<std::uint64_t, cansync::kChannels>, cansync::kSlaves> counted =
      {};                                                                     ///< telegrams the
                                                                              ///< master took
  std::array<cansync::ProcessMapping, cansync::kSlaves> mapping_before = {};  ///< of actual values
  std::array<cansync::ProcessMapping, cansync::kSlaves> mapping_now = {};
  std::uint64_t skipped = 0;     ///< edges left out since the start while SYNC ran
  std::uint64_t line_edges = 0;  ///< edges before, as the line counts them
  bool ended = false;            ///< the loop has ended, and the gateway has read everything
};

}  // namespace cansyncd::campaign
