#include "layer2/config/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ratio>
#include <utility>

#include "can/frame_length.h"
#include "layer2/config/options.h"

namespace cansyncd {
namespace {

constexpr std::uint32_t largest(bool extended) {
  return extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
}

std::string too_large(std::uint32_t identifier, bool extended) {
  return fmt::format("found 0x{:X}; allowed: 0..0x{:X}{}", identifier, largest(extended),
                     extended ? "" : ", or extended = true beside it");
}

void finish_ranges(Layer2Draft& draft, Findings& findings) {
  for (std::size_t n = 0; n < draft.ranges.size(); ++n) {
    const Layer2Draft::Range& found = draft.ranges[n];
    if (!found.given) continue;
    const std::uint32_t last = found.last.value_or(largest(found.extended));
    const layer2::ReceiveRange range{found.first.value_or(0), last, found.extended, found.kinds,
                                     found.high_priority};
    draft.config.receive.push_back(range);
    const auto problem = layer2::check(range);
    if (problem == layer2::RangeProblem::identifier_too_large) {
      const bool first_is = range.first > largest(range.extended);
      findings.problem(fmt::format("receive.{}.{}", n, first_is ? "first" : "last"),
                       too_large(first_is ? range.first : range.last, range.extended));
    } else if (problem == layer2::RangeProblem::reversed) {
      findings.problem(fmt::format("receive.{}.first", n),
                       fmt::format("found 0x{:X}, which is after last, 0x{:X}; allowed: 0..0x{:X}",
                                   range.first, range.last, range.last));
    }
  }
  if (!draft.config.receive.empty()) return;
  for (const bool extended : {false, true})
    draft.config.receive.push_back({0, largest(extended), extended, layer2::FrameKinds::data_and_remote});
}

void finish_timers(Layer2Draft& draft, Findings& findings) {
  for (unsigned n = 1; n < draft.timers.size(); ++n) {
    Layer2Draft::Timer& found = draft.timers[n];
    if (!found.given) continue;
    found.timer.number = n;
    can::Frame& frame = found.timer.timer.frame;
    if (frame.remote) frame.data = {};
    draft.config.timers.push_back(found.timer);
    if (frame.id > largest(frame.extended))
      findings.problem(fmt::format("timer.{}.identifier", n), too_large(frame.id, frame.extended));
    if (n <= 2 && draft.config.window.used)
      findings.problem(fmt::format("timer.{}.number", n),
                       fmt::format("found {}; allowed: 3..16, because window.used takes timers 1 and 2", n));
  }
}

void finish_window(const Layer2Config& config, Findings& findings) {
  const layer2::WindowSettings& window = config.window;
  if (!window.used) return;
  const auto problem = layer2::check(window);
  if (problem == layer2::WindowProblem::end_after_repeat) {
    findings.problem("window.end_us", "found an end after window.repeat_us; allowed: up to it");
  } else if (problem != layer2::WindowProblem::none) {
    findings.problem("window.end_us", "found an end that is not after window.begin_us; allowed: after it");
  } else if (const std::int64_t least =
                 (can::kLongestFrameBits * 1'000'000LL + config.bus.bits_per_second - 1) /
                 config.bus.bits_per_second;
             window.end - window.begin < std::chrono::microseconds(least)) {
    findings.problem(
        "window.end_us",
        fmt::format("found a window shorter than one longest frame, so that nothing would ever be "
                    "sent; allowed: at least {} us after window.begin_us at {} bit/s",
                    least, config.bus.bits_per_second));
  }
}

void finish_scripts(const ScriptConfig& script, Findings& findings) {
  const std::pair<const char*, const std::vector<std::string>&> all[] = {
      {"script.power_on", script.power_on}, {"script.run", script.run}, {"script.stop", script.stop}};
  for (const auto& [key, lines] : all) {
    for (const layer2::ScriptProblem& problem : read_script(lines, script.rules).problems)
      findings.problem(key,
                       fmt::format("line {}, column {}: {}", problem.line, problem.column, problem.text));
  }
}

std::string_view text_of(layer2::MappingProblem problem) {
  switch (problem) {
    case layer2::MappingProblem::identifier:
      return "identifier too large; allowed: 0..0x7FF, or mapping.extended = true";
    case layer2::MappingProblem::not_in_rule:
      return "mapping.identifier and mapping.mask do not take this identifier: it would never be received";
    case layer2::MappingProblem::bytes:
      return "offset and size are more than 8 together";
    case layer2::MappingProblem::address:
      return "address and size are more than 1024 together";
    case layer2::MappingProblem::address_taken:
      return "another entry fills the same byte of the image";
    case layer2::MappingProblem::bytes_taken:
      return "another entry has the same byte of the telegram";
    case layer2::MappingProblem::messages:
      return "more telegrams than the 128 of a direction";
    case layer2::MappingProblem::interval:
    case layer2::MappingProblem::none:
      break;
  }
  return "";
}

/// What table and timers send again and again must have room on the bus, even without a single stuff bit.
void check_load(const Layer2Config& config, Findings& findings) {
  const std::uint32_t rate = config.bus.bits_per_second;
  if (layer2::DataMapping::check(config.mapping, config.mapped).problem != layer2::MappingProblem::none)
    return;
  layer2::DataMapping table;
  table.configure(config.mapping, config.mapped);
  std::int64_t share = table.share_of_bus(rate);
  if (share > can::kWholeBus) {
    const std::chrono::duration<double, std::milli> interval = config.mapping.interval;
    const double took = interval.count() * static_cast<double>(share) / can::kWholeBus;
    findings.problem(
        "mapping.interval_ms",
        fmt::format(
            "found {} ms, but all telegrams of the table together ({}) take {:.1f} ms at {} bit/s, without any "
            "other frame; allowed: at least {}, fewer telegrams, or mapping.on_change",
            interval.count(), table.telegrams(), took, rate, std::ceil(took)));
    return;
  }
  const auto share_of = [rate](const TimerConfig& timer) { return layer2::share_of_bus(timer.timer, rate); };
  for (const TimerConfig& timer : config.timers) share += share_of(timer);
  if (share <= can::kWholeBus) return;
  const auto most = std::ranges::max_element(config.timers, {}, share_of);
  findings.problem(
      fmt::format("timer.{}.period_us", most->number),
      fmt::format(
          "found {} us, but the timers and the table of the process image together take {} % of the bus at {} "
          "bit/s, without any other frame; allowed: up to 100 %: longer periods, or fewer of them",
          std::chrono::duration_cast<std::chrono::microseconds>(most->timer.period).count(),
          share * 100 / can::kWholeBus, rate));
}

void finish_mapping(Layer2Draft& draft, Findings& findings) {
  draft.config.mapping.table_alone = !draft.mapping_mask;
  draft.config.mapping.rule.mask = draft.mapping_mask.value_or(0);
  draft.config.mapping.rule.identifier = draft.mapping_identifier.value_or(0);
  if (draft.mapping_identifier && !draft.mapping_mask)
    findings.problem(
        "mapping.identifier",
        "found without mapping.mask, so that no bit of it counts; allowed: both, or neither: the "
        "identifiers of [[mapped]] come in then");
  std::vector<std::size_t> numbers;
  for (std::size_t n = 0; n < draft.mapped.size(); ++n) {
    if (!draft.mapped[n].given) continue;
    numbers.push_back(n);
    draft.config.mapped.push_back(draft.mapped[n].bytes);
  }
  if (numbers.empty()) return;
  const auto fault = layer2::DataMapping::check(draft.config.mapping, draft.config.mapped);
  if (fault.problem != layer2::MappingProblem::none)
    findings.problem(fmt::format("mapped.{}.number", numbers[fault.entry]),
                     std::string(text_of(fault.problem)));
}

void finish_objects(Layer2Draft& draft, Findings& findings) {
  for (unsigned n = 0; n < draft.objects.size(); ++n) {
    const Layer2Draft::Object& found = draft.objects[n];
    if (!found.given) continue;
    draft.config.objects.push_back({static_cast<std::uint8_t>(n), found.settings});
    const layer2::MaskRule& rule = found.settings.rule;
    if (rule.identifier > largest(rule.extended))
      findings.problem(fmt::format("object.{}.identifier", n), too_large(rule.identifier, rule.extended));
    if (!draft.config.mapped.empty() && (n == 28 || n == 29)) {
      findings.problem(fmt::format("object.{}.number", n),
                       fmt::format("found {}; allowed: 0..27, 30, 31, because the mapping has 28 and 29", n));
    }
  }
}

void finish_nodes(Layer2Draft& draft, Findings& findings) {
  for (unsigned n = 0; n < draft.nodes.size(); ++n) {
    Layer2Draft::Node& found = draft.nodes[n];
    if (!found.given) continue;
    found.node.number = n;
    draft.config.nodes.push_back(found.node);
    const can::Frame& frame = found.node.frame;
    if (frame.id > largest(frame.extended))
      findings.problem(fmt::format("node.{}.identifier", n), too_large(frame.id, frame.extended));
  }
  // The intervals of faults are made by a node of their own.
  if (!draft.config.sim.fault_script.empty() && draft.config.nodes.size() == draft.nodes.size())
    findings.problem("sim.fault_script",
                     fmt::format("found with {} [[node]]; allowed: up to {} beside a fault script",
                                 draft.nodes.size(), draft.nodes.size() - 1));
}

}  // namespace

layer2::Script read_script(const std::vector<std::string>& lines, const layer2::ScriptRules& rules) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return layer2::parse_script(text, rules);
}

Layer2File build_layer2_config(config::Settings settings, const std::string& path) {
  return build_file(std::move(settings), path, layer2_option_rows(),
                    [](Layer2Draft& draft, Findings& findings) {
                      finish_ranges(draft, findings);
                      finish_timers(draft, findings);
                      finish_window(draft.config, findings);
                      finish_scripts(draft.config.script, findings);
                      finish_mapping(draft, findings);
                      check_load(draft.config, findings);
                      finish_objects(draft, findings);
                      finish_nodes(draft, findings);
                    });
}

Layer2File load_layer2_config(const config::Source& source, std::span<const std::string> overrides) {
  return build_layer2_config(config::read_settings(source, overrides, layer2_options()), source.path);
}

}  // namespace cansyncd
