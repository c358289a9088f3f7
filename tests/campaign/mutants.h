#pragma once

#include <memory>
#include <span>

#include "plan.h"
#include "tamper.h"

namespace cansyncd::campaign {

/// A product that is broken in one way on purpose, to show that an invariant can fail.
struct Mutant {
  const char* name;
  const char* caught_by;  ///< the invariant that must see it
  std::unique_ptr<Tamper> (*make)(const Plan& plan);
};

/// Those that say something else than what is so.
std::span<const Mutant> word_mutants() noexcept;

/// All of them; every invariant is named at least once.
std::span<const Mutant> mutants();

}  // namespace cansyncd::campaign
