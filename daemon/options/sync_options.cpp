#include <array>

#include "daemon/options/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

SyncEdge edge(const Value& value) {
  return words(value) == "falling" || words(value) == "clear" ? SyncEdge::falling : SyncEdge::rising;
}

constexpr auto kSyncRows = std::to_array<DaemonRow>({
    // --- [sync]
    {choice("sync.output", "\"none\"", "none|gpio|phc|can",
            "Where the SYNC edge goes: none = nowhere (a simulated bus has its own SYNC line); gpio = a GPIO "
            "line; phc = a periodic output of a PTP hardware clock, which the timeline follows; can = the "
            "software SYNC frame, an extension for buses without the SYNC wires, not part of CANsync."),
     [](DaemonConfig& c, const Value& v) {
       c.sync.output = words(v) == "gpio"  ? SyncOutput::gpio
                       : words(v) == "phc" ? SyncOutput::phc
                       : words(v) == "can" ? SyncOutput::can
                                           : SyncOutput::none;
     }},
    {choice("sync.edge", "\"falling\"", "falling|rising",
            "Electrical edge at the GPIO line or the clock's pin that is to be SYNC; rising when a driver "
            "between pin and wires inverts."),
     [](DaemonConfig& c, const Value& v) { c.sync.edge = edge(v); }},
    {string("sync.gpio_chip", OptionType::text, "\"/dev/gpiochip0\"", 1, 64,
            "With output \"gpio\": character device of the GPIO chip."),
     [](DaemonConfig& c, const Value& v) { c.sync.gpio_chip = words(v); }},
    {whole_number("sync.gpio_line", "0", 0, 65535, "", "With output \"gpio\": line of that chip."),
     [](DaemonConfig& c, const Value& v) { c.sync.gpio_line = whole<std::uint32_t>(v); }},
    {string("sync.phc_device", OptionType::text, "\"/dev/ptp0\"", 1, 64,
            "With output \"phc\": character device of the PTP hardware clock."),
     [](DaemonConfig& c, const Value& v) { c.sync.phc_device = words(v); }},
    {whole_number("sync.phc_pin", "0", -1, 255, "",
                  "With output \"phc\": programmable pin; -1 = the clock's pins are fixed."),
     [](DaemonConfig& c, const Value& v) { c.sync.phc_pin = whole<int>(v); }},
    {whole_number("sync.phc_channel", "0", 0, 255, "", "With output \"phc\": periodic output channel."),
     [](DaemonConfig& c, const Value& v) { c.sync.phc_channel = whole<std::uint32_t>(v); }},
    {whole_number(
         "sync.can_identifier", "128", 1, 2047, "",
         "With output or input \"can\": identifier of the software SYNC frame, which has no data bytes."),
     [](DaemonConfig& c, const Value& v) { c.sync.can_identifier = whole<std::uint32_t>(v); }},
    {choice("sync.input", "\"none\"", "none|gpio|pps|can",
            "External SYNC that the timeline follows: none = the daemon makes its own; gpio = edges of a "
            "GPIO line; pps = one pulse per second, to which the edges keep their phase; can = the software "
            "SYNC frame of another node."),
     [](DaemonConfig& c, const Value& v) {
       c.sync.input = words(v) == "gpio"  ? SyncInput::gpio
                      : words(v) == "pps" ? SyncInput::pps
                      : words(v) == "can" ? SyncInput::can
                                          : SyncInput::none;
     }},
    {string("sync.input_gpio_chip", OptionType::text, "\"/dev/gpiochip0\"", 1, 64,
            "With input \"gpio\": character device of the GPIO chip."),
     [](DaemonConfig& c, const Value& v) { c.sync.input_gpio_chip = words(v); }},
    {whole_number("sync.input_gpio_line", "0", 0, 65535, "", "With input \"gpio\": line of that chip."),
     [](DaemonConfig& c, const Value& v) { c.sync.input_gpio_line = whole<std::uint32_t>(v); }},
    {choice("sync.input_edge", "\"falling\"", "falling|rising", "With input \"gpio\": edge that is SYNC."),
     [](DaemonConfig& c, const Value& v) { c.sync.input_edge = edge(v); }},
    {string("sync.pps_device", OptionType::text, "\"/dev/pps0\"", 1, 64,
            "With input \"pps\": the pulse source."),
     [](DaemonConfig& c, const Value& v) { c.sync.pps_device = words(v); }},
    {choice("sync.pps_edge", "\"assert\"", "assert|clear",
            "With input \"pps\": edge of the pulse that counts."),
     [](DaemonConfig& c, const Value& v) { c.sync.pps_edge = edge(v); }},
    {whole_number("sync.input_offset_ns", "0", -1'000'000, 1'000'000, "ns",
                  "How long after the input's edges the timeline's stand; makes up for delays of either."),
     [](DaemonConfig& c, const Value& v) {
       c.sync.input_offset = std::chrono::nanoseconds(whole<std::int64_t>(v));
     }},
    {whole_number("sync.holdover_ms", "1000", 1, 3'600'000, "ms",
                  "How long the timeline holds over without edges until the input counts as lost; then it "
                  "still goes on by itself."),
     [](DaemonConfig& c, const Value& v) { c.sync.holdover = milliseconds(v); }},
    {example("1000",
             whole_number(
                 "sync.greatest_step_ns", "(a thousandth of the interval)", 10, 50'000, "ns",
                 "Most by which one interval may be longer or shorter while the timeline follows an input.")),
     [](DaemonConfig& c, const Value& v) {
       c.sync.greatest_step = std::chrono::nanoseconds(whole<std::int64_t>(v));
     }},
});

}  // namespace

std::span<const DaemonRow> rows::sync_options() {
  return kSyncRows;
}

}  // namespace cansyncd
