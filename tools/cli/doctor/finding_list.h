#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cli/doctor/doctor_findings.h"

namespace cansync::cli {

/// Findings in the order in which they are made.
class FindingList {
 public:
  /// Adds what is well.
  void ok(std::string topic, std::string found) { add(Level::ok, std::move(topic), std::move(found), ""); }

  /// Adds what works, but not as it should, with what mends it.
  void warning(std::string topic, std::string found, std::string remedy) {
    add(Level::warning, std::move(topic), std::move(found), std::move(remedy));
  }

  /// Adds what does not work, with what mends it.
  void error(std::string topic, std::string found, std::string remedy) {
    add(Level::error, std::move(topic), std::move(found), std::move(remedy));
  }

  /// All of them; the list is used up.
  std::vector<Finding> take() && { return std::move(findings_); }

 private:
  void add(Level level, std::string topic, std::string found, std::string remedy) {
    findings_.push_back({level, std::move(topic), std::move(found), std::move(remedy)});
  }
  std::vector<Finding> findings_;
};

}  // namespace cansync::cli
