#include <array>

#include "daemon/options/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

constexpr auto kRows = std::to_array<Row>({
    // --- [access]
    {reloadable(
         boolean("access.read_only", "false",
                 "Refuse every request that would change a drive or the line: writes, downloads, control "
                 "words, broadcasts, reference values, modes, polling, cursors, mappings. What the master "
                 "does by itself goes on.")),
     [](Draft& d, const Value& v) { d.config.access.read_only = flag(v); }},
    {reloadable(
         boolean("access.profile_rules", "true",
                 "Refuse a write that the slave's drive profile does not allow: to a parameter that is "
                 "read-only, outside its limits, or too wide for its format.")),
     [](Draft& d, const Value& v) { d.config.access.profile_rules = flag(v); }},
});

}  // namespace

std::span<const Row> rows::access_options() {
  return kRows;
}

}  // namespace cansyncd
