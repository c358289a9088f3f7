#pragma once

#include <cansync/client.h>
#include <cansync/function_blocks/types.h>

#include <optional>
#include <string>

/// Internal to the function blocks.
namespace cansync::client::function_blocks {

/// What a block does not even ask for.
struct InputProblem {
  RefusalCause cause = RefusalCause::field;
  std::string reason;
};

/// Why there is no such slave: not 0..31, or not configured. Nothing: there is. Uses what the daemon told
/// last.
std::optional<InputProblem> slave_problem(const Client& client, SINT number);

/// A monitoring time for a request, at least 1 ms: 0 would be the daemon's default.
std::uint32_t milliseconds_of(TIME time) noexcept;

/// Register bytes from arrays of value numbers (-1: unused) and flags for the high word. Empty `problem` when
/// every number is -1..7.
struct Mapping {
  MappingBytes bytes = {};
  std::string problem;
};
/// The mapping that two pairs of arrays describe (M 4.15): `one` for telegram 1, `two` for telegram 2.
/// Whether a number belongs to its telegram is the daemon's to check.
Mapping mapping_of(const SINT_4_BMARRAY& one, const BOOL_4_BMARRAY& high_one, const SINT_4_BMARRAY& two,
                   const BOOL_4_BMARRAY& high_two);

}  // namespace cansync::client::function_blocks
