#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "cansync_members.h"
#include "daemon/cansync/status/metrics_families.h"
#include "dds/bounded_text.h"
#include "gateway_members.h"

/// Metrics that are a member of a topic, by the tables of members that are made of the data model.
namespace cansyncd {
namespace {

/// A struct of a sample, and the labels of its numbers.
struct Labelled {
  const void* sample;
  std::string labels;
};

struct TopicSamples {
  std::span<const text::Member> members;
  std::vector<Labelled> samples;
};

template <class T>
TopicSamples one(const T& sample) {
  return {text::members_of<T>, {{&sample, ""}}};
}

TopicSamples samples_of(std::string_view topic, const MetricsSource& from) {
  if (topic == "GatewayStatus") return one(from.common.gateway);
  if (topic == "BusStatus") return one(from.common.bus);
  if (topic == "RealtimeStatus") return one(from.common.realtime);
  if (topic == "MasterStatus") return one(from.master);
  if (topic == "Timing") {
    if (from.timing != nullptr) return one(*from.timing);
    return {text::members_of<cansync_Timing>, {}};
  }
  if (topic != "SlaveStatus") throw std::logic_error("no topic " + std::string(topic));
  TopicSamples slaves{text::members_of<cansync_SlaveStatus>, {}};
  for (const cansync_SlaveStatus* slave : from.slaves)
    slaves.samples.push_back({slave, slave_labels(*slave)});
  return slaves;
}

/// The member of that name and those behind it.
std::span<const text::Member> members_from(std::span<const text::Member> members, std::string_view name) {
  const auto found = std::find_if(members.begin(), members.end(),
                                  [name](const text::Member& member) { return member.name == name; });
  if (found == members.end()) throw std::logic_error("no member " + std::string(name));
  return {found, members.end()};
}

/// Label of an element of the arrays of structs.
std::string element_label(std::string_view array, std::size_t element) {
  if (array == "slot") return label("slot", kSlotNames[element]);
  return label("telegram", fmt::format("{}", element + 1));
}

/// In base units.
void add_number(const text::Member& member, const Labelled& from, MetricSamples& to) {
  const text::MemberValue value = text::value_of(member, from.sample);
  const double divisor = member.unit == "ns"                                ? 1e9
                         : member.unit == "ms" || member.unit == "permille" ? 1e3
                                                                            : 1;
  const auto add = [&](const auto& number) {
    using Number = std::decay_t<decltype(number)>;
    if constexpr (std::is_same_v<Number, std::string>) {
      throw std::logic_error(std::string(member.name) + " is no number");
    } else if (divisor != 1) {
      to.add(from.labels, static_cast<double>(number) / divisor);
    } else if constexpr (std::is_same_v<Number, bool>) {
      to.add(from.labels, std::uint64_t{number});
    } else {
      to.add(from.labels, number);
    }
  };
  std::visit(add, value);
}

}  // namespace

std::string slave_labels(const cansync_SlaveStatus& slave) {
  return label("slave", fmt::format("{}", slave.slave)) + "," + label("name", gateway::dds::text(slave.name));
}

void fill_from_member(const MetricFamily& family, const MetricsSource& from, MetricSamples& to) {
  constexpr std::string_view kAndThoseBehind = "...";
  const std::size_t dot = family.source.find('.');
  std::string_view path = family.source.substr(dot + 1);
  const bool by_kind = path.ends_with(kAndThoseBehind);
  if (by_kind) path.remove_suffix(kAndThoseBehind.size());
  const std::string_view name = path.substr(0, path.find('.'));
  const TopicSamples topic = samples_of(family.source.substr(0, dot), from);
  const auto members = members_from(topic.members, name);
  const text::Member& member = members.front();
  for (const Labelled& sample : topic.samples) {
    if (by_kind) {
      const std::string_view word = name.substr(0, name.find('_') + 1);
      for (const text::Member& kind : members) {
        if (!kind.name.starts_with(word)) break;
        add_number(kind, {sample.sample, label(family.labels, kind.name.substr(word.size()))}, to);
      }
    } else if (name.size() == path.size()) {
      add_number(member, sample, to);
    } else {
      const text::Member& part = members_from(member.members, path.substr(name.size() + 1)).front();
      const auto* elements = static_cast<const std::byte*>(sample.sample) + member.offset;
      for (std::size_t i = 0; i < member.count; ++i)
        add_number(part, {elements + i * member.size, element_label(name, i)}, to);
    }
  }
}

}  // namespace cansyncd
