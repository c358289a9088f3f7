#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cansync/config/file.h"
#include "cansync/config/options.h"
#include "config/document.h"

namespace cansyncd {

/// The configuration of this text as file test.toml, with the assignments of --set, and its problems.
inline ConfigFile from_text(const std::string& text, const std::vector<std::string>& overrides = {}) {
  Settings settings = config::resolve(config::parse_document(text, "test.toml"), options());
  for (const std::string& assignment : overrides) config::override_setting(settings, assignment, options());
  return build_config(std::move(settings), "test.toml");
}

/// The same, of a text without problems.
inline Config good(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const ConfigFile file = from_text(text, overrides);
  EXPECT_EQ(problems_text(file.problems), "");
  return file.config;
}

/// What is in a file.
inline std::string content(const std::filesystem::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

/// The smallest configuration that is valid.
inline constexpr const char* kSmallest = "[[slave]]\nnumber = 0\n";

}  // namespace cansyncd
