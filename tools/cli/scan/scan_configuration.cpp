// The configuration that a scan writes: what was found, each with how it is known.
#include <fmt/format.h>

#include <algorithm>

#include "cli/learn/configuration_text.h"
#include "cli/scan/scan_files.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// Register bytes as the configuration has them: "[1, 3, 5, 7]".
std::string registers_text(const TelegramMapping& mapping) {
  std::string out;
  for (const WordMapping& word : mapping.word)
    out += fmt::format("{}0x{:02X}", out.empty() ? "" : ", ", to_register(word));
  return "[" + out + "]";
}

/// The shortest text that is this number and no whole number of TOML.
std::string real_text(double value) {
  std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string rate_origin(RateSource source) {
  switch (source) {
    case RateSource::typed:
      return "as it was typed";
    case RateSource::interface:
      return "the interface was set to it";
    case RateSource::interval:
      return "told by the interval that was heard";
    case RateSource::tried:
      return "of the four, the one at which frames came";
    case RateSource::unknown:
      break;
  }
  return "not known";
}

/// What all slaves tell alike; nothing when they differ or one does not tell.
std::optional<TelegramMapping> common_reference(const std::vector<FoundSlave>& slaves, unsigned channel) {
  std::optional<TelegramMapping> common;
  for (const FoundSlave& slave : slaves) {
    const auto& told = slave.reference[channel];
    if (!told || (common && !(*common == *told))) return std::nullopt;
    common = told;
  }
  return common;
}

void write_scanned_bus(ConfigurationText& text, const ScannedLine& line) {
  text.section("[bus]");
  text.option("name", toml_quoted(interface_of(line)), "the name that clients find it by");
  text.option("interface", toml_quoted(interface_of(line)),
              line.new_name.empty() ? "the interface of this computer" : "from the next boot on");
  if (line.heard.pin)
    text.option("adapter", toml_quoted(can::text_of(*line.heard.pin)),
                "with another adapter under this name nothing is sent");
  text.option("bit_rate", fmt::format("{}", slot_times(*line.heard.bit_rate).bits_per_second),
              rate_origin(line.heard.rate_source));
  text.section("[sync]");
  text.comment("Where SYNC comes out of this computer; `cansync setup` asks. With \"none\" no drive locks.");
  text.left_out("output", "\"gpio\"", "none, gpio, phc or can");
  text.section("[startup]");
  text.option("target", "\"setup\"", "no reference values until you say so: then \"active\"");
}

void write_scanned_process(ConfigurationText& text, const ScannedLine& line) {
  text.section("[process]");
  for (unsigned channel = 0; channel < kChannels; ++channel) {
    const std::string key = fmt::format("reference_registers_{}", channel + 1);
    const auto common = common_reference(line.slaves, channel);
    if (common && values_fit(*common, channel == 0 ? Channel::one : Channel::two))
      text.option(key, registers_text(*common), "all drives tell it alike");
    else
      text.left_out(key, registers_text(default_mapping(channel == 0 ? Channel::one : Channel::two)),
                    "the drives do not tell it, or not alike; the default");
  }
}

bool is_carried(const FoundSlave& slave, std::uint8_t value) {
  for (unsigned channel = 0; channel < kChannels; ++channel) {
    const TelegramMapping mapping =
        slave.actual[channel].value_or(default_mapping(channel == 0 ? Channel::one : Channel::two));
    if (((mapping.value_mask() >> value) & 1u) != 0) return true;
  }
  return false;
}

/// The parameters by which the profile tells drives apart, with what the drive holds there.
std::string identity_of(const FoundSlave& slave) {
  std::string list;
  for (const profile::Parameter& parameter : slave.profile->parameters) {
    if (parameter.identity == profile::Identity::none) continue;
    const auto found = std::find_if(
        slave.parameters.begin(), slave.parameters.end(),
        [&](const FoundParameter& one) { return one.number == parameter.number && one.error == 0; });
    if (found == slave.parameters.end()) continue;
    list += fmt::format("{}\"{}=0x{:X}\"", list.empty() ? "" : ", ", parameter.name, found->value);
  }
  return list;
}

void write_expect(ConfigurationText& text, const FoundSlave& slave) {
  const std::string list = slave.profile ? identity_of(slave) : "";
  if (slave.twice) {
    text.comment("expect: two drives answered with this number; scan again with one of them.");
  } else if (list.empty()) {
    text.left_out("expect", "[]", "no profile tells which parameters say who the drive is");
  } else {
    text.option("expect", "[" + list + "]",
                "who the drive is; without a serial number any drive of its type");
  }
}

void write_value_names(ConfigurationText& text, const FoundSlave& slave) {
  for (const profile::Parameter& parameter : slave.profile->parameters) {
    if (!parameter.actual_value || !is_carried(slave, *parameter.actual_value)) continue;
    text.section("[[slave.value]]");
    text.option("number", fmt::format("{}", *parameter.actual_value),
                fmt::format("what parameter {} holds", parameter.number));
    text.option("name", toml_quoted(parameter.name), "as the profile calls it");
    text.option("unit", toml_quoted(parameter.unit), "likewise");
    text.option("factor", real_text(parameter.factor), "likewise");
    text.option("offset", real_text(parameter.offset), "likewise");
    text.option("signed", toml_boolean(parameter.is_signed), "likewise");
  }
}

void write_found_slave(ConfigurationText& text, const FoundSlave& slave) {
  text.section("[[slave]]");
  text.option("number", fmt::format("{}", slave.number.value()),
              slave.status_word ? fmt::format("it answered with status word 0x{:04X}", *slave.status_word)
                                : "it answered, and does not give its status word");
  text.left_out("name", fmt::format("\"slave{}\"", slave.number.value()), "a name of your choice");
  if (slave.status_word)
    text.option("status_parameter", fmt::format("{}", slave.status_parameter), "it gave a value");
  else
    text.comment("status_parameter: not under 301; the drive's manual has the number of its status word");
  if (slave.block_limit)
    text.option("block_limit", fmt::format("{}", *slave.block_limit),
                slave.block_limit_told ? "the drive tells it" : "the longest it took in steps of 6 bytes");
  for (unsigned channel = 0; channel < kChannels; ++channel) {
    const std::string key = fmt::format("actual_registers_{}", channel + 1);
    if (slave.actual[channel])
      text.option(key, registers_text(*slave.actual[channel]), "the drive tells it");
    else
      text.left_out(key, registers_text(default_mapping(channel == 0 ? Channel::one : Channel::two)),
                    "the drive does not tell it; the default");
  }
  if (slave.profile)
    text.option("profile", toml_quoted(slave.profile->name), "recognised by its parameters");
  else if (slave.parameters.size() > 1)
    text.option("profile", toml_quoted(scanned_profile_name(slave)),
                "a draft of the parameters that were read");
  write_expect(text, slave);
  if (slave.profile) write_value_names(text, slave);
}

void write_heard_slave(ConfigurationText& text, unsigned number, const observe::HeardSlave& slave) {
  text.section("[[slave]]");
  text.option("number", fmt::format("{}", number),
              fmt::format("heard: {}, RDC1 {}, RDC2 {}", text::counted(slave.answers.count, "answer"),
                          slave.actual[0].count, slave.actual[1].count));
  text.left_out("name", fmt::format("\"slave{}\"", number), "a name of your choice");
}

}  // namespace

std::string scan_configuration(const ScannedLine& line) {
  ConfigurationText text;
  text.comment(fmt::format("Found by `cansync scan` on {}.", toml_quoted(line.heard.interface)));
  text.comment("Next: `cansync setup` with this folder. docs/configuration.md has every option.");
  write_scanned_bus(text, line);
  write_scanned_process(text, line);
  for (const FoundSlave& slave : line.slaves) write_found_slave(text, slave);
  for (unsigned n = 0; line.slaves.empty() && n < kSlaves; ++n)
    if (line.heard.census.slave[n].sends()) write_heard_slave(text, n, line.heard.census.slave[n]);
  return text.take();
}

}  // namespace cansync::cli
