#include <algorithm>
#include <array>
#include <iterator>

#include "config/fields.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

constexpr auto kNameInUse =
    std::to_array<Word<NameInUse>>({{"refuse", NameInUse::refuse}, {"event", NameInUse::event}});
constexpr auto kOneShot = std::to_array<Word<OneShot>>(
    {{"enforce", OneShot::enforce}, {"prefer", OneShot::prefer}, {"ignore", OneShot::ignore}});
constexpr auto kRegistersOf =
    std::to_array<Word<can::Controller>>({{"plc", can::Controller::plc}, {"omega", can::Controller::omega}});
constexpr auto kRealtimeMode =
    std::to_array<Word<RealtimeMode>>({{"enforce", RealtimeMode::enforce}, {"ignore", RealtimeMode::ignore}});
constexpr auto kTypes = std::to_array<Word<bool>>({{"appendable", false}, {"final", true}});

constexpr auto kDaemonRows = std::to_array<DaemonRow>({
    // --- [bus]
    {example("\"sim\"", string("bus.name", OptionType::identifier, "(the interface)", 1, 63,
                               "Name of the bus; clients find it by this name.")),
     [](DaemonConfig& c, const Value& v) { c.bus.name = words(v); }},
    {string(
         "bus.interface", OptionType::identifier, 1, 15,
         "\"sim\": simulated line with its drives or nodes, in real time; else the CAN network interface."),
     [](DaemonConfig& c, const Value& v) {
       c.bus.interface = words(v);
       c.bus.kind = words(v) == "sim" ? BusKind::simulated : BusKind::socketcan;
     },
     nullptr, [](DaemonConfig& c) { return value_of(c.bus.interface); }},
    field(
        [](auto& c) -> auto& { return c.bus.adapter; },
        string("bus.adapter", OptionType::text, 0, 127,
               "CAN adapter that the interface must have: path=PATH of its slot or port (udev's ID_PATH), or "
               "serial=NUMBER of a USB device, and channel=N of an adapter with more than one. With another "
               "adapter nothing is sent or received; \"\" = any. `cansync scan INTERFACE` shows it.")),
    field(
        [](auto& c) -> auto& { return c.bus.wake_on_frame; },
        boolean(
            "bus.wake_on_frame",
            "CAN interface: wake for every frame, for lower latency and more system calls; false = look for "
            "frames at the SYNC edge and after WRC2, with general frames every millisecond. A slave always "
            "wakes.")),
    chosen<kOneShot>(
        [](auto& c) -> auto& { return c.bus.one_shot; },
        word(
            "bus.one_shot",
            "One-shot mode of the controller, in which no telegram goes out late, and one that loses the bus "
            "to another node's frame is gone: enforce = send nothing without it, prefer = say so, ignore = "
            "do not ask.")),
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
    chosen<kRegistersOf>(
        [](auto& c) -> auto& { return c.bus.registers_of; },
        word("bus.btr_controller",
             "Whose registers btr0 and btr1 are: plc = b maXX PLC (20 MHz), omega = Omega Drive-Line II (16 "
             "MHz).")),
    // --- [realtime]
    chosen<kRealtimeMode>(
        [](auto& c) -> auto& { return c.realtime.mode; },
        word("realtime.mode",
             "enforce: refuse to start when priority, processor or locked memory cannot be had; ignore: say "
             "so once and run anyway.")),
    field(
        [](auto& c) -> auto& { return c.realtime.priority; },
        whole_number("realtime.priority", 0, 98, "",
                     "SCHED_FIFO priority of the realtime thread; 0 = normal scheduling.")),
    field(
        [](auto& c) -> auto& { return c.realtime.cpu; },
        whole_number("realtime.cpu", -1, 1023, "", "Processor the realtime thread is bound to; -1 = any.")),
    field(
        [](auto& c) -> auto& { return c.realtime.lock_memory; },
        boolean("realtime.lock_memory",
                "Lock all memory, so that no page fault delays the realtime thread.")),
    field(
        [](auto& c) -> auto& { return c.realtime.request_queue; },
        whole_number("realtime.request_queue", 16, 65536, "requests",
                     "Requests on their way to the realtime thread; more are refused.")),
    field(
        [](auto& c) -> auto& { return c.realtime.report_queue; },
        whole_number("realtime.report_queue", 16, 65536, "reports",
                     "Reports on their way from the realtime thread; more are lost and counted.")),
    // --- [recorder]
    {example(
         "\"/var/lib/cansync/sim\"",
         string(
             "recorder.folder", OptionType::text, "(the service's state folder, else /var/lib/cansync/NAME)",
             0, 4096,
             "Folder for flight recordings; \"\" = no recorder. Off, too, and said once, when it cannot be "
             "written.")),
     [](DaemonConfig& c, const Value& v) { c.recorder.folder = words(v); }},
    field(
        [](auto& c) -> auto& { return c.recorder.files; },
        whole_number(
            "recorder.files", 1, 10'000, "recordings",
            "Recordings of this bus that are kept; beyond, the oldest of the most frequent reason goes.")),
    field(
        [](auto& c) -> auto& { return c.recorder.entries; },
        whole_number("recorder.entries", 256, 1'048'576, "entries",
                     "Things kept in memory: wake-ups, frames, states; about 15 an interval in run, 80 "
                     "bytes each.")),
    field(
        [](auto& c) -> auto& { return c.recorder.intervals_after; },
        whole_number("recorder.intervals_after", 0, 10'000, "intervals",
                     "Recording goes on for so long after the fault.")),
    field(
        [](auto& c) -> auto& { return c.recorder.triggers.bus_off; },
        boolean("recorder.bus_off", "Record when the controller goes bus-off.")),
    field(
        [](auto& c) -> auto& { return c.recorder.triggers.syncs_missed; },
        whole_number("recorder.syncs_missed", 0, 100'000, "SYNC edges",
                     "Record when so many SYNC edges or more were skipped in a row; 0 = never.")),
    field(
        [](auto& c) -> auto& { return c.recorder.triggers.slave_lost; },
        boolean("recorder.slave_lost", "Record when a slave no longer responds.")),
    field(
        [](auto& c) -> auto& { return c.recorder.triggers.second_master; },
        boolean("recorder.second_master", "Record when another master sends on the bus.")),
    field(
        [](auto& c) -> auto& { return c.recorder.triggers.sending_failed; },
        boolean("recorder.sending_failed", "Record when telegrams can no longer be handed to the bus.")),
    // --- [dds]
    field(
        [](auto& c) -> auto& { return c.dds.domain; }, whole_number("dds.domain", 0, 230, "", "DDS domain.")),
    field(
        [](auto& c) -> auto& { return c.dds.interface; },
        string(
            "dds.interface", OptionType::identifier, 1, 64,
            "Network interface DDS is bound to, by name. Anything but lo opens the gateway to that network. "
            "While it is missing, down or without an IPv4 address, the daemon serves the clients of this "
            "computer over lo; it joins the network when the interface can be used.")),
    {example("\"sim\"", string("dds.partition", OptionType::identifier, "(bus.name)", 1, 63,
                               "DDS partition of all topics.")),
     [](DaemonConfig& c, const Value& v) { c.dds.partition = words(v); }},
    field(
        [](auto& c) -> auto& { return c.dds.interval_topic; },
        boolean("dds.interval_topic",
                "Publish the topic Interval: one sample per interval, right after SYNC.")),
    duration<std::chrono::milliseconds>(
        [](auto& c) -> auto& { return c.dds.request_max_age; },
        reloadable(whole_number(
            "dds.request_max_age_ms", 0, 3'600'000, "ms",
            "Requests written longer ago than this when they arrive, or further in the future, are refused; 0 = "
            "not looked at. Needs synchronised clocks when client and daemon run on different computers."))),
    chosen<kNameInUse>(
        [](auto& c) -> auto& { return c.dds.name_in_use; },
        word(
            "dds.name_in_use",
            "When a living daemon serves this partition in this domain already: refuse = do not start, or, when "
            "the other one runs on another computer, serve the clients of this computer over lo until the name is "
            "free; event = start, report second_daemon, and let clients ask neither. Looking takes at most 0.3 s.")),
    field(
        [](auto& c) -> auto& { return c.dds.xml; },
        string(
            "dds.xml", OptionType::text, 0, 65536,
            "Cyclone DDS configuration (XML) used instead of the generated one; interface is not looked at "
            "then.")),
    chosen<kTypes>(
        [](auto& c) -> auto& { return c.dds.final_types; },
        word("dds.types",
             "appendable: topics in XCDR2; final: in XCDR1, for implementations of DDS that know no other. "
             "Every program of the bus must have the same.")),
    field(
        [](auto& c) -> auto& { return c.dds.security; },
        string("dds.security", OptionType::text, 0, 4096,
               "Folder of the daemon's identity, made by cansync-security with role daemon: switches DDS "
               "Security on; empty = off. A relative path starts at the configuration file's folder.")),
    // --- [sim]
    field(
        [](auto& c) -> auto& { return c.sim.seed; },
        whole_number("sim.seed", 0, INT64_MAX, "", "Seed of everything random in the simulation.")),
    field(
        [](auto& c) -> auto& { return c.sim.fault_script; },
        string("sim.fault_script", OptionType::text, 0, 4096,
               "File with faults to inject; a relative path starts at the configuration file's folder.")),
    field(
        [](auto& c) -> auto& { return c.sim.trace; },
        string(
            "sim.trace", OptionType::text, 0, 4096,
            "File for a log of the bus in candump's text format, SYNC edges included; the same as --trace.")),
});

constexpr auto kOfIntervals =
    std::to_array<std::string_view>({"recorder.syncs_missed", "recorder.slave_lost", "recorder.second_master",
                                     "dds.interval_topic", "access.profile_rules"});

}  // namespace

std::span<const DaemonRow> rows::daemon_options() {
  return kDaemonRows;
}

std::vector<DaemonRow> rows::without(std::span<const DaemonRow> rows,
                                     std::span<const std::string_view> keys) {
  std::vector<DaemonRow> wanted;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(wanted), [keys](const DaemonRow& row) {
    return std::find(keys.begin(), keys.end(), row.option.key) == keys.end();
  });
  return wanted;
}

std::vector<DaemonRow> rows::without_intervals(std::span<const DaemonRow> rows) {
  return without(rows, kOfIntervals);
}

}  // namespace cansyncd
