#pragma once

#include <optional>
#include <string>

namespace cansyncd {

/// Writes `text` to `path` by way of `path`.new, so that no reader sees half a text; links of either name are
/// replaced, not followed. Readable for everybody, as far as the process's umask allows. Returns nothing, or
/// why not, and then leaves no `path`.new. Not for the realtime thread.
std::optional<std::string> replace_file(const std::string& path, const std::string& text);

}  // namespace cansyncd
