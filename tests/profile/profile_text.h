#pragma once

#include <gtest/gtest.h>

#include <string>

#include "profile/reader.h"

namespace profile {

/// A profile of one parameter; its lines `number`, `name`, `format` and `access` are 3 to 6.
inline std::string one_parameter(const std::string& more, const std::string& format = "word") {
  return "profile = {name = \"p\"}\n[[parameter]]\nnumber = 12\nname = \"speed-limit\"\nformat = \"" +
         format + "\"\naccess = \"read-write\"\n" + more;
}

/// The parameter of a right profile.
inline Parameter parameter_of(const std::string& toml) {
  const Reading reading = parse(toml, "f");
  EXPECT_EQ(problems_text(reading.problems), "");
  return reading.profile && !reading.profile->parameters.empty() ? reading.profile->parameters.front()
                                                                 : Parameter{};
}

/// Everything wrong with a profile, with places in the file "f".
inline std::string problems_of(const std::string& toml) {
  const Reading reading = parse(toml, "f");
  return problems_text(reading.problems);
}

}  // namespace profile
