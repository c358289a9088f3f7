#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cansync::cli {

enum class Level : std::uint8_t { ok, warning, error };

/// One thing that was looked at.
struct Finding {
  Level level = Level::ok;
  std::string topic;         ///< a stable word or two, e.g. "bit rate"
  std::string found;         ///< in words, with the figures
  std::string remedy;        ///< the command or setting that fixes it; empty: nothing to fix
  std::uint32_t slaves = 0;  ///< bit n: it is about slave n alone; 0: not about slaves
  std::string alike;         ///< of slaves: what is found, without who they are
  std::string remedy_form;   ///< of slaves: the remedy, with kSlavesHere for their numbers
};

/// In the remedy for slaves: where their numbers are put.
inline constexpr std::string_view kSlavesHere = "{slaves}";

/// What is found of one slave.
struct SlaveFinding {
  unsigned slave = 0;
  std::string found;        ///< with the slave's name, and figures
  std::string alike;        ///< the same without: what several slaves have in common
  std::string remedy = {};  ///< with kSlavesHere for their numbers
};

/// Findings in the order in which they are made.
class FindingList {
 public:
  /// Adds what is well.
  void ok(std::string topic, std::string found) { add(Level::ok, std::move(topic), std::move(found), ""); }

  /// Adds what works, but not as it should, with what fixes it.
  void warning(std::string topic, std::string found, std::string remedy) {
    add(Level::warning, std::move(topic), std::move(found), std::move(remedy));
  }

  /// Adds what does not work, with what fixes it.
  void error(std::string topic, std::string found, std::string remedy) {
    add(Level::error, std::move(topic), std::move(found), std::move(remedy));
  }

  /// Adds what is found of a slave.
  void add_slave(Level level, std::string topic, SlaveFinding finding) {
    std::string remedy = finding.remedy;
    const std::string number = std::to_string(finding.slave);
    for (std::size_t at = 0; (at = remedy.find(kSlavesHere)) != std::string::npos;)
      remedy.replace(at, kSlavesHere.size(), number);
    findings_.push_back({level, std::move(topic), std::move(finding.found), std::move(remedy),
                         1u << finding.slave, std::move(finding.alike), std::move(finding.remedy)});
  }

  /// Adds what others have found.
  void add(const std::vector<Finding>& found) {
    findings_.insert(findings_.end(), found.begin(), found.end());
  }

  /// All of them; the list is used up.
  std::vector<Finding> take() && { return std::move(findings_); }

 private:
  void add(Level level, std::string topic, std::string found, std::string remedy) {
    findings_.push_back({level, std::move(topic), std::move(found), std::move(remedy), 0, "", ""});
  }
  std::vector<Finding> findings_;
};

}  // namespace cansync::cli
