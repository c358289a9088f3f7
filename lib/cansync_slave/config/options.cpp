#include "cansync_slave/config/options.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <string_view>
#include <vector>

#include "cansync/settings/timing.h"
#include "config/fields.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line
using config::Scalar;

using SlaveRoleRow = config::Row<SlaveRoleDraft>;

SlaveRoleDraft::Monitored& monitored(SlaveRoleDraft& draft) {
  return draft.monitored[draft.number];
}

SimulatedJob& simulated_job(SlaveRoleDraft& draft) {
  SimulatedJob& job = draft.jobs[draft.number];
  job.number = draft.number;
  return job;
}

constexpr std::string_view kRegisterWords = "a list of four numbers 0..127";
constexpr std::string_view kSlaveMappingOne = "(doubleword values 0 and 1, low word first)";
constexpr std::string_view kSlaveMappingTwo = "(doubleword values 4 and 5, low word first)";

bool takes_register_bytes(const SlaveRoleDraft& /*draft*/, const Value& value) {
  constexpr int kMostRegister = 127;
  return value.kind == Value::Kind::list && value.items.size() == cansync::kWords &&
         std::all_of(value.items.begin(), value.items.end(), [](const Scalar& item) {
           const auto* number = std::get_if<std::int64_t>(&item);
           return number != nullptr && *number >= 0 && *number <= kMostRegister;
         });
}

void put_registers(const Value& value, MappingBytes& out) {
  out.emplace();
  std::transform(value.items.begin(), value.items.end(), out->begin(),
                 [](const Scalar& item) { return static_cast<std::uint8_t>(std::get<std::int64_t>(item)); });
}

/// A row of register bytes with its example.
constexpr Option registers_one(std::string_view key, std::string_view help) {
  return example("[0x01, 0x03, 0x05, 0x07]", other(key, kRegisterWords, kSlaveMappingOne, help));
}
constexpr Option registers_two(std::string_view key, std::string_view help) {
  return example("[0x11, 0x13, 0x15, 0x17]", other(key, kRegisterWords, kSlaveMappingTwo, help));
}

constexpr auto kSlaveProtocolRow = std::to_array<DaemonRow>({
    {rows::protocol_option(kSlaveProtocol, "\"cansync-slave\""), [](DaemonConfig&, const Value&) {}},
});

constexpr std::int64_t kLongestProfilePath = 4096;

constexpr auto kSlaveTarget = std::to_array<Word<SlaveTarget>>(
    {{"none", SlaveTarget::none}, {"setup", SlaveTarget::setup}, {"active", SlaveTarget::active}});

constexpr auto kReactions =
    std::to_array<Word<cansync::SlaveReaction>>({{"report", cansync::SlaveReaction::report},
                                                 {"quick_stop", cansync::SlaveReaction::quick_stop},
                                                 {"pulse_inhibit", cansync::SlaveReaction::pulse_inhibit}});

