#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "daemon/status/metrics_text.h"

/// Metrics that are a member of a topic, by the tables of members that are made of the data model.
namespace cansyncd {

const MetricTopic& topic_of(std::string_view name, const MetricsSource& from) {
  const auto found = std::find_if(from.topics.begin(), from.topics.end(),
                                  [name](const MetricTopic& topic) { return topic.name == name; });
  if (found == from.topics.end()) throw std::logic_error("no topic " + std::string(name));
  return *found;
}

namespace {

/// The member of that name and those behind it.
std::span<const text::Member> members_from(std::span<const text::Member> members, std::string_view name) {
  const auto found = std::find_if(members.begin(), members.end(),
                                  [name](const text::Member& member) { return member.name == name; });
  if (found == members.end()) throw std::logic_error("no member " + std::string(name));
  return {found, members.end()};
}

/// Label of an element of an array: its name where the source has one, else its number from 1 on.
std::string element_label(std::string_view name, std::size_t element, const MetricsSource& from) {
  for (const ElementNames& of : from.element_names) {
    if (of.label == name) return label(name, of.names[element]);
  }
  return label(name, fmt::format("{}", element + 1));
}

/// In base units.
void add_number(const text::Member& member, const LabelledSample& from, MetricSamples& to,
                std::size_t element = 0) {
  const text::MemberValue value = text::value_of(member, from.sample, element);
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

/// The member and all behind it whose names begin with the same word.
void add_kinds(const MetricFamily& family, std::span<const text::Member> members,
               const LabelledSample& sample, MetricSamples& to) {
  const std::string_view name = members.front().name;
  const std::string_view word = name.substr(0, name.find('_') + 1);
  for (const text::Member& kind : members) {
    if (!kind.name.starts_with(word)) break;
    add_number(kind, {sample.sample, label(family.labels, kind.name.substr(word.size()))}, to);
  }
}

}  // namespace

void fill_from_member(const MetricFamily& family, const MetricsSource& from, MetricSamples& to) {
  constexpr std::string_view kAndThoseBehind = "...";
  const std::size_t dot = family.source.find('.');
  std::string_view path = family.source.substr(dot + 1);
  const bool by_kind = path.ends_with(kAndThoseBehind);
  if (by_kind) path.remove_suffix(kAndThoseBehind.size());
  const std::string_view name = path.substr(0, path.find('.'));
  const MetricTopic& topic = topic_of(family.source.substr(0, dot), from);
  const auto members = members_from(topic.members, name);
  const text::Member& member = members.front();
  for (const LabelledSample& sample : topic.samples) {
    if (by_kind) {
      add_kinds(family, members, sample, to);
    } else if (name.size() != path.size()) {
      const text::Member& part = members_from(member.members, path.substr(name.size() + 1)).front();
      const auto* elements = static_cast<const std::byte*>(sample.sample) + member.offset;
      for (std::size_t i = 0; i < member.count; ++i)
        add_number(part, {elements + i * member.size, element_label(family.labels, i, from)}, to);
    } else if (member.count != 0) {
      for (std::size_t i = 0; i < member.count; ++i)
        add_number(member, {sample.sample, element_label(family.labels, i, from)}, to, i);
    } else {
      add_number(member, sample, to);
    }
  }
}

}  // namespace cansyncd
