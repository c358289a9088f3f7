#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "cansync/cluster/cluster.h"

namespace cansync {
namespace {

using Problems = std::vector<SettingProblem>;

std::string number_text(std::uint64_t number) {
  return std::to_string(number);
}

Channel channel_of_lead(std::uint8_t value) {
  return value < kWords ? Channel::one : Channel::two;
}

std::string source_text(const LeadSource& source) {
  const std::string value = number_text(source.value);
  switch (source.kind) {
    case LeadSource::Kind::none:
      return "nothing";
    case LeadSource::Kind::reference:
      return "reference value " + value + " of the upper bus";
    case LeadSource::Kind::actual:
      return "actual value " + value + " of the gateway itself";
    case LeadSource::Kind::monitored:
      break;
  }
  return "actual value " + value + " of slave " + number_text(source.slave.value()) + " of the upper bus";
}

void check_routes(Problems& problems, const ClusterSettings& settings) {
  for (std::size_t i = 0; i < settings.gateway.routes.size(); ++i) {
    const SubSlaveRoute& route = settings.gateway.routes[i];
    const std::string field = "gateway.routes[" + number_text(i) + "].";
    const std::string found = number_text(route.number.value);
    if (route.number.value == 0) problems.push_back({field + "number", found, "1..65535; 0 is the gateway"});
    if (route.number.value != 0 && route.number == settings.gateway.own_number)
      problems.push_back({field + "number", found, "another number than the gateway's own"});
    const auto before = std::span(settings.gateway.routes).first(i);
    if (std::ranges::find(before, route.number, &SubSlaveRoute::number) != before.end())
      problems.push_back({field + "number", found, "a number that no other route has"});
    if (!settings.lower.slaves[route.slave.value()].configured)
      problems.push_back({field + "slave", number_text(route.slave.value()), "a slave of the lower bus"});
  }
}

/// The mapping by which a source comes; null: by none, it is a value of 32 bits.
const ProcessMapping* mapping_of(const ClusterSettings& settings, const LeadSource& source) {
  if (source.kind == LeadSource::Kind::reference) return &settings.upper.reference_mapping;
  if (source.kind != LeadSource::Kind::monitored) return nullptr;
  const auto& mapping = settings.upper.monitored[source.slave.value()];
  return mapping ? &*mapping : nullptr;
}

void check_source(Problems& problems, const ClusterSettings& settings, std::uint8_t value) {
  const LeadSource& source = settings.lead[value];
  const std::string field = "lead[" + number_text(value) + "]";
  if (source.value >= kValues) {
    problems.push_back({field, number_text(source.value), "value 0..7"});
    return;
  }
  const ProcessMapping* mapping = mapping_of(settings, source);
  if (source.kind == LeadSource::Kind::monitored && mapping == nullptr) {
    problems.push_back({field, source_text(source), "a slave that the gateway monitors"});
    return;
  }
  const auto in = [](const ProcessMapping& of, std::uint8_t number) {
    return (of[index(channel_of_lead(number))].value_mask() >> number) & 1u;
  };
  if (mapping != nullptr && in(*mapping, source.value) == 0)
    problems.push_back({field, source_text(source), "a value that a telegram brings"});
  const ProcessMapping& lower = settings.lower.process.reference_mapping;
  if (in(lower, value) == 0) {
    problems.push_back({field, "reference value " + number_text(value) + " of the lower bus",
                        "a value that the lower reference mapping carries"});
  }
  const bool from_word = mapping != nullptr && ((word_mask(*mapping) >> source.value) & 1u) != 0;
  const bool to_word = ((word_mask(lower) >> value) & 1u) != 0;
  if (to_word && !from_word)
    problems.push_back({field, source_text(source) + ", a doubleword", "a word, as below"});
}

/// Values of the lead axis are for one interval: what is held after it is an older one in their place.
void check_hold(Problems& problems, const ClusterSettings& settings) {
  const auto given = [](const LeadSource& source) { return source.kind != LeadSource::Kind::none; };
  const ProcessSettings& lower = settings.lower.process;
  if (std::ranges::none_of(settings.lead, given) || lower.hold_too_old == 0 || lower.too_old_after != 1)
    return;
  problems.push_back({"lower.process.too_old_after", "1 where values that are too old are held",
                      "0, or 2 and more: with 1 the lead axis would repeat old values"});
}

}  // namespace

std::vector<SettingProblem> check(const ClusterSettings& settings) {
  Problems problems;
  if (settings.upper.bit_rate != settings.lower.bit_rate) {
    problems.push_back({"lower.bit_rate", number_text(slot_times(settings.lower.bit_rate).bits_per_second),
                        number_text(slot_times(settings.upper.bit_rate).bits_per_second) +
                            ", as above: both buses have the same interval"});
  }
  check_routes(problems, settings);
  for (std::uint8_t value = 0; value < kValues; ++value) {
    if (settings.lead[value].kind != LeadSource::Kind::none) check_source(problems, settings, value);
  }
  check_hold(problems, settings);
  const GatewaySettings& gateway = settings.gateway;
  if (gateway.monitoring <= Duration(0) || gateway.monitoring >= gateway.asker_gone) {
    problems.push_back(
        {"gateway.monitoring",
         number_text(static_cast<std::uint64_t>(gateway.monitoring.count() / 1'000'000)) + " ms",
         "over 0, and shorter than gateway.asker_gone"});
  }
  if (gateway.block_monitoring <= Duration(0))
    problems.push_back({"gateway.block_monitoring", "0", "over 0"});
  return problems;
}

std::vector<std::string> describe_lead_axis(const ClusterSettings& settings) {
  std::vector<std::string> lines;
  for (std::uint8_t value = 0; value < kValues; ++value) {
    const LeadSource& source = settings.lead[value];
    if (source.kind == LeadSource::Kind::none) continue;
    const unsigned delay = lead_delay(source, channel_of_lead(value), slot_times(settings.lower.bit_rate),
                                      settings.lower.send_margin, settings.lead_reserve);
    lines.push_back(source_text(source) + " becomes reference value " + number_text(value) +
                    " of the lower bus " + (delay == 0 ? "in the same interval" : "in the next interval"));
  }
  return lines;
}

}  // namespace cansync
