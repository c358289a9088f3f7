#include <array>

#include "config/fields.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

constexpr auto kOutput = std::to_array<Word<SyncOutput>>({{"none", SyncOutput::none},
                                                          {"gpio", SyncOutput::gpio},
                                                          {"phc", SyncOutput::phc},
                                                          {"can", SyncOutput::can}});
constexpr auto kInput = std::to_array<Word<SyncInput>>(
    {{"none", SyncInput::none}, {"gpio", SyncInput::gpio}, {"pps", SyncInput::pps}, {"can", SyncInput::can}});
constexpr auto kEdge =
    std::to_array<Word<SyncEdge>>({{"falling", SyncEdge::falling}, {"rising", SyncEdge::rising}});
constexpr auto kPulseEdge =
    std::to_array<Word<SyncEdge>>({{"assert", SyncEdge::rising}, {"clear", SyncEdge::falling}});

constexpr auto kSyncRows = std::to_array<DaemonRow>({
    // --- [sync]
    chosen<kOutput>(
        [](auto& c) -> auto& { return c.sync.output; },
        word(
            "sync.output",
            "Where the SYNC edge goes: none = nowhere (a simulated bus has its own SYNC line); gpio = a GPIO "
            "line; phc = a periodic output of a PTP hardware clock, which the timeline follows; can = the "
            "software SYNC frame, an extension for buses without the SYNC wires, not part of CANsync.")),
    chosen<kEdge>(
        [](auto& c) -> auto& { return c.sync.edge; },
        word("sync.edge",
             "Electrical edge at the GPIO line or the clock's pin that is to be SYNC; rising when a driver "
             "between pin and wires inverts.")),
    field(
        [](auto& c) -> auto& { return c.sync.gpio_chip; },
        string("sync.gpio_chip", OptionType::text, 1, 64,
               "With output \"gpio\": character device of the GPIO chip.")),
    field(
        [](auto& c) -> auto& { return c.sync.gpio_line; },
        whole_number("sync.gpio_line", 0, 65535, "", "With output \"gpio\": line of that chip.")),
    field(
        [](auto& c) -> auto& { return c.sync.phc_device; },
        string("sync.phc_device", OptionType::text, 1, 64,
               "With output \"phc\": character device of the PTP hardware clock.")),
    field(
        [](auto& c) -> auto& { return c.sync.phc_pin; },
        whole_number("sync.phc_pin", -1, 255, "",
                     "With output \"phc\": programmable pin; -1 = the clock's pins are fixed.")),
    field(
        [](auto& c) -> auto& { return c.sync.phc_channel; },
        whole_number("sync.phc_channel", 0, 255, "", "With output \"phc\": periodic output channel.")),
    field(
        [](auto& c) -> auto& { return c.sync.can_identifier; },
        whole_number(
            "sync.can_identifier", 1, 2047, "",
            "With output or input \"can\": identifier of the software SYNC frame, which has no data bytes.")),
    chosen<kInput>(
        [](auto& c) -> auto& { return c.sync.input; },
        word("sync.input",
             "External SYNC that the timeline follows: none = the daemon makes its own; gpio = edges of a "
             "GPIO line; pps = one pulse per second, to which the edges keep their phase; can = the software "
             "SYNC frame of another node.")),
    field(
        [](auto& c) -> auto& { return c.sync.input_gpio_chip; },
        string("sync.input_gpio_chip", OptionType::text, 1, 64,
               "With input \"gpio\": character device of the GPIO chip.")),
    field(
        [](auto& c) -> auto& { return c.sync.input_gpio_line; },
        whole_number("sync.input_gpio_line", 0, 65535, "", "With input \"gpio\": line of that chip.")),
    chosen<kEdge>(
        [](auto& c) -> auto& { return c.sync.input_edge; },
        word("sync.input_edge", "With input \"gpio\": edge that is SYNC.")),
    field(
        [](auto& c) -> auto& { return c.sync.pps_device; },
        string("sync.pps_device", OptionType::text, 1, 64, "With input \"pps\": the pulse source.")),
    chosen<kPulseEdge>(
        [](auto& c) -> auto& { return c.sync.pps_edge; },
        word("sync.pps_edge", "With input \"pps\": edge of the pulse that counts.")),
    duration<std::chrono::nanoseconds>(
        [](auto& c) -> auto& { return c.sync.input_offset; },
        whole_number(
            "sync.input_offset_ns", -1'000'000, 1'000'000, "ns",
            "How long after the input's edges the timeline's stand; makes up for delays of either.")),
    duration<std::chrono::milliseconds>(
        [](auto& c) -> auto& { return c.sync.holdover; },
        whole_number("sync.holdover_ms", 1, 3'600'000, "ms",
                     "How long the timeline holds over without edges until the input counts as lost; then it "
                     "still goes on by itself.")),
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
