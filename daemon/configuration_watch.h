#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>

#include "config/document.h"
#include "daemon/segment/protocol.h"

namespace cansyncd {

/// Reads and checks a configuration file, as at the start.
using LoadConfiguration = std::function<LoadedConfig(const config::Source&)>;

/// Compares the configuration file on disk with what runs, and finds what is wrong with it before the next
/// start does. Main thread.
class ConfigurationWatch {
 public:
  /// `running`: what runs, with its text, of the file that is looked at or kept (`kept_since`). `now`: the
  /// wall clock in seconds, as every `now` here.
  ConfigurationWatch(const LoadedConfig& running, LoadConfiguration load, std::int64_t now);

  /// Looks at the file; reads it only when it has changed. True: `reason` is another one now.
  bool look();

  /// The file was read again and is in force; `left`: but for what this says, empty: completely.
  void taken(const std::string& text, std::string left, std::int64_t now);

  /// Why another configuration than the file on disk is in force; empty: it is that file.
  const std::string& reason() const noexcept { return reason_; }

  /// Is the file on disk another than what runs?
  bool differs() const noexcept { return differs_; }

  /// Is the file on disk wrong, so that it cannot come into force?
  bool wrong() const noexcept { return wrong_; }

 private:
  /// What changes with a file.
  struct Facts {
    int error = -1;
    dev_t device = 0;
    ino_t node = 0;
    off_t size = 0;
    std::int64_t seconds = 0;
    std::int64_t nanoseconds = 0;
    bool operator==(const Facts&) const = default;
  };
  static Facts facts_of(const std::string& path);
  std::string compare();

  const std::string path_;
  const LoadConfiguration load_;
  std::string text_;   ///< of what runs
  std::string since_;  ///< when it was read
  std::string left_;   ///< of the file on disk, what is not in force
  std::string profiles_;
  Facts facts_;
  std::string reason_;
  bool differs_ = false;
  bool wrong_ = false;
};

}  // namespace cansyncd
