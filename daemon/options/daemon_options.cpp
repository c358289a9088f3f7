#include "daemon/config/option_rows.h"

namespace cansyncd {
namespace {

using namespace rows;  // the table reads better without the prefix in every line

constexpr auto kRows = std::to_array<Option>({
    // --- [bus]
    string("bus.name", OptionType::identifier, "(the interface)", 1, 63,
           "Name of the bus; clients find it by this name.",
           [](Draft& d, const Value& v) { d.config.bus.name = words(v); }),
    string("bus.interface", OptionType::identifier, "\"sim\"", 1, 15,
           "\"sim\": simulated line and drives, in real time; else the CAN network interface.",
           [](Draft& d, const Value& v) {
             d.config.bus.interface = words(v);
             d.config.bus.kind = words(v) == "sim" ? BusKind::simulated : BusKind::socketcan;
           }),
    one_number("bus.bit_rate", "1000000", "125000|250000|500000|1000000", "bit/s",
               "Bit rate; it fixes the interval: 8, 4, 2 or 1 ms.",
               [](Draft& d, const Value& v) {
                 d.config.master.bit_rate = cansync::slot_times_for(whole<std::uint32_t>(v))->bit_rate;
               }),
    whole_number("bus.send_margin_us", "(50 bit times)", 0, 1000, "us",
                 "How long before its latest start a telegram is sent; takes up the thread's lateness.",
                 [](Draft& d, const Value& v) {
                   d.config.master.send_margin = std::chrono::microseconds(whole<std::int64_t>(v));
                 }),
    plain("bus.wake_on_frame", OptionType::boolean, "false",
          "CAN interface: wake for every frame, for lower latency and more system calls; false = look for "
          "frames at the SYNC edge and after WRC2.",
          [](Draft& d, const Value& v) { d.config.bus.wake_on_frame = flag(v); }),
    choice(
        "bus.one_shot", "\"prefer\"", "enforce|prefer|ignore",
        "One-shot mode of the controller, in which no telegram goes out late: enforce = send nothing without "
        "it, prefer = say so, ignore = do not ask.",
        [](Draft& d, const Value& v) {
          d.config.bus.one_shot = words(v) == "enforce"  ? OneShot::enforce
                                  : words(v) == "ignore" ? OneShot::ignore
                                                         : OneShot::prefer;
        }),
    whole_number(
        "bus.btr0", "(not given)", 0, 255, "",
        "Bit timing register 0 the line was set up with; with btr1. They must give bit_rate, and fix the "
        "sample point that is asked for.",
        [](Draft& d, const Value& v) { d.config.bus.btr0 = whole<std::uint8_t>(v); }),
    whole_number("bus.btr1", "(not given)", 0, 255, "", "Bit timing register 1; with btr0.",
                 [](Draft& d, const Value& v) { d.config.bus.btr1 = whole<std::uint8_t>(v); }),
    choice(
        "bus.btr_controller", "\"plc\"", "plc|omega",
        "Whose registers btr0 and btr1 are: plc = b maXX PLC (20 MHz), omega = Omega Drive-Line II (16 MHz).",
        [](Draft& d, const Value& v) {
          d.config.bus.registers_of = words(v) == "omega" ? can::Controller::omega : can::Controller::plc;
        }),
    // --- [realtime]
    choice("realtime.mode", "\"ignore\"", "enforce|ignore",
           "enforce: refuse to start when priority, processor or locked memory cannot be had; ignore: say so "
           "once and run anyway.",
           [](Draft& d, const Value& v) {
             d.config.realtime.mode = words(v) == "enforce" ? RealtimeMode::enforce : RealtimeMode::ignore;
           }),
    whole_number("realtime.priority", "60", 0, 98, "",
                 "SCHED_FIFO priority of the realtime thread; 0 = normal scheduling.",
                 [](Draft& d, const Value& v) { d.config.realtime.priority = whole<int>(v); }),
    whole_number("realtime.cpu", "-1", -1, 1023, "", "Processor the realtime thread is bound to; -1 = any.",
                 [](Draft& d, const Value& v) { d.config.realtime.cpu = whole<int>(v); }),
    plain("realtime.lock_memory", OptionType::boolean, "true",
          "Lock all memory, so that no page fault delays the realtime thread.",
          [](Draft& d, const Value& v) { d.config.realtime.lock_memory = flag(v); }),
    whole_number("realtime.request_queue", "256", 16, 65536, "requests",
                 "Requests on their way to the realtime thread; more are refused.",
                 [](Draft& d, const Value& v) { d.config.realtime.request_queue = whole<std::uint32_t>(v); }),
    whole_number("realtime.report_queue", "1024", 16, 65536, "reports",
                 "Reports on their way from the realtime thread; more are lost and counted.",
                 [](Draft& d, const Value& v) { d.config.realtime.report_queue = whole<std::uint32_t>(v); }),
    // --- [recorder]
    string("recorder.folder", OptionType::text, "(the service's state folder, else /var/lib/cansync/NAME)", 0,
           4096,
           "Folder for flight recordings; \"\" = no recorder. Off, too, and said once, when it cannot be "
           "written.",
           [](Draft& d, const Value& v) { d.config.recorder.folder = words(v); }),
    whole_number("recorder.files", "10", 1, 10'000, "recordings",
                 "Recordings of this bus that are kept; the oldest are removed.",
                 [](Draft& d, const Value& v) { d.config.recorder.files = whole<std::uint32_t>(v); }),
    whole_number("recorder.entries", "16384", 256, 1'048'576, "entries",
                 "Things kept in memory: wake-ups, frames, states; about 15 an interval in active operation, "
                 "80 bytes each.",
                 [](Draft& d, const Value& v) { d.config.recorder.entries = whole<std::uint32_t>(v); }),
    whole_number(
        "recorder.intervals_after", "50", 0, 10'000, "intervals",
        "Recording goes on for so long after the fault.",
        [](Draft& d, const Value& v) { d.config.recorder.intervals_after = whole<std::uint32_t>(v); }),
    plain("recorder.bus_off", OptionType::boolean, "true", "Record when the controller goes bus-off.",
          [](Draft& d, const Value& v) { d.config.recorder.triggers.bus_off = flag(v); }),
    whole_number(
        "recorder.syncs_missed", "10", 0, 100'000, "SYNC edges",
        "Record when so many SYNC edges or more were skipped in a row; 0 = never.",
        [](Draft& d, const Value& v) { d.config.recorder.triggers.syncs_missed = whole<std::uint32_t>(v); }),
    plain("recorder.slave_lost", OptionType::boolean, "true", "Record when a slave no longer responds.",
          [](Draft& d, const Value& v) { d.config.recorder.triggers.slave_lost = flag(v); }),
    plain("recorder.second_master", OptionType::boolean, "true",
          "Record when another master sends on the bus.",
          [](Draft& d, const Value& v) { d.config.recorder.triggers.second_master = flag(v); }),
    plain("recorder.sending_failed", OptionType::boolean, "true",
          "Record when telegrams can no longer be handed to the bus.",
          [](Draft& d, const Value& v) { d.config.recorder.triggers.sending_failed = flag(v); }),
    // --- [startup]
    choice("startup.target", "\"active\"", "none|setup|active",
           "How far the daemon goes by itself: none = waits for mode commands; setup = SYNC and command "
           "channel; active = set-up, then active operation as soon as `enable` allows.",
           [](Draft& d, const Value& v) {
             d.config.startup.target = words(v) == "none"    ? StartTarget::none
                                       : words(v) == "setup" ? StartTarget::setup
                                                             : StartTarget::active;
           }),
    choice("startup.enable", "\"all_synchronized\"", "all_synchronized|all_responding|any",
           "When active operation may begin: every configured slave responds and is synchronized, every one "
           "responds, or at once.",
           [](Draft& d, const Value& v) {
             d.config.master.startup.enable = words(v) == "any"              ? EnableRule::any
                                              : words(v) == "all_responding" ? EnableRule::all_responding
                                                                             : EnableRule::all_synchronized;
           }),
    whole_number(
        "startup.activate_command", "2", 2, 255, "",
        "Command number of the action \"SYNC mode: activate\" (unconfirmed).",
        [](Draft& d, const Value& v) { d.config.master.startup.activate_command = whole<std::uint8_t>(v); }),
    whole_number(
        "startup.activate_data", "1", 0, 255, "", "Data byte of that action (unconfirmed).",
        [](Draft& d, const Value& v) { d.config.master.startup.activate_data = whole<std::uint8_t>(v); }),
    whole_number("startup.status_parameter", "301", 0, 4095, "",
                 "Parameter number of the status word of slaves that do not give their own (unconfirmed).",
                 [](Draft& d, const Value& v) {
                   for (auto& slave : d.config.master.slaves)
                     slave.status_parameter = whole<std::uint16_t>(v);
                 }),
    whole_number("startup.status_period_ms", "1000", 0, 3'600'000, "ms",
                 "How often each slave's status word is read in active operation; 0 = never.",
                 [](Draft& d, const Value& v) { d.config.master.startup.status_period = milliseconds(v); }),
    // --- [dds]
    whole_number("dds.domain", "0", 0, 230, "", "DDS domain.",
                 [](Draft& d, const Value& v) { d.config.dds.domain = whole<std::uint32_t>(v); }),
    string("dds.interface", OptionType::identifier, "\"lo\"", 1, 64,
           "Network interface DDS is bound to, by name or address. Anything but lo opens the gateway to that "
           "network.",
           [](Draft& d, const Value& v) { d.config.dds.interface = words(v); }),
    string("dds.partition", OptionType::identifier, "(bus.name)", 1, 63, "DDS partition of all topics.",
           [](Draft& d, const Value& v) { d.config.dds.partition = words(v); }),
    plain("dds.interval_topic", OptionType::boolean, "false",
          "Publish the topic Interval: one sample per interval, right after SYNC.",
          [](Draft& d, const Value& v) { d.config.dds.interval_topic = flag(v); }),
    reloadable(whole_number(
        "dds.request_max_age_ms", "5000", 0, 3'600'000, "ms",
        "Requests written longer ago than this when they arrive, or further in the future, are refused; 0 = "
        "not looked at. Needs synchronised clocks when client and daemon run on different computers.",
        [](Draft& d, const Value& v) { d.config.dds.request_max_age = milliseconds(v); })),
    string("dds.xml", OptionType::text, "\"\"", 0, 65536,
           "Cyclone DDS configuration (XML) used instead of the generated one; interface is not looked at "
           "then.",
           [](Draft& d, const Value& v) { d.config.dds.xml = words(v); }),
    string("dds.security", OptionType::text, "\"\"", 0, 4096,
           "Folder of the daemon's identity, made by cansync-security with role daemon: switches DDS "
           "Security on; empty = off. A relative path starts at the configuration file's folder.",
           [](Draft& d, const Value& v) { d.config.dds.security = words(v); }),
    // --- [sim]
    plain("sim.drives", OptionType::slaves, "(every configured slave)",
          "Slaves that have a simulated drive; the others stay silent.",
          [](Draft& d, const Value& v) { d.config.sim.drives = slave_mask(d.config, v); }),
    whole_number("sim.lock_time_ms", "500", 0, 60'000, "ms",
                 "Time from activation to bit 15 of a drive's status word.",
                 [](Draft& d, const Value& v) { d.config.sim.lock_time = milliseconds(v); }),
    whole_number("sim.seed", "1", 0, INT64_MAX, "", "Seed of everything random in the simulation.",
                 [](Draft& d, const Value& v) { d.config.sim.seed = whole<std::uint64_t>(v); }),
    string("sim.fault_script", OptionType::text, "\"\"", 0, 4096,
           "File with faults to inject; a relative path starts at the configuration file's folder.",
           [](Draft& d, const Value& v) { d.config.sim.fault_script = words(v); }),
    whole_number("sim.memory_bytes", "262144", 4096, 16'777'216, "bytes",
                 "Memory of each drive for uploads and downloads.",
                 [](Draft& d, const Value& v) { d.config.sim.memory = whole<std::uint32_t>(v); }),
    whole_number("sim.missing_references", "10", 0, 65535, "intervals",
                 "Intervals in a row without reference values until a drive faults; 0 = never.",
                 [](Draft& d, const Value& v) { d.config.sim.missing_references = whole<std::uint16_t>(v); }),
    string("sim.trace", OptionType::text, "\"\"", 0, 4096,
           "File for a log of the bus in candump's text format, SYNC edges included; the same as --trace.",
           [](Draft& d, const Value& v) { d.config.sim.trace = words(v); }),
});

}  // namespace

std::span<const Option> rows::daemon_options() {
  return kRows;
}

}  // namespace cansyncd
