#include "cli/watch/live_screen.h"

#define NCURSES_NOMACROS 1  // functions, which the compiler can check
#include <langinfo.h>
#include <ncurses.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <clocale>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

#include "cli/base/terminal_kind.h"

namespace cansync::cli {
namespace {

constexpr int kEscapeDelay = 25;  // ms to tell Esc from a key that sends more

/// Colours of the styles, as pairs.
enum Pair : short { kBar = 1, kChosen, kGood, kWarning, kBad, kTrend };

chtype attributes(Style style, bool colours) {
  const auto paired = [colours](Pair pair, chtype with, chtype without) {
    return colours ? with | static_cast<chtype>(COLOR_PAIR(pair)) : without;
  };
  switch (style) {
    case Style::bar:
      return paired(kBar, A_NORMAL, A_REVERSE);
    case Style::chosen:
      return paired(kChosen, A_BOLD, A_REVERSE | A_BOLD);
    case Style::heading:
      return A_BOLD | A_UNDERLINE;
    case Style::dim:
      return A_DIM;
    case Style::strong:
      return A_BOLD;
    case Style::good:
      return paired(kGood, A_NORMAL, A_NORMAL);
    case Style::warning:
      return paired(kWarning, A_BOLD, A_BOLD);
    case Style::bad:
      return paired(kBad, A_BOLD, A_BOLD | A_REVERSE);
    case Style::trend:
      return paired(kTrend, A_NORMAL, A_NORMAL);
    case Style::plain:
      break;
  }
  return A_NORMAL;
}

void set_up_colours() {
  start_color();
  use_default_colors();
  init_pair(kBar, COLOR_WHITE, COLOR_BLUE);
  init_pair(kChosen, COLOR_BLACK, COLOR_CYAN);
  init_pair(kGood, COLOR_GREEN, -1);
  init_pair(kWarning, COLOR_YELLOW, -1);
  init_pair(kBad, COLOR_RED, -1);
  init_pair(kTrend, COLOR_CYAN, -1);
}

/// Text that a terminal takes for nothing but text.
std::string harmless(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  return out;
}

std::optional<Key> key_of(int code) {
  using Kind = Key::Kind;
  switch (code) {
    case KEY_UP:
      return Key{Kind::up};
    case KEY_DOWN:
      return Key{Kind::down};
    case KEY_LEFT:
      return Key{Kind::left};
    case KEY_RIGHT:
      return Key{Kind::right};
    case KEY_PPAGE:
      return Key{Kind::page_up};
    case KEY_NPAGE:
      return Key{Kind::page_down};
    case KEY_HOME:
      return Key{Kind::home};
    case KEY_END:
      return Key{Kind::end};
    case KEY_ENTER:
    case '\r':
    case '\n':
      return Key{Kind::enter};
    case KEY_BACKSPACE:
    case '\b':
    case 0x7F:
      return Key{Kind::backspace};
    case 0x1B:
      return Key{Kind::escape};
    default:
      break;
  }
  if (code < 0 || code > 0xFF) return std::nullopt;
  return Key{Kind::character, static_cast<char>(code)};
}

}  // namespace

bool terminal_draws() {
  const char* kind = std::getenv("TERM");  // NOLINT(concurrency-mt-unsafe): nobody changes the environment
  return kind != nullptr && *kind != '\0' && std::string_view(kind) != "dumb";
}

bool full_screen_possible() {
  return terminal_draws() && ::isatty(STDIN_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 1;
}

struct LiveScreen::Terminal {
  SCREEN* screen = nullptr;
  bool colours = false;
};

LiveScreen::LiveScreen(bool colours) : terminal_(std::make_unique<Terminal>()) {
  // Characters alone: numbers keep their point. Nobody else looks at the locale meanwhile.
  std::setlocale(LC_CTYPE, "");                           // NOLINT(concurrency-mt-unsafe): see above
  if (std::string_view(nl_langinfo(CODESET)) == "UTF-8")  // NOLINT(concurrency-mt-unsafe): see above
    symbols_ = Symbols::unicode;
  // Asked before, because newterm leaks memory when it fails.
  if (terminal_is_known()) terminal_->screen = newterm(nullptr, stdout, stdin);
  if (terminal_->screen == nullptr) throw std::runtime_error("the kind of this terminal (TERM) is not known");
  cbreak();
  noecho();
  keypad(stdscr, TRUE);
  nodelay(stdscr, TRUE);
  set_escdelay(kEscapeDelay);
  curs_set(0);
  terminal_->colours = colours && has_colors();
  if (terminal_->colours) set_up_colours();
}

LiveScreen::~LiveScreen() {
  endwin();
  delscreen(terminal_->screen);
}

ScreenSize LiveScreen::size() const {
  return {static_cast<std::size_t>(getmaxx(stdscr)), static_cast<std::size_t>(getmaxy(stdscr))};
}

void LiveScreen::show(const std::vector<StyledLine>& lines, bool anew) {
  if (anew) clearok(stdscr, TRUE);
  erase();
  for (std::size_t row = 0; row < lines.size(); ++row) {
    move(static_cast<int>(row), 0);
    for (const Span& span : lines[row].spans) {
      const bool row_marked = lines[row].highlighted;
      // Colours would tear the bar of the selected row to pieces.
      const chtype look = row_marked ? A_REVERSE | (span.style == Style::strong ? A_BOLD : A_NORMAL)
                                     : attributes(span.style, terminal_->colours);
      attrset(static_cast<NCURSES_ATTR_T>(look));
      addstr(harmless(span.text).c_str());
    }
  }
  attrset(A_NORMAL);
  refresh();
}

LiveScreen::Input LiveScreen::input(std::chrono::milliseconds wait) {
  pollfd keyboard{STDIN_FILENO, POLLIN, 0};
  const int ready = ::poll(&keyboard, 1, static_cast<int>(wait.count()));
  if (ready > 0 && (keyboard.revents & POLLIN) == 0) throw std::runtime_error("the terminal has gone");
  const int code = getch();  // also takes notice of a signal that the size has changed
  if (code == KEY_RESIZE) return {std::nullopt, true};
  if (code == ERR) return {};
  return {key_of(code), false};
}

}  // namespace cansync::cli
