#include <array>

#include "cansync/config/rows.h"
#include "config/fields.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line
using namespace rows;

constexpr auto kReaction = std::to_array<Word<LossReaction>>({{"stop_release", LossReaction::stop_release},
                                                              {"hold", LossReaction::hold},
                                                              {"control_word", LossReaction::control_word}});

constexpr auto kFailsafeRows = std::to_array<Row>({
    // --- [failsafe]
    chosen<kReaction>(
        [](auto& d) -> auto& { return d.config.failsafe.reaction; },
        word(
            "failsafe.reaction",
            "When the writer of reference values dies, leaves, misses its deadline, or its values grow too old: "
            "stop_release = its telegram is no longer sent, so that the slaves extrapolate and fault by "
            "themselves; hold = a running release goes on with the last values for hold_intervals, then stops; "
            "control_word = the release stops, and control_word is sent to slaves. New values end each.")),
    field(
        [](auto& d) -> auto& { return d.config.failsafe.hold_intervals; },
        whole_number("failsafe.hold_intervals", 1, 60'000, "intervals",
                     "With reaction \"hold\": intervals for which the last values go on.")),
    {example("0x0000", whole_number("failsafe.control_word", "(none)", 0, 65535, "",
                                    "The control word of reaction \"control_word\", which needs it.")),
     [](Draft& d, const Value& v) { d.config.failsafe.control_word = whole<std::uint16_t>(v); }},
    {example("[0]", other("failsafe.control_word_slaves", kSlavesWords, "(every configured slave)",
                          "Slaves that get that control word.")),
     [](Draft& d, const Value& v) { d.config.failsafe.control_word_slaves = slave_mask(d.config, v); },
     takes_slaves},
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.failsafe.reference_deadline; },
        whole_number(
            "failsafe.reference_deadline_ms", 0, 60'000, "ms",
            "A writer that is alive but gives nothing new for so long has missed its deadline; 0 = not "
            "looked at.")),
    field(
        [](auto& d) -> auto& { return d.config.master.process.too_old_after; },
        whole_number(
            "failsafe.reference_max_intervals", 0, 1'000'000, "intervals",
            "Values without newer ones are too old after so many intervals, exact to the interval, whatever "
            "their release_intervals say; 0 = not looked at.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.failsafe.reference_max_age; },
        reloadable(whole_number(
            "failsafe.reference_max_age_ms", 0, 60'000, "ms",
            "Reference values written longer ago than this are stale and not taken, nor those from as far in "
            "the future; 0 = not looked at. Needs synchronised clocks when writer and daemon run on different "
            "computers."))),
});

}  // namespace

std::span<const Row> rows::failsafe_options() {
  return kFailsafeRows;
}

}  // namespace cansyncd
