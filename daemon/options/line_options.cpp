#include "daemon/config/option_rows.h"

namespace cansyncd {
namespace {

using namespace rows;  // the table reads better without the prefix in every line

constexpr auto kRows = std::to_array<Option>({
    // --- [process]
    reloadable(
        plain("process.polling_1", OptionType::cursor, "\"automatic\"",
              "Slave that WRC1 asks for its actual values 0..3.",
              [](Draft& d, const Value& v) { d.config.master.process.polling[0] = to_cursor(d.config, v); })),
    reloadable(
        plain("process.polling_2", OptionType::cursor, "\"automatic\"",
              "Slave that WRC2 asks for its actual values 4..7.",
              [](Draft& d, const Value& v) { d.config.master.process.polling[1] = to_cursor(d.config, v); })),
    reloadable(whole_number("process.maximum_slave", "(the highest configured slave)", 0, 31, "",
                            "Automatic cursors rise to this slave number and start again at 0.",
                            [](Draft& d, const Value& v) {
                              d.config.master.process.maximum_slave =
                                  *SlaveNumber::from(whole<std::uint64_t>(v));
                            })),
    whole_number(
        "process.poll_nobody", "127", 32, 127, "",
        "Number in the identifier of a reference value telegram that asks no slave (open in the manuals).",
        [](Draft& d, const Value& v) { d.config.master.process.poll_nobody = whole<std::uint8_t>(v); }),
    plain("process.full_length", OptionType::boolean, "true",
          "Reference value telegrams always have 8 bytes; false: as many as are mapped (open in "
          "the manuals).",
          [](Draft& d, const Value& v) { d.config.master.process.full_length = flag(v); }),
    plain("process.poll_without_reference", OptionType::boolean, "false",
          "Without released reference values a telegram with no data bytes still asks for actual values; "
          "false, as in the manuals: no telegram, no actual values.",
          [](Draft& d, const Value& v) { d.config.master.process.poll_without_reference = flag(v); }),
    whole_number(
        "process.release_limit", "1000", 1, 1'000'000, "intervals",
        "Most intervals for which one update may release reference values.",
        [](Draft& d, const Value& v) { d.config.master.process.release_limit = whole<std::uint32_t>(v); }),
    whole_number(
        "process.ahead_limit", "1000", 1, 1'000'000, "intervals",
        "How far ahead reference values may be given.",
        [](Draft& d, const Value& v) { d.config.master.process.ahead_limit = whole<std::uint32_t>(v); }),
    reloadable(plain("process.reference_registers_1", OptionType::registers, kMappingOne, kRegistersHelp,
                     [](Draft& d, const Value& v) { d.reference[0].registers = four<std::uint8_t>(v); })),
    reloadable(plain("process.reference_values_1", OptionType::value_numbers, kMappingOne, kValuesHelp,
                     [](Draft& d, const Value& v) { d.reference[0].values = four<int>(v); })),
    reloadable(plain("process.reference_high_1", OptionType::flags, kMappingOne, kHighHelp,
                     [](Draft& d, const Value& v) { d.reference[0].high = four<bool>(v); })),
    reloadable(plain("process.reference_registers_2", OptionType::registers, kMappingTwo, kSecondHelp,
                     [](Draft& d, const Value& v) { d.reference[1].registers = four<std::uint8_t>(v); })),
    reloadable(plain("process.reference_values_2", OptionType::value_numbers, kMappingTwo, kSecondHelp,
                     [](Draft& d, const Value& v) { d.reference[1].values = four<int>(v); })),
    reloadable(plain("process.reference_high_2", OptionType::flags, kMappingTwo, kSecondHelp,
                     [](Draft& d, const Value& v) { d.reference[1].high = four<bool>(v); })),
    reloadable(plain("process.actual_registers_1", OptionType::registers, kMappingOne, kCommonMappingHelp,
                     [](Draft& d, const Value& v) { d.actual_common[0].registers = four<std::uint8_t>(v); })),
    reloadable(plain("process.actual_values_1", OptionType::value_numbers, kMappingOne, kValuesHelp,
                     [](Draft& d, const Value& v) { d.actual_common[0].values = four<int>(v); })),
    reloadable(plain("process.actual_high_1", OptionType::flags, kMappingOne, kHighHelp,
                     [](Draft& d, const Value& v) { d.actual_common[0].high = four<bool>(v); })),
    reloadable(plain("process.actual_registers_2", OptionType::registers, kMappingTwo, kSecondHelp,
                     [](Draft& d, const Value& v) { d.actual_common[1].registers = four<std::uint8_t>(v); })),
    reloadable(plain("process.actual_values_2", OptionType::value_numbers, kMappingTwo, kSecondHelp,
                     [](Draft& d, const Value& v) { d.actual_common[1].values = four<int>(v); })),
    reloadable(plain("process.actual_high_2", OptionType::flags, kMappingTwo, kSecondHelp,
                     [](Draft& d, const Value& v) { d.actual_common[1].high = four<bool>(v); })),
    // --- [command_channel]
    choice("command_channel.serving", "\"work_conserving\"", "scan|work_conserving",
           "scan: cursors rise one slave per interval, as in the manuals; work_conserving: straight to the "
           "next slave that has a job.",
           [](Draft& d, const Value& v) {
             channel(d).serving = words(v) == "scan" ? Serving::scan : Serving::work_conserving;
           }),
    whole_number("command_channel.minimum_share", "8", 0, 65535, "intervals",
                 "Parameter jobs, and likewise transfers, get at least one in so many intervals while they "
                 "wait, except for control words that stop; 0 = strict priority as in the manuals.",
                 [](Draft& d, const Value& v) { channel(d).minimum_share = whole<std::uint32_t>(v); }),
    reloadable(plain("command_channel.control_word_cursor", OptionType::cursor, "\"automatic\"",
                     "Slave whose control words that enable are served; those that stop wait for no cursor.",
                     [](Draft& d, const Value& v) { channel(d).control_word = to_cursor(d.config, v); })),
    reloadable(plain("command_channel.parameter_cursor", OptionType::cursor, "\"automatic\"",
                     "Slave whose parameter jobs are served.",
                     [](Draft& d, const Value& v) { channel(d).parameter = to_cursor(d.config, v); })),
    reloadable(plain("command_channel.transfer_cursor", OptionType::cursor, "\"automatic\"",
                     "Slave whose uploads and downloads are served.",
                     [](Draft& d, const Value& v) { channel(d).transfer = to_cursor(d.config, v); })),
    whole_number("command_channel.parameter_queue", "256", 1, 4096, "jobs",
                 "Open parameter jobs of all slaves together.",
                 [](Draft& d, const Value& v) { channel(d).parameter_queue = whole<std::uint16_t>(v); }),
    whole_number("command_channel.transfer_queue", "32", 1, 1024, "jobs",
                 "Open uploads and downloads of all slaves together.",
                 [](Draft& d, const Value& v) { channel(d).transfer_queue = whole<std::uint16_t>(v); }),
    whole_number(
        "command_channel.control_word_queue", "8", 1, 64, "jobs",
        "Without effect, and read so that older files are taken: one control word of a slave waits, and a "
        "newer one replaces it.",
        [](Draft& /*d*/, const Value& /*v*/) {}),
    whole_number("command_channel.broadcast_queue", "8", 1, 64, "jobs", "Waiting broadcasts per priority.",
                 [](Draft& d, const Value& v) { channel(d).broadcast_queue = whole<std::uint16_t>(v); }),
    whole_number("command_channel.parameter_timeout_ms", "3000", 1, 3'600'000, "ms",
                 "Monitoring time of a parameter job that gives none.",
                 [](Draft& d, const Value& v) { channel(d).parameter_monitoring = milliseconds(v); }),
    whole_number("command_channel.transfer_timeout_ms", "30000", 1, 3'600'000, "ms",
                 "Monitoring time per block of a transfer that gives none.",
                 [](Draft& d, const Value& v) { channel(d).transfer_monitoring = milliseconds(v); }),
    whole_number(
        "command_channel.command_timeout_ms", "1000", 1, 3'600'000, "ms",
        "Monitoring time of a control word or broadcast that gives none: what was not sent by then ends as "
        "\"timeout\".",
        [](Draft& d, const Value& v) { channel(d).command_monitoring = milliseconds(v); }),
    plain("command_channel.repeat_unanswered_writes", OptionType::boolean, "false",
          "Send a parameter write again when its answer is missing; false: it ends as \"no answer\".",
          [](Draft& d, const Value& v) { channel(d).repeat_unanswered_writes = flag(v); }),
    whole_number("command_channel.telegram_repeats", "1", 0, 255, "",
                 "Times a failed transfer telegram is sent again.",
                 [](Draft& d, const Value& v) { channel(d).telegram_repeats = whole<std::uint8_t>(v); }),
    whole_number("command_channel.block_retries", "1", 0, 255, "", "Times a failed block is begun again.",
                 [](Draft& d, const Value& v) { channel(d).block_retries = whole<std::uint8_t>(v); }),
    whole_number("command_channel.block_limit", "300", 6, 4092, "bytes",
                 "Longest block of an upload or download, for slaves that do not give their own.",
                 [](Draft& d, const Value& v) {
                   for (auto& slave : d.config.master.slaves) slave.block_limit = whole<std::uint16_t>(v);
                 }),
    plain("command_channel.allow_reserved_addresses", OptionType::boolean, "false",
          "Allow start addresses 0x00..0xFF, which belong to the slave's operating system.",
          [](Draft& d, const Value& v) { channel(d).allow_reserved_addresses = flag(v); }),
    one_number("command_channel.address_step", "1", "1|4", "bytes",
               "Bytes per start address; 4 if the slaves' addresses count doublewords (open in the manuals).",
               [](Draft& d, const Value& v) { channel(d).address_step = whole<std::uint8_t>(v); }),
    // --- [reference]
    whole_number("reference.number", "(required)", 0, 7, "", "Reference value this section names.",
                 [](Draft&, const Value&) {}),
    reloadable(string("reference.name", OptionType::name, "(no name)", 1, 64, "Name of the reference value.",
                      [](Draft& d, const Value& v) { reference_value(d).name = words(v); })),
    reloadable(string("reference.unit", OptionType::text, "\"\"", 0, 16, "Unit of the scaled value.",
                      [](Draft& d, const Value& v) { reference_value(d).unit = words(v); })),
    reloadable(real_number("reference.factor", "1.0", true, kFactorHelp,
                           [](Draft& d, const Value& v) { reference_value(d).factor = real(v); })),
    reloadable(real_number("reference.offset", "0.0", false, "See factor.",
                           [](Draft& d, const Value& v) { reference_value(d).offset = real(v); })),
    reloadable(plain("reference.signed", OptionType::boolean, "true", kSignedHelp,
                     [](Draft& d, const Value& v) { reference_value(d).is_signed = flag(v); })),
    // --- [actual]
    whole_number("actual.number", "(required)", 0, 7, "", "Actual value this section names, of all slaves.",
                 [](Draft&, const Value&) {}),
    reloadable(
        string("actual.name", OptionType::name, "(no name)", 1, 64, "Name of the actual value.",
               [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.name = words(v); }); })),
    reloadable(
        string("actual.unit", OptionType::text, "\"\"", 0, 16, "Unit of the scaled value.",
               [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.unit = words(v); }); })),
    reloadable(real_number(
        "actual.factor", "1.0", true, kFactorHelp,
        [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.factor = real(v); }); })),
    reloadable(real_number(
        "actual.offset", "0.0", false, "See factor.",
        [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.offset = real(v); }); })),
    reloadable(
        plain("actual.signed", OptionType::boolean, "true", kSignedHelp,
              [](Draft& d, const Value& v) { for_all(d, [&](ValueConfig& x) { x.is_signed = flag(v); }); })),
    // --- [slave]
    whole_number("slave.number", "(required)", 0, 31, "",
                 "Slave number on the bus; makes this slave part of the line.",
                 [](Draft& d, const Value&) { slave_settings(d).configured = true; }),
    reloadable(string("slave.name", OptionType::name, "(\"slaveN\", N = its number)", 1, 64,
                      "Name of the slave; usable wherever its number is.",
                      [](Draft& d, const Value& v) { d.config.slaves[d.slave].name = words(v); })),
    whole_number(
        "slave.status_parameter", "(startup.status_parameter)", 0, 4095, "",
        "Parameter number of this slave's status word.",
        [](Draft& d, const Value& v) { slave_settings(d).status_parameter = whole<std::uint16_t>(v); }),
    whole_number("slave.block_limit", "(command_channel.block_limit)", 6, 4092, "bytes",
                 "Longest block of an upload or download this slave takes.",
                 [](Draft& d, const Value& v) { slave_settings(d).block_limit = whole<std::uint16_t>(v); }),
    reloadable(plain(
        "slave.actual_registers_1", OptionType::registers, "(process.actual_registers_1)", kRegistersHelp,
        [](Draft& d, const Value& v) { d.actual[d.slave][0].registers = four<std::uint8_t>(v); })),
    reloadable(plain("slave.actual_values_1", OptionType::value_numbers, "(process.actual_values_1)",
                     kValuesHelp,
                     [](Draft& d, const Value& v) { d.actual[d.slave][0].values = four<int>(v); })),
    reloadable(plain("slave.actual_high_1", OptionType::flags, "(process.actual_high_1)", kHighHelp,
                     [](Draft& d, const Value& v) { d.actual[d.slave][0].high = four<bool>(v); })),
    reloadable(
        plain("slave.actual_registers_2", OptionType::registers, "(process.actual_registers_2)", kSecondHelp,
              [](Draft& d, const Value& v) { d.actual[d.slave][1].registers = four<std::uint8_t>(v); })),
    reloadable(plain("slave.actual_values_2", OptionType::value_numbers, "(process.actual_values_2)",
                     kSecondHelp,
                     [](Draft& d, const Value& v) { d.actual[d.slave][1].values = four<int>(v); })),
    reloadable(plain("slave.actual_high_2", OptionType::flags, "(process.actual_high_2)", kSecondHelp,
                     [](Draft& d, const Value& v) { d.actual[d.slave][1].high = four<bool>(v); })),
    whole_number("slave.value.number", "(required)", 0, 7, "", "Actual value this section names.",
                 [](Draft&, const Value&) {}),
    reloadable(string("slave.value.name", OptionType::name, "(the same of [[actual]])", 1, 64,
                      "Name of the actual value.",
                      [](Draft& d, const Value& v) { actual_value(d).name = words(v); })),
    reloadable(string("slave.value.unit", OptionType::text, "(the same of [[actual]])", 0, 16,
                      "Unit of the scaled value.",
                      [](Draft& d, const Value& v) { actual_value(d).unit = words(v); })),
    reloadable(real_number("slave.value.factor", "(the same of [[actual]])", true, kFactorHelp,
                           [](Draft& d, const Value& v) { actual_value(d).factor = real(v); })),
    reloadable(real_number("slave.value.offset", "(the same of [[actual]])", false, "See factor.",
                           [](Draft& d, const Value& v) { actual_value(d).offset = real(v); })),
    reloadable(plain("slave.value.signed", OptionType::boolean, "(the same of [[actual]])", kSignedHelp,
                     [](Draft& d, const Value& v) { actual_value(d).is_signed = flag(v); })),
});

}  // namespace

std::span<const Option> rows::line_options() {
  return kRows;
}

}  // namespace cansyncd
