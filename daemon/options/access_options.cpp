#include <array>

#include "daemon/options/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

constexpr auto kAccessRows = std::to_array<DaemonRow>({
    // --- [access]
    {reloadable(
         boolean("access.read_only", "false",
                 "Refuse every request that would change a drive or the line: writes, downloads, control "
                 "words, broadcasts, reference values, modes, polling, cursors, mappings. What the master "
                 "does by itself goes on.")),
     [](DaemonConfig& c, const Value& v) { c.access.read_only = flag(v); }},
    {reloadable(
         boolean("access.profile_rules", "true",
                 "Refuse a write that the slave's drive profile does not allow: to a parameter that is "
                 "read-only, outside its limits, or too wide for its format.")),
     [](DaemonConfig& c, const Value& v) { c.access.profile_rules = flag(v); }},
});

}  // namespace

std::span<const DaemonRow> rows::access_options() {
  return kAccessRows;
}

}  // namespace cansyncd