constexpr auto kSlaveRoleRows = std::to_array<SlaveRoleRow>({
    // --- [bus]
    {one_number("bus.bit_rate", "", "125000|250000|500000|1000000", "bit/s",
                "Bit rate; it fixes the interval: 8, 4, 2 or 1 ms."),
     [](SlaveRoleDraft& d, const Value& v) {
       d.config.bus.bits_per_second = whole<std::uint32_t>(v);
       const auto times = *cansync::slot_times_for(d.config.bus.bits_per_second);
       d.config.slave.bit_rate = times.bit_rate;
       d.config.supervision.interval = times.interval;
     },
     nullptr, [](SlaveRoleDraft& d) { return value_of(d.config.bus.bits_per_second); }},
    // --- [slave]
    {example("5", whole_number("slave.number", "(required)", 0, 31, "",
                               "Slave number on the bus; every slave of a bus needs another one.")),
     [](SlaveRoleDraft& d, const Value& v) {
       d.numbered = true;
       d.config.slave.number = *cansync::SlaveNumber::from(whole<std::uint64_t>(v));
     }},
    chosen<kSlaveTarget>(
        [](auto& d) -> auto& { return d.config.target; },
        word("slave.target",
             "How far the slave goes by itself: none = it hears nothing; setup = actions, parameters and "
             "transfers; active = reference and actual values, too.")),
    field(
        [](auto& d) -> auto& { return d.config.slave.activate_command; },
        whole_number("slave.activate_command", 2, 255, "",
                     "Command number of the action \"SYNC mode: activate\" (unconfirmed).")),
    field(
        [](auto& d) -> auto& { return d.config.slave.activate_data; },
        whole_number("slave.activate_data", 0, 255, "", "Data byte of that action (unconfirmed).")),
    field(
        [](auto& d) -> auto& { return d.config.status_parameter; },
        whole_number("slave.status_parameter", 0, 4095, "",
                     "Parameter number under which the daemon itself answers with the status word "
                     "(unconfirmed).")),
    field(
        [](auto& d) -> auto& { return d.config.status_bits; },
        whole_number("slave.status_bits", 0, 0x7FFF, "",
                     "Bits 0..14 of that status word; bit 15 says that the slave is synchronized.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.supervision.lock_time; },
        whole_number("slave.lock_time_ms", 0, 60'000, "ms",
                     "From the master's activation, with SYNC edges coming, until bit 15 is set.")),
    field(
        [](auto& d) -> auto& { return d.config.supervision.misses_until_fault; },
        whole_number(
            "slave.missing_references", 0, 65535, "intervals",
            "Intervals in a row without reference values, after the first, until that is a fault; 0 = "
            "never.")),
    chosen<kReactions>(
        [](auto& d) -> auto& { return d.config.supervision.on_references_missing; },
        word("slave.on_references_missing",
             "What the application is told to do then; the daemon itself moves nothing.")),
    chosen<kReactions>(
        [](auto& d) -> auto& { return d.config.supervision.on_sync_lost; },
        word("slave.on_sync_lost",
             "What the application is told to do when SYNC edges were missing for sync.holdover_ms.")),
    field(
        [](auto& d) -> auto& { return d.unknown_parameter_error; },
        whole_number("slave.unknown_parameter_error", 1, 0xFFFF, "",
                     "Error number for parameters that stand in no [[parameter]] and that no application has "
                     "taken over: 0xFFFA = not available now, 0xFFFB = there is none.")),
    field(
        [](auto& d) -> auto& { return d.config.profile; },
        string("slave.profile", OptionType::text, 0, kLongestProfilePath,
               "Drive profile of this slave, whose parameters the daemon answers for: a name, looked up as "
               "NAME.toml in the folder profiles beside this file, /etc/cansync/profiles, "
               "/usr/local/share/cansync/profiles and /usr/share/cansync/profiles; or a file, with '/' or "
               ".toml. Empty = none.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.service.jobs.answer_time; },
        whole_number("slave.answer_time_ms", 0, 600'000, "ms",
                     "In which an application has to answer a parameter job; then the master is answered "
                     "without it. 0 = without end.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.service.area.monitoring; },
        whole_number("slave.block_time_ms", 0, 600'000, "ms",
                     "In which something of an upload or download has to move; then it ends with 0x0103. 0 = "
                     "without end.")),
    field(
        [](auto& d) -> auto& { return d.config.service.area.area; },
        boolean("slave.block_area",
                "Blocks of up to 300 bytes reach the application as a whole; false: telegram by telegram, as "
                "longer ones.")),
    field(
        [](auto& d) -> auto& { return d.config.slave.block_limit; },
        whole_number(
            "slave.block_limit", 1, 4095, "bytes",
            "Longest block that the master may ask for. An upload whose length it leaves to the slave is as long as the application says.")),
    field(
        [](auto& d) -> auto& { return d.config.slave.full_length; },
        boolean("slave.full_length",
                "Actual value telegrams always have 8 bytes; false: as many as are mapped (open in the "
                "manuals).")),
    {registers_one("slave.reference_registers_1",
                   "How WRC1 becomes reference values 0..3: the mapping, as four register bytes, word 0 "
                   "first: bit 0 assigned, bit 1 high word, bits 2..6 value number; 0x0D = low word of value "
                   "3. The master's mapping must be the same."),
     [](SlaveRoleDraft& d, const Value& v) { put_registers(v, d.reference[0]); }, takes_register_bytes},
    {registers_two("slave.reference_registers_2", "As above, of WRC2 and reference values 4..7."),
     [](SlaveRoleDraft& d, const Value& v) { put_registers(v, d.reference[1]); }, takes_register_bytes},
    {registers_one("slave.actual_registers_1",
                   "How actual values 0..3 become RDC1: as above. The master's mapping of this slave must be "
                   "the same."),
     [](SlaveRoleDraft& d, const Value& v) { put_registers(v, d.actual[0]); }, takes_register_bytes},
    {registers_two("slave.actual_registers_2", "As above, of actual values 4..7 and RDC2."),
     [](SlaveRoleDraft& d, const Value& v) { put_registers(v, d.actual[1]); }, takes_register_bytes},
    // --- [[monitored]]
    {config::rows::label("monitored.number", 31,
                         "Number of a slave whose actual values are listened to; not the own one."),
     [](SlaveRoleDraft& d, const Value&) { monitored(d).given = true; }},
    {registers_one("monitored.registers_1", "How its RDC1 becomes values 0..3: as in [slave]."),
     [](SlaveRoleDraft& d, const Value& v) { put_registers(v, monitored(d).mapping[0]); },
     takes_register_bytes},
    {registers_two("monitored.registers_2", "How its RDC2 becomes values 4..7."),
     [](SlaveRoleDraft& d, const Value& v) { put_registers(v, monitored(d).mapping[1]); },
     takes_register_bytes},
});

constexpr auto kSimulatedJobRows = std::to_array<SlaveRoleRow>({
    {config::rows::label("sim.job.number", 99, "Number of the job."),
     [](SlaveRoleDraft& d, const Value&) { (void)simulated_job(d); }},
    {whole_number("sim.job.parameter", "(none)", 0, 4095, "", "Parameter that is read, or written."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).parameter = whole<std::uint16_t>(v); }},
    {whole_number("sim.job.value", "(none: it is read)", INT32_MIN, UINT32_MAX, "",
                  "Raw value that is written."),
     [](SlaveRoleDraft& d, const Value& v) {
       simulated_job(d).value = static_cast<std::uint32_t>(whole<std::int64_t>(v));
     }},
    {whole_number("sim.job.sub_slave", "0", 0, 65535, "", "Sub-slave address of all that; 0 = this slave."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).sub_slave = whole<std::uint16_t>(v); }},
    {whole_number("sim.job.bytes", "(none)", 1, 4092, "bytes", "Length of a block that is moved instead."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).bytes = whole<std::uint16_t>(v); }},
    {whole_number("sim.job.address", "0x100", 0x100, UINT32_MAX, "", "Its start address."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).address = whole<std::uint32_t>(v); }},
    {boolean("sim.job.download", "false", "It goes to the slave, byte n is n modulo 256; false: from it."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).download = flag(v); }},
    {whole_number("sim.job.control_word", "(none)", 0, 65535, "", "Control word that is given instead."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).control_word = whole<std::uint16_t>(v); }},
    {whole_number("sim.job.action", "(none)", 128, 255, "", "Command of the action that is given instead."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).action = whole<std::uint8_t>(v); }},
    {whole_number("sim.job.data_byte", "0", 0, 255, "", "Its data byte."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).data_byte = whole<std::uint8_t>(v); }},
    {whole_number("sim.job.data_word", "0", 0, 65535, "", "Its data word."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).data_word = whole<std::uint16_t>(v); }},
    {whole_number("sim.job.every", "1000", 1, 1'000'000, "intervals", "It is asked again after so many."),
     [](SlaveRoleDraft& d, const Value& v) { simulated_job(d).every = whole<std::uint32_t>(v); }},
});

