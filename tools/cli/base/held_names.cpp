#include "cli/base/held_names.h"

#include <cansync/client.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace cansync::cli {
namespace {

template <class Value>
std::array<std::string, 8> names_of(const Value (&values)[8]) {
  std::array<std::string, 8> names;
  std::transform(std::begin(values), std::end(values), names.begin(),
                 [](const Value& value) { return std::string(client::text(value.name)); });
  return names;
}

std::string quoted(const std::string& name) {
  return name.empty() ? "without a name" : "'" + name + "'";
}

}  // namespace

HeldNames::HeldNames(const client::MasterStatus& master, const std::vector<client::SlaveStatus>& slaves)
    : references_(names_of(master.reference_value)) {
  for (const client::SlaveStatus& slave : slaves) {
    slaves_[slave.slave] = {std::string(client::text(slave.name)),
                            std::string(client::text(slave.profile_hash)), names_of(slave.actual_value)};
  }
}

std::string HeldNames::change_to(const HeldNames& now) const {
  for (const auto& [number, before] : slaves_) {
    const auto found = now.slaves_.find(number);
    if (found == now.slaves_.end()) return fmt::format("slave {} is not configured any more", number);
    const Slave& is = found->second;
    if (is.name != before.name)
      return fmt::format("slave {} was {} and is {}", number, quoted(before.name), quoted(is.name));
    if (is.profile != before.profile) return fmt::format("slave {} has another profile", number);
    if (is.values != before.values) return fmt::format("the values of slave {} have other names", number);
  }
  return references_ == now.references_ ? "" : "the reference values have other names";
}

}  // namespace cansync::cli
