#include "cansync_cluster/config/options.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "config/fields.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

using ClusterRow = config::Row<ClusterDraft>;
using LeadKind = cansync::LeadSource::Kind;

SubSlaveDraft& sub_slave(ClusterDraft& draft) {
  return draft.sub_slaves[draft.number];
}

LeadDraft& lead(ClusterDraft& draft) {
  return draft.leads[draft.number];
}

/// Of a section; 0 would be the gateway itself.
constexpr Option participant_number(std::string_view key, std::string_view help) {
  Option option = label(key, 65535, help);
  option.minimum = 1;
  return option;
}

constexpr auto kLeadKinds = std::to_array<Word<LeadKind>>(
    {{"reference", LeadKind::reference}, {"actual", LeadKind::actual}, {"monitored", LeadKind::monitored}});

constexpr auto kClusterDaemonRows = std::to_array<DaemonRow>({
    {rows::protocol_option(kClusterProtocol, "\"cansync-cluster\""), [](DaemonConfig&, const Value&) {}},
    {string("bus.name", OptionType::identifier, "\"cluster\"", 1, 57,
            "Name of the cluster; clients find its buses as NAME.upper and NAME.lower."),
     [](DaemonConfig& c, const Value& v) { c.bus.name = words(v); }},
    {one_number("bus.bit_rate", "1000000", "125000|250000|500000|1000000", "bit/s",
                "Bit rate of both buses; it fixes the interval: 8, 4, 2 or 1 ms."),
     [](DaemonConfig& c, const Value& v) { c.bus.bits_per_second = whole<std::uint32_t>(v); }},
    {example("\"cell\"", string("dds.partition", OptionType::identifier, "(bus.name)", 1, 57,
                                "DDS partition of all topics, with .upper and .lower after it.")),
     [](DaemonConfig& c, const Value& v) { c.dds.partition = words(v); }},
});

