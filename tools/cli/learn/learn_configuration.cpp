#include "cli/learn/learn_configuration.h"

#include <fmt/format.h>

#include <array>

#include "cli/learn/configuration_text.h"
#include "cli/learn/learn_points.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using observe::Found;
using observe::Learned;
using observe::Observation;

/// A cursor as the configuration takes it.
std::string cursor_value(const Cursor& cursor) {
  return cursor.kind == Cursor::Kind::fixed ? polled_text(cursor) : toml_quoted(polled_text(cursor));
}

/// An option the recording may tell; as a comment when it does not.
template <class T>
void write_learned(ConfigurationText& text, std::string_view key, std::string_view value,
                   const Found<T>& found) {
  if (found.known())
    text.option(key, value, certainty_text(found.certainty, found.count));
  else
    text.left_out(key, value, "not seen; the default");
}

void write_bus(ConfigurationText& text, const Learned& learned, const MasterSettings& settings,
               const LearnedPlace& place) {
  text.section("[bus]");
  text.option("name", toml_quoted(place.bus), "the name that clients find it by");
  text.option("interface", toml_quoted(place.interface), "the interface of this computer");
  text.option("bit_rate", fmt::format("{}", slot_times(settings.bit_rate).bits_per_second),
              learned.bit_rate.known() ? "inferred from the interval" : "not seen; the default");
  write_learned(text, "send_margin_us", fmt::format("{}", microseconds_of(settings.send_margin)),
                learned.send_margin);
}

void write_startup(ConfigurationText& text, const Learned& learned, const MasterSettings& settings) {
  const StartupSettings& startup = settings.startup;
  text.section("[startup]");
  text.comment("Look at the configuration first, then set \"active\" or leave this out.");
  text.option("target", "\"setup\"", "no reference values until you say so");
  write_learned(text, "enable", toml_quoted(enable_text(startup.enable)), learned.enable);
  write_learned(text, "activate_command", fmt::format("{}", startup.activate_command), learned.activation);
  write_learned(text, "activate_data", fmt::format("{}", startup.activate_data), learned.activation);
  write_learned(text, "status_period_ms", fmt::format("{}", microseconds_of(startup.status_period) / 1000),
                learned.status_period);
  text.comment("Which control words enable a drive is in its manual; no recording tells it.");
  text.comment(fmt::format("enabling_control_bits = {}", startup.enabling_control_bits));
}

void write_learned_mapping(ConfigurationText& text, const char* direction, unsigned channel,
                           const Found<TelegramMapping>& found) {
  if (!found.known()) return;
  const unsigned n = channel + 1;
  text.option(fmt::format("{}_values_{}", direction, n), mapping_numbers(found.value),
              "words by length; which value each is, is a guess by how they move");
  text.option(fmt::format("{}_high_{}", direction, n), mapping_flags(found.value), "likewise");
}

void write_process(ConfigurationText& text, const Learned& learned, const MasterSettings& settings) {
  const ProcessSettings& process = settings.process;
  text.section("[process]");
  for (unsigned c = 0; c < kChannels; ++c)
    write_learned(text, fmt::format("polling_{}", c + 1), cursor_value(process.polling[c]),
                  learned.polling[c]);
  write_learned(text, "maximum_slave", fmt::format("{}", process.maximum_slave.value()),
                learned.maximum_slave);
  write_learned(text, "polling_apart", toml_boolean(process.polling_apart), learned.polling_apart);
  write_learned(text, "poll_nobody", fmt::format("{}", process.poll_nobody), learned.poll_nobody);
  write_learned(text, "full_length", toml_boolean(process.full_length), learned.full_length);
  write_learned(text, "poll_without_reference", toml_boolean(process.poll_without_reference),
                learned.poll_without_reference);
  for (unsigned c = 0; c < kChannels; ++c)
    write_learned_mapping(text, "reference", c, learned.reference_mapping[c]);
}

