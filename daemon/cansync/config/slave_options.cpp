#include "daemon/config/option_rows.h"
#include "daemon/config/return_parameters.h"

// Slaves that come and go: what is done when one is lost, and what one that returns has to pass.
namespace cansyncd {
namespace {

using namespace rows;

constexpr std::int64_t kLongestPath = 4096;

constexpr auto kRows = std::to_array<Option>({
    reloadable(string("slave.profile", OptionType::text, "\"\"", 0, kLongestPath,
                      "Drive profile of this slave: a name, looked up as NAME.toml in the folder profiles "
                      "beside this file, /etc/cansync/profiles, /usr/local/share/cansync/profiles and "
                      "/usr/share/cansync/profiles; or a file, with '/' or .toml. Empty = none.",
                      [](Draft& d, const Value& v) { d.config.slaves[d.slave].profile = words(v); })),
    whole_number(
        "startup.lost_after", "3", 1, 255, "telegrams",
        "Unanswered telegrams in a row until a slave counts as lost. Then its jobs end, and new ones are "
        "refused until it answers again.",
        [](Draft& d, const Value& v) { d.config.master.startup.lost_after = whole<std::uint8_t>(v); }),
    whole_number(
        "startup.enabling_control_bits", "15", 0, 65535, "",
        "A control word with all of these bits enables a drive. It is refused for a slave that is lost, or "
        "was away or lost SYNC and is not released yet; others always pass, so that a drive can be stopped. "
        "0 = none is refused.",
        [](Draft& d, const Value& v) {
          d.config.master.startup.enabling_control_bits = whole<std::uint16_t>(v);
        }),
    plain(
        "command_channel.cancel_at_start", OptionType::boolean, "true",
        "After a start, and when a slave was away, first cancel on the slave what a master that is gone may "
        "have left open; no transfer begins before.",
        [](Draft& d, const Value& v) { channel(d).cancel_at_start = flag(v); }),
    choice(
        "slave.on_return", "\"release\"", "release|check|write",
        "When this slave was away or lost SYNC and is synchronized again: release = it may be used at once; "
        "check = when every return parameter has its value; write = when each was written and read back.",
        [](Draft& d, const Value& v) {
          using cansync::OnReturn;
          slave_settings(d).on_return = words(v) == "check"   ? OnReturn::check
                                        : words(v) == "write" ? OnReturn::write
                                                              : OnReturn::release;
        }),
    plain("slave.return_parameters", OptionType::parameter_values, "[]",
          "The parameters for check and write, in this order. A value is raw, as on the bus: no sign, and at "
          "most 65535 for a word.",
          [](Draft& d, const Value& v) {
            cansync::SlaveSettings& slave = slave_settings(d);
            slave.return_count = 0;
            for (const Scalar& item : v.items) {
              slave.return_parameters[slave.return_count++] = *to_return_parameter(item);
            }
          }),
});

}  // namespace

std::span<const Option> rows::slave_options() {
  return kRows;
}

}  // namespace cansyncd
