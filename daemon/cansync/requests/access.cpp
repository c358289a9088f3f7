#include "daemon/cansync/requests/access.h"

#include "daemon/cansync/requests/kinds.h"

namespace cansyncd {

Effect effect_of(const Request& request) {
  return with_row(request, [](auto row, const auto& kind) { return row.effect(kind); });
}

Right needed_right(const Request& request) {
  return effect_of(request).right;
}

bool changes_something(const Request& request) {
  return effect_of(request).changes;
}

gateway::dds::Problem right_refusal(const Request& request, Right right) {
  if (needed_right(request) <= right) return std::nullopt;
  return gateway::dds::Denial{gateway_CAUSE_RIGHT, not_on_topic_command()};
}

std::string not_on_topic_command() {
  return "kind: with DDS Security on topic Command takes control words and broadcasts alone; modes, polling, "
         "cursors and mappings go over topic EngineerCommand, which the role engineer may write";
}

gateway::dds::Problem read_only_refusal(const Request& request, const Config& config) {
  return read_only_refusal(effect_of(request), config.access.read_only);
}

gateway::dds::Problem read_only_refusal_of_references(const Config& config) {
  return read_only_refusal(cansync::ReferenceUpdate{}, config);
}

}  // namespace cansyncd