/// Options of the daemon that mean nothing to a slave: it has no slaves, makes no SYNC edge and misses none
/// of its own.
constexpr auto kForMastersAlone = std::to_array<std::string_view>(
    {"recorder.syncs_missed", "recorder.slave_lost", "recorder.second_master", "dds.interval_topic",
     "access.profile_rules", "sync.output", "sync.edge", "sync.gpio_chip", "sync.gpio_line",
     "sync.phc_device", "sync.phc_pin", "sync.phc_channel"});

constexpr std::string_view kInputHelp =
    "Where the master's SYNC comes from, on a CAN interface; a simulated bus brings its own. gpio = edges of a "
    "GPIO line; pps = one pulse per second, to which the edges keep their phase; can = the software SYNC frame; "
    "none = nowhere: the slave is never synchronized.";
constexpr std::string_view kHoldoverHelp =
    "How long edges may be missing until the slave is not synchronized any more; until then its intervals go "
    "on by themselves.";

std::vector<DaemonRow> for_slaves(std::span<const DaemonRow> rows) {
  std::vector<DaemonRow> wanted = rows::without(rows, kForMastersAlone);
  for (DaemonRow& row : wanted) {
    if (row.option.key == "sync.input") row.option.help = kInputHelp;
    if (row.option.key == "sync.holdover_ms") row.option.help = kHoldoverHelp;
  }
  return wanted;
}

