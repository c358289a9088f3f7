#include "daemon/config/sections.h"

#include <fmt/format.h>

#include <algorithm>

namespace cansyncd {

std::string_view section_of(const Option& option) {
  return option.key.substr(0, option.key.rfind('.'));
}
std::string_view name_of(const Option& option) {
  return option.key.substr(option.key.rfind('.') + 1);
}

std::vector<std::string_view> sections() {
  std::vector<std::string_view> out;
  for (const Option& option : options()) {
    if (std::find(out.begin(), out.end(), section_of(option)) == out.end()) out.push_back(section_of(option));
  }
  return out;
}

std::string section_title(std::string_view section) {
  return is_repeated(section) ? fmt::format("[[{}]]", section) : fmt::format("[{}]", section);
}

std::string_view section_help(std::string_view section) {
  if (section == "slave") return "Once for each slave of the line.";
  if (section == "slave.value")
    return "Below its slave, once for each actual value that has a name, unit or scaling.";
  if (section == "actual") {
    return "Once for each actual value that has a name, unit or scaling on all slaves; a slave's own go "
           "first.";
  }
  if (section == "reference") return "Once for each reference value that has a name, unit or scaling.";
  return "";
}

}  // namespace cansyncd
