#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cansyncd {

/// A configuration that has run.
struct KeptConfiguration {
  std::string text;
  std::string since;  ///< when it was kept, "2026-11-27 21:04:53 UTC"
};

/// A moment of the wall clock as people read it, "2026-11-27 21:04:53 UTC".
std::string utc_text(std::int64_t seconds_since_1970);

/// The configurations that have run with a folder of the service, as files NAME.NUMBER.toml, where NAME is that
/// of the file and NUMBER rises: the clock may be wrong after a boot. Main thread.
class KeptConfigurations {
 public:
  /// Kept of one file.
  static constexpr std::size_t kMost = 10;

  /// `folder` exists; "": nothing is kept.
  explicit KeptConfigurations(std::string folder) : folder_(std::move(folder)) {}

  /// Those of the file `path`, newest first; what cannot be read is left out.
  std::vector<KeptConfiguration> of(const std::string& path) const;

  /// Keeps `text`, unless it is that of the newest already, and removes the oldest beyond `kMost`. Returns
  /// nothing, or what failed, with the path.
  std::optional<std::string> keep(const std::string& path, const std::string& text) const;

 private:
  std::string folder_;
};

}  // namespace cansyncd
