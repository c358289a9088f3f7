#include "daemon/layer2/config/file.h"

#include <fmt/format.h>

#include <utility>

#include "config/document.h"
#include "daemon/layer2/config/options.h"
#include "daemon/options/check_daemon.h"

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
    const layer2::ReceiveRange range{found.first.value_or(0), last, found.extended, found.kinds};
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
}

}  // namespace

Layer2File build_layer2_config(config::Settings settings, const std::string& path) {
  Layer2File file;
  file.path = path;
  file.problems = std::move(settings.problems);
  Layer2Draft draft;
  for (const config::Setting& setting : settings.items) {
    draft.number = setting.numbers.empty() ? 0 : static_cast<unsigned>(setting.numbers.front());
    if (auto text = layer2_option_rows().apply(*setting.option, setting.value, draft))
      file.problems.push_back({setting.where, setting.key, std::move(*text)});
  }
  apply_derived(draft.config, settings.items);
  // With wrong values the cross-checks would only complain about what is missing because of them.
  if (file.problems.empty()) {
    Findings findings(settings.items, path);
    check_daemon(draft.config, findings);
    if (!draft.config.dds.security.empty()) {
      findings.problem(
          "dds.security",
          "found an identity; allowed: \"\", because cansync-security gives no rights for general "
          "frames");
    }
    finish_ranges(draft, findings);
    finish_nodes(draft, findings);
    file.problems = std::move(findings.problems());
  }
  config::sort_by_place(file.problems);
  file.config = std::move(draft.config);
  file.settings = std::move(settings.items);
  return file;
}

Layer2File load_layer2_config(const std::string& path, std::span<const std::string> overrides) {
  config::Settings settings = config::resolve(config::read_document(path), layer2_options());
  for (const std::string& assignment : overrides)
    config::override_setting(settings, assignment, layer2_options());
  return build_layer2_config(std::move(settings), path);
}

}  // namespace cansyncd
