#pragma once

#include <string>

#include "cansync/config/bus_budget.h"

namespace cansyncd {

/// The budget as a short table for people, times in microseconds after SYNC; ends with a line feed.
/// Allocates.
std::string budget_text(const BusBudget& budget);

}  // namespace cansyncd
