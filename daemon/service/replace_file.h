#pragma once

#include <optional>
#include <string>

namespace cansyncd {

/// How a file is written anew.
struct Replacement {
  bool durable = false;  ///< once it returns, a power cut does not take the text away; waits for the disk
  bool for_everybody = false;  ///< every user may read it, whatever the process's umask says
};

/// Writes `text` to `path` by way of `path`.new, so that no reader sees half a text; links of either name are
/// replaced, not followed. Returns nothing, or why not, and then leaves no `path`.new. Not for the realtime
/// thread.
std::optional<std::string> replace_file(const std::string& path, const std::string& text,
                                        const Replacement& how = {});

}  // namespace cansyncd
