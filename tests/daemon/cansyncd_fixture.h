#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "program.h"
#include "support/free_domain.h"

namespace fs = std::filesystem;

/// The daemon's program in a folder of its own, on a domain of its own.
class CansyncdTest : public testing::Test {
 protected:
  CansyncdTest() {
    std::string name = (fs::temp_directory_path() / "cansyncd-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~CansyncdTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  std::string write(const std::string& name, const std::string& text) const {
    const fs::path path = folder_ / name;
    std::ofstream(path) << text;
    return path.string();
  }

  Program run(std::vector<std::string> arguments, const std::vector<std::string>& environment = {}) const {
    arguments.push_back("--domain=" + std::to_string(domain_.get()));
    return {CANSYNCD, std::move(arguments), environment};
  }

  fs::path folder_;
  FreeDomain domain_;
};

inline constexpr const char* kTwoSlaves =
    "[bus]\nname = \"two\"\n[sim]\nlock_time_ms = 20\n[[slave]]\nnumber = 0\nname = "
    "\"winder\"\n[[slave]]\nnumber = 5\n";
