#include "profile/profile.h"

#include <algorithm>

namespace profile {

const Parameter* Profile::find(std::uint32_t wanted) const noexcept {
  const auto place =
      std::lower_bound(parameters.begin(), parameters.end(), wanted,
                       [](const Parameter& parameter, std::uint32_t n) { return parameter.number < n; });
  return place != parameters.end() && place->number == wanted ? &*place : nullptr;
}

const Parameter* Profile::find(std::string_view wanted) const noexcept {
  const auto place = std::find_if(parameters.begin(), parameters.end(),
                                  [&](const Parameter& parameter) { return parameter.name == wanted; });
  return place != parameters.end() ? &*place : nullptr;
}

const Parameter* Profile::telling(Tells wanted) const noexcept {
  const auto place = std::find_if(parameters.begin(), parameters.end(),
                                  [&](const Parameter& parameter) { return parameter.tells == wanted; });
  return place != parameters.end() ? &*place : nullptr;
}

}  // namespace profile
