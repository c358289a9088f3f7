#pragma once

#include <string_view>

namespace cansync::dds {

/// What MasterStatus says in the place of a writer when the lead axis of a cluster gives a telegram's
/// reference values (O 7.1.1): no program does, and none may.
inline constexpr std::string_view kLeadAxisWriter = "the lead axis";

}  // namespace cansync::dds
