#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace cansync::cli {

enum class Level : std::uint8_t { ok, warning, error };

/// One thing that was looked at.
struct Finding {
  Level level = Level::ok;
  std::string topic;   ///< a stable word or two, e.g. "bit rate"
  std::string found;   ///< in words, with the figures
  std::string remedy;  ///< the command or setting that mends it; empty: nothing to mend
};

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

  /// Adds what others have found.
  void add(const std::vector<Finding>& found) {
    findings_.insert(findings_.end(), found.begin(), found.end());
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