/// Proposals: a limit that is too tight stops the line.
void write_limits(ConfigurationText& text, const Learned& learned) {
  bool any = false;
  for (const observe::NumberRange& range : learned.reference_range) any = any || range.count > 1;
  if (!any) return;
  text.section("# Limits of reference values: what was on the bus, in numbers without factor and offset.");
  text.comment("Compare them with the machine, add a margin, then remove the signs of comment.");
  text.comment(
      "max_step holds from one telegram to the next: k times the step bears k - 1 missing telegrams.");
  for (unsigned value = 0; value < kValues; ++value) {
    const observe::NumberRange& range = learned.reference_range[value];
    if (range.count < 2) continue;
    text.comment("[[reference]]");
    text.left_out("number", fmt::format("{}", value), text::counted(range.count, "telegram"));
    text.left_out("minimum", fmt::format("{}", range.least), "least number on the bus");
    text.left_out("maximum", fmt::format("{}", range.greatest), "greatest number on the bus");
    if (range.step > 0) text.left_out("max_step", fmt::format("{}", range.step), "greatest step on the bus");
  }
}

void write_channel(ConfigurationText& text, const Learned& learned, const MasterSettings& settings) {
  const CommandChannelSettings& channel = settings.command_channel;
  text.section("[command_channel]");
  write_learned(text, "serving", channel.serving == Serving::scan ? "\"scan\"" : "\"work_conserving\"",
                learned.serving);
  write_learned(text, "address_step", fmt::format("{}", channel.address_step), learned.address_step);
  write_learned(text, "cancel_at_start", toml_boolean(channel.cancel_at_start), learned.cancel_at_start);
  write_learned(text, "repeat_unanswered_writes", toml_boolean(channel.repeat_unanswered_writes),
                learned.repeat_unanswered_writes);
  write_learned(text, "allow_reserved_addresses", toml_boolean(channel.allow_reserved_addresses),
                learned.allow_reserved_addresses);
}

void write_slave(ConfigurationText& text, const Observation& observation, const Learned& learned,
                 const MasterSettings& settings, unsigned number, bool profile) {
  const SlaveSettings& slave = settings.slaves[number];
  const observe::LearnedSlave& of = learned.slave[number];
  const observe::SlaveUse& use = observation.slave[number];
  const std::uint64_t actual = use.actual[0].count + use.actual[1].count;
  text.section("[[slave]]");
  if (use.answers + actual == 0)
    text.comment(use.commands > 0 ? "It was asked and never answered." : "It was polled and never answered.");
  text.option("number", fmt::format("{}", number),
              fmt::format("{}, {}, {} actual value telegrams", text::counted(use.commands, "command"),
                          text::counted(use.answers, "answer"), actual));
  text.comment(fmt::format("name = \"slave{}\"", number));
  write_learned(text, "status_parameter", fmt::format("{}", slave.status_parameter), of.status_parameter);
  write_learned(text, "block_limit", fmt::format("{}", slave.block_limit), of.block_limit);
  for (unsigned c = 0; c < kChannels; ++c) write_learned_mapping(text, "actual", c, of.actual_mapping[c]);
  if (profile)
    text.option("profile", toml_quoted(learned_profile_name(number)),
                "a draft of the parameters that were read");
  text.left_out("expect", "[]", "no recording tells which parameters say who the drive is");
}

}  // namespace

std::string learned_profile_name(unsigned slave) {
  return fmt::format("learned-{}", slave);
}

std::string learned_configuration(const Observation& observation, const Learned& learned,
                                  const LearnedPlace& place) {
  const MasterSettings settings = observe::settings_of(learned);
  ConfigurationText text;
  text.comment(fmt::format("Learned by `cansync learn` from {}: {}.", toml_quoted(place.source),
                           text::counted(observation.frames, "frame")));
  text.comment("seen: it stood on the bus; inferred: it fits what was seen, and another reading might, too.");
  text.comment("Check it with `cansyncd --check`; docs/configuration.md has every option.");
  write_bus(text, learned, settings, place);
  text.section("[sync]");
  text.comment(
      "Where SYNC comes out of this computer; no recording of the bus tells it. With \"none\" no drive locks.");
  text.comment("output = \"gpio\"");
  write_startup(text, learned, settings);
  write_process(text, learned, settings);
  write_channel(text, learned, settings);
  write_limits(text, learned);
  for (const SlaveNumber slave : learned.slaves.value)
    write_slave(text, observation, learned, settings, slave.value(), SlaveMask{place.profiles}.has(slave));
  return text.take();
}

}  // namespace cansync::cli
