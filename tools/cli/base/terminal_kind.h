#pragma once

namespace cansync::cli {

/// Is the kind of terminal that TERM names known on this computer? Main thread only.
bool terminal_is_known();

}  // namespace cansync::cli
