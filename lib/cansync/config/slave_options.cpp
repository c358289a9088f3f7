#include <array>

#include "cansync/config/expect.h"
#include "cansync/config/return_parameters.h"
#include "cansync/config/rows.h"
#include "config/fields.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line
using namespace rows;

constexpr std::int64_t kLongestPath = 4096;

constexpr auto kOnReturn = std::to_array<Word<cansync::OnReturn>>({{"release", cansync::OnReturn::release},
                                                                   {"check", cansync::OnReturn::check},
                                                                   {"write", cansync::OnReturn::write}});

constexpr auto kSlaveRows = std::to_array<Row>({
    // --- [slave]
    {whole_number("slave.number", "(required)", 0, 31, "",
                  "Slave number on the bus; makes this slave part of the line."),
     [](Draft& d, const Value&) { slave_settings(d).configured = true; }},
    {example("\"slave0\"", reloadable(name("slave.name", "(\"slaveN\", N = its number)",
                                           "Name of the slave; usable wherever its number is."))),
     [](Draft& d, const Value& v) { d.config.slaves[d.slave].name = words(v); }},
    {example("301", whole_number("slave.status_parameter", "(startup.status_parameter)", 0, 4095, "",
                                 "Parameter number of this slave's status word.")),
     [](Draft& d, const Value& v) { slave_settings(d).status_parameter = whole<std::uint16_t>(v); }},
    {example("5",
             whole_number("slave.status_value", "(none: read by its parameter)", 0, 7, "",
                          "Actual value in which this slave sends its status word: in run "
                          "loss of synchronism is then seen with the next such telegram, and the parameter "
                          "is read only when none comes. In setup the parameter is read.")),
     [](Draft& d, const Value& v) {
       slave_settings(d).status_value = cansync::ActualWord{whole<std::uint8_t>(v), false};
     }},
    {example("true", boolean("slave.status_high", "(false)",
                             "The status word is the high word of status_value; false: its low word.")),
     [](Draft& d, const Value& v) { d.status_high[d.slave] = flag(v); }},
    {example("300", whole_number("slave.block_limit", "(command_channel.block_limit)", 6, 4092, "bytes",
                                 "Longest block of an upload or download this slave takes.")),
     [](Draft& d, const Value& v) { slave_settings(d).block_limit = whole<std::uint16_t>(v); }},
    {example("[0x01, 0x03, 0x05, 0x07]", reloadable(other("slave.actual_registers_1", kRegistersWords,
                                                          "(process.actual_registers_1)", kRegistersHelp))),
     [](Draft& d, const Value& v) { d.actual[d.slave][0].registers = four<std::uint8_t>(v); },
     takes_registers},
    {example("[0, 0, 1, 1]", reloadable(other("slave.actual_values_1", kValuesWords,
                                              "(process.actual_values_1)", kValuesHelp))),
     [](Draft& d, const Value& v) { d.actual[d.slave][0].values = four<int>(v); }, takes_value_numbers},
    {example("[false, true, false, true]",
             reloadable(other("slave.actual_high_1", kFlagsWords, "(process.actual_high_1)", kHighHelp))),
     [](Draft& d, const Value& v) { d.actual[d.slave][0].high = four<bool>(v); }, takes_flags},
    {example("[0x11, 0x13, 0x15, 0x17]", reloadable(other("slave.actual_registers_2", kRegistersWords,
                                                          "(process.actual_registers_2)", kSecondHelp))),
     [](Draft& d, const Value& v) { d.actual[d.slave][1].registers = four<std::uint8_t>(v); },
     takes_registers},
    {example("[4, 4, 5, 5]", reloadable(other("slave.actual_values_2", kValuesWords,
                                              "(process.actual_values_2)", kSecondHelp))),
     [](Draft& d, const Value& v) { d.actual[d.slave][1].values = four<int>(v); }, takes_value_numbers},
    {example("[false, true, false, true]",
             reloadable(other("slave.actual_high_2", kFlagsWords, "(process.actual_high_2)", kSecondHelp))),
     [](Draft& d, const Value& v) { d.actual[d.slave][1].high = four<bool>(v); }, takes_flags},
    field(
        [](auto& d) -> auto& { return d.config.slaves[d.slave].profile; },
        reloadable(
            string("slave.profile", OptionType::text, 0, kLongestPath,
                   "Drive profile of this slave: a name, looked up as NAME.toml in the folder profiles "
                   "beside this file, /etc/cansync/profiles, /usr/local/share/cansync/profiles and "
                   "/usr/share/cansync/profiles; or a file, with '/' or .toml. Empty = none."))),
    chosen<kOnReturn>(
        [](auto& d) -> auto& { return slave_settings(d).on_return; },
        word(
            "slave.on_return",
            "When this slave was away or lost SYNC and is synchronized again: release = it may be used at once; "
            "check = when every return parameter has its value; write = when each was written and read back.")),
    {other(
         "slave.return_parameters", kReturnParametersWords, "[]",
         "The parameters for check and write, in this order. A value is raw, as on the bus: no sign, and at "
         "most 65535 for a word."),
     [](Draft& d, const Value& v) {
       cansync::SlaveSettings& slave = slave_settings(d);
       slave.return_count = 0;
       for (const Scalar& item : v.items) {
         slave.return_parameters[slave.return_count++] = *to_return_parameter(item);
       }
     },
     takes_return_parameters},
    {other(
         "slave.expect", kExpectWords, "[]",
         "Who this drive is: parameters that must have these values, read before it is activated, when it answers "
         "for the first time, after each return and each loss of SYNC. A drive that has others is held out, and "
         "run does not begin. A value of a NUMBER is raw, that of a NAME of the profile in its unit or raw as "
         "0x..; profile = all that the profile says in recognised_by; passport FILE = the lines type and unit of "
         "that passport. Empty = any drive."),
     [](Draft& d, const Value& v) {
       for (const Scalar& item : v.items) d.expect[d.slave].push_back(std::get<std::string>(item));
     },
     takes_expect},
    // --- [slave.value]
    {label("slave.value.number", 7, "Actual value this section names."), [](Draft&, const Value&) {}},
    {example("\"speed\"",
             reloadable(name("slave.value.name", "(the same of [[actual]])", "Name of the actual value."))),
     [](Draft& d, const Value& v) { actual_value(d).name = words(v); }},
    {example("\"rpm\"", reloadable(string("slave.value.unit", OptionType::text, "(the same of [[actual]])", 0,
                                          16, "Unit of the scaled value."))),
     [](Draft& d, const Value& v) { actual_value(d).unit = words(v); }},
    {example("1.0",
             reloadable(real_number("slave.value.factor", "(the same of [[actual]])", true, kFactorHelp))),
     [](Draft& d, const Value& v) { actual_value(d).factor = real(v); }},
    {example("0.0",
             reloadable(real_number("slave.value.offset", "(the same of [[actual]])", false, "See factor."))),
     [](Draft& d, const Value& v) { actual_value(d).offset = real(v); }},
    {example("true", reloadable(boolean("slave.value.signed", "(the same of [[actual]])", kSignedHelp))),
     [](Draft& d, const Value& v) { actual_value(d).is_signed = flag(v); }},
});

}  // namespace

std::span<const Row> rows::slave_options() {
  return kSlaveRows;
}

}  // namespace cansyncd
