#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "cli/text/styled_text.h"
#include "cli/watch/live_layout.h"
#include "cli/watch/live_view.h"

/// The terminal, full screen (ncurses). Main thread only; one object at a time.
namespace cansync::cli {

/// Whether TERM names a kind of terminal that can be drawn on: it is set, and not "dumb".
bool terminal_draws();

/// Whether standard input and output are such a terminal.
bool full_screen_possible();

/// The terminal is taken over while this object lives and as it was before when it is gone, also when an
/// exception or a signal's flag ends its owner.
class LiveScreen {
 public:
  /// Throws std::runtime_error when the terminal's kind is not known here.
  explicit LiveScreen(bool colours);
  ~LiveScreen();
  LiveScreen(const LiveScreen&) = delete;
  LiveScreen& operator=(const LiveScreen&) = delete;

  /// As it is now; a terminal may be resized at any time.
  ScreenSize size() const;
  /// What the locale's characters are.
  Symbols symbols() const noexcept { return symbols_; }
  /// Draws these lines; only what has changed is sent. `anew`: everything.
  void show(const std::vector<StyledLine>& lines, bool anew);

  /// What came from the keyboard: `resized` with no key when the terminal has another size, neither when the
  /// time was over or a signal came.
  struct Input {
    std::optional<Key> key;
    bool resized = false;
  };
  /// Waits at most `wait`. Throws std::runtime_error when the terminal has gone.
  Input input(std::chrono::milliseconds wait);

 private:
  struct Terminal;
  std::unique_ptr<Terminal> terminal_;
  Symbols symbols_ = Symbols::ascii;
};

}  // namespace cansync::cli
