#include "cli/base/terminal_kind.h"

#include <curses.h>
// Behind curses.h; its macros take names such as `lines`, so it stands in a file of its own.
#include <term.h>
#include <unistd.h>

namespace cansync::cli {

bool terminal_is_known() {
  int found = 0;
  if (setupterm(nullptr, STDOUT_FILENO, &found) != OK) return false;
  del_curterm(cur_term);
  return true;
}

}  // namespace cansync::cli
