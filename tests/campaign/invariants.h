#pragma once

#include <optional>
#include <span>
#include <string>

#include "scene.h"

namespace cansyncd::campaign {

/// What must hold after every interval, whatever happens.
struct Invariant {
  const char* name;
  /// What is wrong, in words; nothing when all is well.
  std::optional<std::string> (*check)(const Scene& scene);
};

/// All of them, in the order they are checked.
std::span<const Invariant> invariants() noexcept;

}  // namespace cansyncd::campaign
