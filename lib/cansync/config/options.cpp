#include "cansync/config/options.h"

#include <array>

#include "cansync/config/rows.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

constexpr auto kProtocol = std::to_array<DaemonRow>({
    {rows::protocol_option(kMasterProtocol, "\"cansync-master\""), [](DaemonConfig&, const Value&) {}},
});

/// In the order of the documents.
constexpr auto kSections = std::to_array<config::Section>({
    {"bus", "", ""},
    {"realtime", "", ""},
    {"recorder", "", ""},
    {"startup", "", ""},
    {"dds", "", ""},
    {"sim", "", ""},
    {"failsafe", "", ""},
    {"access", "", ""},
    {"metrics", "", ""},
    {"sync", "", ""},
    {"process", "", ""},
    {"command_channel", "", ""},
    {"reference", "value numbers", "Once for each reference value that has a name, unit, scaling or limits."},
    {"actual", "value numbers",
     "Once for each actual value that has a name, unit or scaling on all slaves; a slave's own go first."},
    {"slave", "slave numbers",
     "Once for each slave of the line. Without any, a simulated line has all 32; on a CAN interface there "
     "must be one."},
    {"slave.value", "value numbers",
     "Below its slave, once for each actual value that has a name, unit or scaling."},
});

}  // namespace

const config::Rows<Draft>& option_rows() {
  static const config::Rows<Draft> all(kSections, {{std::span<const DaemonRow>(kProtocol), &Draft::config},
                                                   {rows::daemon_options(), &Draft::config},
                                                   {rows::access_options(), &Draft::config},
                                                   {rows::metrics_options(), &Draft::config},
                                                   {rows::sync_options(), &Draft::config},
                                                   rows::bus_options(),
                                                   rows::failsafe_options(),
                                                   rows::line_options(),
                                                   rows::reference_limit_options(),
                                                   rows::slave_options()});
  return all;
}

const config::Table& options() {
  return option_rows().table();
}

}  // namespace cansyncd
