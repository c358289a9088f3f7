#include <array>

#include "cansync/config/rows.h"
#include "config/fields.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line
using namespace rows;

using cansync::Serving;
using cansync::SlaveNumber;

constexpr std::string_view kCommonMappingHelp =
    "Mapping of the first actual value telegram, for slaves that do not give their own; forms as above.";
constexpr std::string_view kMappingOne = "(doubleword values 0 and 1, low word first)";
constexpr std::string_view kMappingTwo = "(doubleword values 4 and 5, low word first)";

constexpr auto kServing =
    std::to_array<Word<Serving>>({{"scan", Serving::scan}, {"work_conserving", Serving::work_conserving}});

constexpr auto kLineRows = std::to_array<Row>({
    // --- [process]
    {reloadable(
         other("process.polling_1", kCursorWords, "", "Slave that WRC1 asks for its actual values 0..3.")),
     [](Draft& d, const Value& v) { d.config.master.process.polling[0] = to_cursor(d.config, v); },
     takes_cursor, [](Draft& d) { return to_value(d.config.master.process.polling[0]); }},
    {reloadable(
         other("process.polling_2", kCursorWords, "", "Slave that WRC2 asks for its actual values 4..7.")),
     [](Draft& d, const Value& v) { d.config.master.process.polling[1] = to_cursor(d.config, v); },
     takes_cursor, [](Draft& d) { return to_value(d.config.master.process.polling[1]); }},
    field(
        [](auto& d) -> auto& { return d.config.master.process.polling_apart; },
        boolean(
            "process.polling_apart",
            "The automatic cursor of WRC2 is half a round ahead of WRC1's: every slave has sent one of its two "
            "telegrams in half a round, 32 slaves in 16 intervals; false, as in the manuals: both ask the same "
            "slave.")),
    {example("0",
             reloadable(whole_number("process.maximum_slave", "(the highest configured slave)", 0, 31, "",
                                     "Automatic cursors rise to this slave number and start again at 0."))),
     [](Draft& d, const Value& v) {
       d.config.master.process.maximum_slave = *SlaveNumber::from(whole<std::uint64_t>(v));
     }},
    field(
        [](auto& d) -> auto& { return d.config.master.process.poll_nobody; },
        whole_number(
            "process.poll_nobody", 32, 127, "",
            "Number in the identifier of a reference value telegram that asks no slave (open in the manuals).")),
    field(
        [](auto& d) -> auto& { return d.config.master.process.full_length; },
        boolean("process.full_length",
                "Reference value telegrams always have 8 bytes; false: as many as are mapped (open in the "
                "manuals).")),
    field(
        [](auto& d) -> auto& { return d.config.master.process.poll_without_reference; },
        boolean(
            "process.poll_without_reference",
            "Without released reference values a telegram with no data bytes still asks for actual values; "
            "false, as in the manuals: no telegram, no actual values.")),
    field(
        [](auto& d) -> auto& { return d.config.master.process.release_limit; },
        whole_number("process.release_limit", 1, 1'000'000, "intervals",
                     "Most intervals for which one update may release reference values.")),
    field(
        [](auto& d) -> auto& { return d.config.master.process.ahead_limit; },
        whole_number("process.ahead_limit", 1, 1'000'000, "intervals",
                     "How far ahead reference values may be given.")),
    {example("[0x01, 0x03, 0x05, 0x07]", reloadable(other("process.reference_registers_1", kRegistersWords,
                                                          kMappingOne, kRegistersHelp))),
     [](Draft& d, const Value& v) { d.reference[0].registers = four<std::uint8_t>(v); }, takes_registers},
    {example("[0, 0, 1, 1]",
             reloadable(other("process.reference_values_1", kValuesWords, kMappingOne, kValuesHelp))),
     [](Draft& d, const Value& v) { d.reference[0].values = four<int>(v); }, takes_value_numbers},
    {example("[false, true, false, true]",
             reloadable(other("process.reference_high_1", kFlagsWords, kMappingOne, kHighHelp))),
     [](Draft& d, const Value& v) { d.reference[0].high = four<bool>(v); }, takes_flags},
    {example("[0x11, 0x13, 0x15, 0x17]",
             reloadable(other("process.reference_registers_2", kRegistersWords, kMappingTwo, kSecondHelp))),
     [](Draft& d, const Value& v) { d.reference[1].registers = four<std::uint8_t>(v); }, takes_registers},
    {example("[4, 4, 5, 5]",
             reloadable(other("process.reference_values_2", kValuesWords, kMappingTwo, kSecondHelp))),
     [](Draft& d, const Value& v) { d.reference[1].values = four<int>(v); }, takes_value_numbers},
    {example("[false, true, false, true]",
             reloadable(other("process.reference_high_2", kFlagsWords, kMappingTwo, kSecondHelp))),
     [](Draft& d, const Value& v) { d.reference[1].high = four<bool>(v); }, takes_flags},
    {example("[0x01, 0x03, 0x05, 0x07]", reloadable(other("process.actual_registers_1", kRegistersWords,
                                                          kMappingOne, kCommonMappingHelp))),
     [](Draft& d, const Value& v) { d.actual_common[0].registers = four<std::uint8_t>(v); }, takes_registers},
    {example("[0, 0, 1, 1]",
             reloadable(other("process.actual_values_1", kValuesWords, kMappingOne, kValuesHelp))),
     [](Draft& d, const Value& v) { d.actual_common[0].values = four<int>(v); }, takes_value_numbers},
    {example("[false, true, false, true]",
             reloadable(other("process.actual_high_1", kFlagsWords, kMappingOne, kHighHelp))),
     [](Draft& d, const Value& v) { d.actual_common[0].high = four<bool>(v); }, takes_flags},
    {example("[0x11, 0x13, 0x15, 0x17]",
             reloadable(other("process.actual_registers_2", kRegistersWords, kMappingTwo, kSecondHelp))),
     [](Draft& d, const Value& v) { d.actual_common[1].registers = four<std::uint8_t>(v); }, takes_registers},
    {example("[4, 4, 5, 5]",
             reloadable(other("process.actual_values_2", kValuesWords, kMappingTwo, kSecondHelp))),
     [](Draft& d, const Value& v) { d.actual_common[1].values = four<int>(v); }, takes_value_numbers},
    {example("[false, true, false, true]",
             reloadable(other("process.actual_high_2", kFlagsWords, kMappingTwo, kSecondHelp))),
     [](Draft& d, const Value& v) { d.actual_common[1].high = four<bool>(v); }, takes_flags},
    // --- [command_channel]
    chosen<kServing>(
        [](auto& d) -> auto& { return channel(d).serving; },
        word("command_channel.serving",
             "scan: cursors rise one slave per interval, as in the manuals; work_conserving: straight to the "
             "next slave that has a job.")),
    field(
        [](auto& d) -> auto& { return channel(d).minimum_share; },
        whole_number(
            "command_channel.minimum_share", 0, 65535, "intervals",
            "Parameter jobs, and likewise transfers, get at least one in so many intervals while they "
            "wait, except for control words that stop; 0 = strict priority as in the manuals.")),
    {reloadable(
         other("command_channel.control_word_cursor", kCursorWords, "",
               "Slave whose control words that enable are served; those that stop wait for no cursor.")),
     [](Draft& d, const Value& v) { channel(d).control_word = to_cursor(d.config, v); }, takes_cursor,
     [](Draft& d) { return to_value(channel(d).control_word); }},
    {reloadable(other("command_channel.parameter_cursor", kCursorWords, "",
                      "Slave whose parameter jobs are served.")),
     [](Draft& d, const Value& v) { channel(d).parameter = to_cursor(d.config, v); }, takes_cursor,
     [](Draft& d) { return to_value(channel(d).parameter); }},
    {reloadable(other("command_channel.transfer_cursor", kCursorWords, "",
                      "Slave whose uploads and downloads are served.")),
     [](Draft& d, const Value& v) { channel(d).transfer = to_cursor(d.config, v); }, takes_cursor,
     [](Draft& d) { return to_value(channel(d).transfer); }},
    field(
        [](auto& d) -> auto& { return channel(d).parameter_queue; },
        whole_number("command_channel.parameter_queue", 1, 4096, "jobs",
                     "Open parameter jobs of all slaves together.")),
    field(
        [](auto& d) -> auto& { return channel(d).transfer_queue; },
        whole_number("command_channel.transfer_queue", 1, 1024, "jobs",
                     "Open uploads and downloads of all slaves together.")),
    {whole_number(
         "command_channel.control_word_queue", "8", 1, 64, "jobs",
         "Without effect, and read so that older files are taken: one control word of a slave waits, and a "
         "newer one replaces it."),
     [](Draft& /*d*/, const Value& /*v*/) {}},
    field(
        [](auto& d) -> auto& { return channel(d).broadcast_queue; },
        whole_number("command_channel.broadcast_queue", 1, 64, "jobs", "Waiting broadcasts per priority.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return channel(d).parameter_monitoring; },
        whole_number("command_channel.parameter_timeout_ms", 1, 3'600'000, "ms",
                     "Monitoring time of a parameter job that gives none.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return channel(d).transfer_monitoring; },
        whole_number("command_channel.transfer_timeout_ms", 1, 3'600'000, "ms",
                     "Monitoring time per block of a transfer that gives none.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return channel(d).command_monitoring; },
        whole_number(
            "command_channel.command_timeout_ms", 1, 3'600'000, "ms",
            "Monitoring time of a control word or broadcast that gives none: what was not sent by then ends as "
            "\"timeout\".")),
    field(
        [](auto& d) -> auto& { return channel(d).repeat_unanswered_writes; },
        boolean("command_channel.repeat_unanswered_writes",
                "Send a parameter write again when its answer is missing; false: it ends as \"no answer\".")),
    field(
        [](auto& d) -> auto& { return channel(d).telegram_repeats; },
        whole_number("command_channel.telegram_repeats", 0, 255, "",
                     "Times a failed transfer telegram is sent again.")),
    field(
        [](auto& d) -> auto& { return channel(d).block_retries; },
        whole_number("command_channel.block_retries", 0, 255, "", "Times a failed block is begun again.")),
    {whole_number("command_channel.block_limit", 6, 4092, "bytes",
                  "Longest block of an upload or download, for slaves that do not give their own."),
     [](Draft& d, const Value& v) {
       for (auto& slave : d.config.master.slaves) slave.block_limit = whole<std::uint16_t>(v);
     },
     nullptr, [](Draft& d) { return value_of(slave_settings(d).block_limit); }},
    field(
        [](auto& d) -> auto& { return channel(d).allow_reserved_addresses; },
        boolean("command_channel.allow_reserved_addresses",
                "Allow start addresses 0x00..0xFF, which belong to the slave's operating system.")),
    field(
        [](auto& d) -> auto& { return channel(d).address_step; },
        one_number(
            "command_channel.address_step", "1|4", "bytes",
            "Bytes per start address; 4 if the slaves' addresses count doublewords (open in the manuals).")),
    field(
        [](auto& d) -> auto& { return channel(d).cancel_at_start; },
        boolean(
            "command_channel.cancel_at_start",
            "After a start, and when a slave was away, first cancel on the slave what a master that is gone may "
            "have left open; no transfer begins before.")),
    // --- [reference]
    {label("reference.number", 7, "Reference value this section names."), [](Draft&, const Value&) {}},
    {example("\"speed\"", reloadable(name("reference.name", "(no name)", "Name of the reference value."))),
     [](Draft& d, const Value& v) { reference_value(d).name = words(v); }},
    field(
        [](auto& d) -> auto& { return reference_value(d).unit; },
        reloadable(string("reference.unit", OptionType::text, 0, 16, "Unit of the scaled value."))),
    field(
        [](auto& d) -> auto& { return reference_value(d).factor; },
        reloadable(real_number("reference.factor", true, kFactorHelp))),
    field(
        [](auto& d) -> auto& { return reference_value(d).offset; },
        reloadable(real_number("reference.offset", false, "See factor."))),
    field(
        [](auto& d) -> auto& { return reference_value(d).is_signed; },
        reloadable(boolean("reference.signed", kSignedHelp))),
    // --- [actual]
    {label("actual.number", 7, "Actual value this section names, of all slaves."),
     [](Draft&, const Value&) {}},
    {example("\"speed\"", reloadable(name("actual.name", "(no name)", "Name of the actual value."))),
     [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.name = words(v); }); }},
    {reloadable(string("actual.unit", OptionType::text, 0, 16, "Unit of the scaled value.")),
     [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.unit = words(v); }); }, nullptr,
     [](Draft& d) { return value_of(actual_value(d).unit); }},
    {reloadable(real_number("actual.factor", true, kFactorHelp)),
     [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.factor = real(v); }); }, nullptr,
     [](Draft& d) { return value_of(actual_value(d).factor); }},
    {reloadable(real_number("actual.offset", false, "See factor.")),
     [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.offset = real(v); }); }, nullptr,
     [](Draft& d) { return value_of(actual_value(d).offset); }},
    {reloadable(boolean("actual.signed", kSignedHelp)),
     [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.is_signed = flag(v); }); }, nullptr,
     [](Draft& d) { return value_of(actual_value(d).is_signed); }},
});

}  // namespace

std::span<const Row> rows::line_options() {
  return kLineRows;
}

}  // namespace cansyncd