constexpr auto kClusterRows = std::to_array<ClusterRow>({
    // --- [cluster]
    field(
        [](auto& d) -> auto& { return d.own_number; },
        whole_number(
            "cluster.own_number", 0, 65535, "",
            "CANsync number of the gateway itself; as a sub-slave address it means the gateway, as 0 "
            "does. 0 = it has none.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.monitoring; },
        whole_number(
            "cluster.monitoring_ms", 1, 60'000, "ms",
            "Monitoring time of a parameter job that goes down, time behind other jobs of the lower bus "
            "counted. Shorter than that of who asks above, or nobody learns why a job failed.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.block_monitoring; },
        whole_number("cluster.block_monitoring_ms", 1, 600'000, "ms",
                     "Likewise of a block of an upload or download, with one repetition.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.asker_gone; },
        whole_number(
            "cluster.asker_gone_ms", 1, 600'000, "ms",
            "A parameter job that nobody above asks about for so long is dropped, with what came of it. For "
            "as long the same write again, with nothing in between, gets the answer it had and is not "
            "written twice.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.transfer_gone; },
        whole_number("cluster.transfer_gone_ms", 1, 600'000, "ms", "Likewise an upload or download.")),
    duration<std::chrono::microseconds>(
        [](auto& d) -> auto& { return d.lead_reserve; },
        whole_number("cluster.lead_reserve_us", 0, 1000, "us",
                     "From the end of a telegram above until its values are at hand, at most: decides which "
                     "values of the lead axis go down in the same interval.")),
    // --- [[sub_slave]]
    {participant_number(
         "sub_slave.number",
         "CANsync number of a participant below: the sub-slave address by which it is asked for."),
     [](ClusterDraft& d, const Value&) { (void)sub_slave(d); }},
    {example("3", whole_number("sub_slave.slave", "(required)", 0, 31, "",
                               "Slave of the lower bus: the participant itself, or the gateway on the way to "
                               "it.")),
     [](ClusterDraft& d, const Value& v) { sub_slave(d).slave = whole<unsigned>(v); }},
    {boolean(
         "sub_slave.gateway", "false",
         "That slave is a gateway on the way: the number goes on with the job. false: it is the participant "
         "itself."),
     [](ClusterDraft& d, const Value& v) { sub_slave(d).gateway = flag(v); }},
    // --- [[lead]]
    {label("lead.number", 7, "Reference value of the lower bus."),
     [](ClusterDraft& d, const Value&) { (void)lead(d); }},
    {choice("lead.from", "\"reference\"", "reference|actual|monitored",
            "What it is on the upper bus: reference = a reference value that the slave gets; actual = an "
            "actual value that a program releases; monitored = an actual value of another slave."),
     [](ClusterDraft& d, const Value& v) {
       for (const auto& word : kLeadKinds) {
         if (word.text == words(v)) lead(d).from = word.value;
       }
     }},
    {example("0", whole_number("lead.value", "(required)", 0, 7, "", "Number of that value.")),
     [](ClusterDraft& d, const Value& v) { lead(d).value = whole<unsigned>(v); }},
    {example("7", whole_number("lead.slave", "(none)", 0, 31, "",
                               "With from = \"monitored\": whose value; one of [[upper.monitored]].")),
     [](ClusterDraft& d, const Value& v) { lead(d).slave = whole<unsigned>(v); }},
    {boolean("lead.signed", "true", "A value that comes as a word, 16 bits, is made longer with its sign."),
     [](ClusterDraft& d, const Value& v) { lead(d).is_signed = flag(v); }},
});

/// Sections of the daemon's rows that both buses have together; of [dds] and [bus] see the rows above.
constexpr auto kShared = std::to_array<std::string_view>({"realtime", "recorder", "dds", "access"});

std::vector<DaemonRow> for_both(std::span<const DaemonRow> rows) {
  std::vector<DaemonRow> wanted;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(wanted), [](const DaemonRow& row) {
    const bool own = std::any_of(kClusterDaemonRows.begin(), kClusterDaemonRows.end(),
                                 [&](const DaemonRow& other) { return other.option.key == row.option.key; });
    return !own && std::find(kShared.begin(), kShared.end(), row.option.section()) != kShared.end();
  });
  for (DaemonRow& row : wanted) row.option.reload = false;
  return wanted;
}

/// In the order of the documents.
constexpr auto kClusterSections = std::to_array<config::Section>({
    {"bus", "", ""},
    {"realtime", "", "Of the one thread that drives both buses."},
    {"recorder", "", ""},
    {"dds", "", ""},
    {"access", "", ""},
    {"cluster", "", ""},
    {"sub_slave", "CANsync numbers",
     "Once for each participant below that may be asked for from above: a slave of the lower bus, or what "
     "stands behind one that is a gateway itself."},
    {"lead", "value numbers",
     "Once for each reference value of the lower bus that is a value of the upper one. A telegram with one "
     "such value is given by the lead axis alone."},
});

}  // namespace

const config::Rows<ClusterDraft>& cluster_option_rows() {
  static const config::Rows<ClusterDraft> all(
      kClusterSections,
      {{std::span<const DaemonRow>(kClusterDaemonRows), &ClusterDraft::daemon},
       {std::span<const DaemonRow>(for_both(rows::daemon_options())), &ClusterDraft::daemon},
       {std::span<const DaemonRow>(for_both(rows::access_options())), &ClusterDraft::daemon},
       std::span<const ClusterRow>(kClusterRows)});
  return all;
}

const config::Table& cluster_options() {
  return cluster_option_rows().table();
}

const config::DocumentHeads cluster_document_heads = {
    .markdown = R"(
# Configuration with bus.protocol = "cansync-cluster"

The daemon is a slave of one bus and the master of another ([cansync-cluster.md](cansync-cluster.md#the-daemon)). Options of the slave stand
below `upper`, those of the master below `lower`, each with the names of the chapters above: `[upper.slave]`, `[[upper.parameter]]`,
`[lower.bus]`, `[[lower.slave]]`, `--set lower.bus.interface=can1`. What both have together stands without a level, in the sections here, and
nowhere else. Every change needs a restart. The smallest file, on two simulated buses:

```toml
[bus]
protocol = "cansync-cluster"

[upper.slave]
number = 5
```
)",
    .file =
        R"(# Configuration of cansyncd as a slave of one bus and the master of another. Options of the slave stand below [upper], those
# of the master below [lower], with the names that `--print-default-config --set bus.protocol=cansync-slave` and the same
# with cansync-master print; here is what both have together. [upper.slave] number is required.
# Printed by `cansyncd --print-default-config --set bus.protocol=cansync-cluster`.
)",
    .man =
        ".Sh OPTIONS WITH BUS.PROTOCOL = CANSYNC-CLUSTER\n"
        "A slave of one bus that is the master of another.\n"
        "Options of the slave stand below upper, those of the master below lower, for example\n"
        ".Li [upper.slave]\n"
        "and\n"
        ".Li [[lower.slave]] .\n"
        "All of them need a restart.\n"};

}  // namespace cansyncd
