#include <array>

#include "config/fields.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

constexpr auto kAccessRows = std::to_array<DaemonRow>({
    // --- [access]
    field(
        [](auto& c) -> auto& { return c.access.read_only; },
        reloadable(
            boolean("access.read_only",
                    "Refuse every request that would change a drive or the line: writes, downloads, control "
                    "words, broadcasts, reference values, modes, polling, cursors, mappings. What the master "
                    "does by itself goes on."))),
    field(
        [](auto& c) -> auto& { return c.access.profile_rules; },
        reloadable(
            boolean("access.profile_rules",
                    "Refuse a write that the slave's drive profile does not allow: to a parameter that is "
                    "read-only, outside its limits, or too wide for its format."))),
});

constexpr auto kRecordRows = std::to_array<DaemonRow>({
    field(
        [](auto& c) -> auto& { return c.access.record_each; },
        reloadable(
            boolean("access.record_each",
                    "Write each request to send into the journal. false: what a client sends again and "
                    "again has an entry when it begins, one each minute, and one when it ends, with the "
                    "number of requests and the newest data."))),
});

}  // namespace

std::span<const DaemonRow> rows::record_options() {
  return kRecordRows;
}

std::span<const DaemonRow> rows::access_options() {
  return kAccessRows;
}

}  // namespace cansyncd