/// In the order of the documents.
constexpr auto kSlaveSections = std::to_array<config::Section>({
    {"bus", "", ""},
    {"realtime", "", ""},
    {"recorder", "", ""},
    {"dds", "", ""},
    {"access", "", ""},
    {"metrics", "", ""},
    {"sim", "", ""},
    {"sim.job", "job numbers",
     "On the simulated bus: what the simulated master asks of the slave, again and again: a parameter or a "
     "block."},
    {"sync", "", ""},
    {"slave", "", ""},
    {"monitored", "slave numbers", "Once for each other slave whose actual values are listened to."},
    cansync_slave::kParameterSection,
});

}  // namespace

const config::Rows<SlaveRoleDraft>& slave_option_rows() {
  static const config::Rows<SlaveRoleDraft> all(
      kSlaveSections,
      {{std::span<const DaemonRow>(kSlaveProtocolRow), &SlaveRoleDraft::config},
       {std::span<const DaemonRow>(for_slaves(rows::daemon_options())), &SlaveRoleDraft::config},
       {std::span<const DaemonRow>(for_slaves(rows::access_options())), &SlaveRoleDraft::config},
       {rows::metrics_options(), &SlaveRoleDraft::config},
       {std::span<const DaemonRow>(for_slaves(rows::sync_options())), &SlaveRoleDraft::config},
       std::span<const SlaveRoleRow>(kSlaveRoleRows),
       std::span<const SlaveRoleRow>(kSimulatedJobRows),
       {cansync_slave::parameter_rows(), &SlaveRoleDraft::parameters}});
  return all;
}

const config::Table& slave_options() {
  return slave_option_rows().table();
}

const config::DocumentHeads slave_document_heads = {
    .markdown = R"(
# Configuration with bus.protocol = "cansync-slave"

The daemon is a slave on a line that another one's master drives ([cansync-slave.md](cansync-slave.md)). The smallest file is
`bus.protocol = "cansync-slave"` and `slave.number`: a simulated bus with a simulated master.

After SIGHUP the options marked "running" take effect at once.
)",
    .file =
        R"(# Configuration of cansyncd as a slave of CANsync with every option. What is not commented out stands at its default;
# delete what you do not change. Printed by `cansyncd --print-default-config --set bus.protocol=cansync-slave`.
)",
    .man =
        ".Sh OPTIONS WITH BUS.PROTOCOL = CANSYNC-SLAVE\n"
        "A slave on a line that another one's master drives.\n"
        "Those that do not say \"changes while running\" need a restart.\n"};

}  // namespace cansyncd
