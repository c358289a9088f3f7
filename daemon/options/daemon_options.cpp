#include <array>

#include "daemon/options/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

constexpr auto kDaemonRows = std::to_array<DaemonRow>({
    // --- [bus]
    {example("\"sim\"", string("bus.name", OptionType::identifier, "(the interface)", 1, 63,
                               "Name of the bus; clients find it by this name.")),
     [](DaemonConfig& c, const Value& v) { c.bus.name = words(v); }},
    {string(
         "bus.interface", OptionType::identifier, "\"sim\"", 1, 15,
         "\"sim\": simulated line with its drives or nodes, in real time; else the CAN network interface."),
     [](DaemonConfig& c, const Value& v) {
       c.bus.interface = words(v);
       c.bus.kind = words(v) == "sim" ? BusKind::simulated : BusKind::socketcan;
     }},
    {boolean("bus.wake_on_frame", "false",
             "CAN interface: wake for every frame, for lower latency and more system calls; false = look for "
             "frames at the SYNC edge and after WRC2, with general frames every millisecond."),
     [](DaemonConfig& c, const Value& v) { c.bus.wake_on_frame = flag(v); }},
    {choice("bus.one_shot", "\"prefer\"", "enforce|prefer|ignore",
            "One-shot mode of the controller, in which no telegram goes out late: enforce = send nothing "
            "without it, prefer = say so, ignore = do not ask."),
     [](DaemonConfig& c, const Value& v) {
       c.bus.one_shot = words(v) == "enforce"  ? OneShot::enforce
                        : words(v) == "ignore" ? OneShot::ignore
                                               : OneShot::prefer;
     }},
    {example(
         "0x40",
         whole_number(
             "bus.btr0", "(not given)", 0, 255, "",
             "Bit timing register 0 the line was set up with; with btr1. They must give bit_rate, and fix "
             "the sample point that is asked for.")),
     [](DaemonConfig& c, const Value& v) { c.bus.btr0 = whole<std::uint8_t>(v); }},
    {example("0x34",
             whole_number("bus.btr1", "(not given)", 0, 255, "", "Bit timing register 1; with btr0.")),
     [](DaemonConfig& c, const Value& v) { c.bus.btr1 = whole<std::uint8_t>(v); }},
    {choice("bus.btr_controller", "\"plc\"", "plc|omega",
            "Whose registers btr0 and btr1 are: plc = b maXX PLC (20 MHz), omega = Omega Drive-Line II (16 "
            "MHz)."),
     [](DaemonConfig& c, const Value& v) {
       c.bus.registers_of = words(v) == "omega" ? can::Controller::omega : can::Controller::plc;
     }},
    // --- [realtime]
    {choice("realtime.mode", "\"ignore\"", "enforce|ignore",
            "enforce: refuse to start when priority, processor or locked memory cannot be had; ignore: say "
            "so once and run anyway."),
     [](DaemonConfig& c, const Value& v) {
       c.realtime.mode = words(v) == "enforce" ? RealtimeMode::enforce : RealtimeMode::ignore;
     }},
    {whole_number("realtime.priority", "60", 0, 98, "",
                  "SCHED_FIFO priority of the realtime thread; 0 = normal scheduling."),
     [](DaemonConfig& c, const Value& v) { c.realtime.priority = whole<int>(v); }},
    {whole_number("realtime.cpu", "-1", -1, 1023, "", "Processor the realtime thread is bound to; -1 = any."),
     [](DaemonConfig& c, const Value& v) { c.realtime.cpu = whole<int>(v); }},
    {boolean("realtime.lock_memory", "true",
             "Lock all memory, so that no page fault delays the realtime thread."),
     [](DaemonConfig& c, const Value& v) { c.realtime.lock_memory = flag(v); }},
    {whole_number("realtime.request_queue", "256", 16, 65536, "requests",
                  "Requests on their way to the realtime thread; more are refused."),
     [](DaemonConfig& c, const Value& v) { c.realtime.request_queue = whole<std::uint32_t>(v); }},
    {whole_number("realtime.report_queue", "1024", 16, 65536, "reports",
                  "Reports on their way from the realtime thread; more are lost and counted."),
     [](DaemonConfig& c, const Value& v) { c.realtime.report_queue = whole<std::uint32_t>(v); }},
    // --- [recorder]
    {example(
         "\"/var/lib/cansync/sim\"",
         string(
             "recorder.folder", OptionType::text, "(the service's state folder, else /var/lib/cansync/NAME)",
             0, 4096,
             "Folder for flight recordings; \"\" = no recorder. Off, too, and said once, when it cannot be "
             "written.")),
     [](DaemonConfig& c, const Value& v) { c.recorder.folder = words(v); }},
    {whole_number("recorder.files", "10", 1, 10'000, "recordings",
                  "Recordings of this bus that are kept; the oldest are removed."),
     [](DaemonConfig& c, const Value& v) { c.recorder.files = whole<std::uint32_t>(v); }},
    {whole_number(
         "recorder.entries", "16384", 256, 1'048'576, "entries",
         "Things kept in memory: wake-ups, frames, states; about 15 an interval in active operation, 80 "
         "bytes each."),
     [](DaemonConfig& c, const Value& v) { c.recorder.entries = whole<std::uint32_t>(v); }},
    {whole_number("recorder.intervals_after", "50", 0, 10'000, "intervals",
                  "Recording goes on for so long after the fault."),
     [](DaemonConfig& c, const Value& v) { c.recorder.intervals_after = whole<std::uint32_t>(v); }},
    {boolean("recorder.bus_off", "true", "Record when the controller goes bus-off."),
     [](DaemonConfig& c, const Value& v) { c.recorder.triggers.bus_off = flag(v); }},
    {whole_number("recorder.syncs_missed", "10", 0, 100'000, "SYNC edges",
                  "Record when so many SYNC edges or more were skipped in a row; 0 = never."),
     [](DaemonConfig& c, const Value& v) { c.recorder.triggers.syncs_missed = whole<std::uint32_t>(v); }},
    {boolean("recorder.slave_lost", "true", "Record when a slave no longer responds."),
     [](DaemonConfig& c, const Value& v) { c.recorder.triggers.slave_lost = flag(v); }},
    {boolean("recorder.second_master", "true", "Record when another master sends on the bus."),
     [](DaemonConfig& c, const Value& v) { c.recorder.triggers.second_master = flag(v); }},
    {boolean("recorder.sending_failed", "true", "Record when telegrams can no longer be handed to the bus."),
     [](DaemonConfig& c, const Value& v) { c.recorder.triggers.sending_failed = flag(v); }},
    // --- [dds]
    {whole_number("dds.domain", "0", 0, 230, "", "DDS domain."),
     [](DaemonConfig& c, const Value& v) { c.dds.domain = whole<std::uint32_t>(v); }},
    {string("dds.interface", OptionType::identifier, "\"lo\"", 1, 64,
            "Network interface DDS is bound to, by name or address. Anything but lo opens the gateway to "
            "that network."),
     [](DaemonConfig& c, const Value& v) { c.dds.interface = words(v); }},
    {example("\"sim\"", string("dds.partition", OptionType::identifier, "(bus.name)", 1, 63,
                               "DDS partition of all topics.")),
     [](DaemonConfig& c, const Value& v) { c.dds.partition = words(v); }},
    {boolean("dds.interval_topic", "false",
             "Publish the topic Interval: one sample per interval, right after SYNC."),
     [](DaemonConfig& c, const Value& v) { c.dds.interval_topic = flag(v); }},
    {reloadable(whole_number(
         "dds.request_max_age_ms", "5000", 0, 3'600'000, "ms",
         "Requests written longer ago than this when they arrive, or further in the future, are refused; 0 = "
         "not looked at. Needs synchronised clocks when client and daemon run on different computers.")),
     [](DaemonConfig& c, const Value& v) { c.dds.request_max_age = milliseconds(v); }},
    {string("dds.xml", OptionType::text, "\"\"", 0, 65536,
            "Cyclone DDS configuration (XML) used instead of the generated one; interface is not looked at "
            "then."),
     [](DaemonConfig& c, const Value& v) { c.dds.xml = words(v); }},
    {string("dds.security", OptionType::text, "\"\"", 0, 4096,
            "Folder of the daemon's identity, made by cansync-security with role daemon: switches DDS "
            "Security on; empty = off. A relative path starts at the configuration file's folder."),
     [](DaemonConfig& c, const Value& v) { c.dds.security = words(v); }},
    // --- [sim]
    {whole_number("sim.seed", "1", 0, INT64_MAX, "", "Seed of everything random in the simulation."),
     [](DaemonConfig& c, const Value& v) { c.sim.seed = whole<std::uint64_t>(v); }},
    {string("sim.fault_script", OptionType::text, "\"\"", 0, 4096,
            "File with faults to inject; a relative path starts at the configuration file's folder."),
     [](DaemonConfig& c, const Value& v) { c.sim.fault_script = words(v); }},
    {string("sim.trace", OptionType::text, "\"\"", 0, 4096,
            "File for a log of the bus in candump's text format, SYNC edges included; the same as --trace."),
     [](DaemonConfig& c, const Value& v) { c.sim.trace = words(v); }},
});

}  // namespace

std::span<const DaemonRow> rows::daemon_options() {
  return kDaemonRows;
}

}  // namespace cansyncd
