#include "config/toml_guard.h"

namespace config {
namespace {

constexpr bool in_bare_key(char c) noexcept {
  // Beyond ASCII too: the parser refuses what is no letter, and it must not end a key here.
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
         static_cast<unsigned char>(c) >= 0x80;
}

/// Walks through the text and counts the parts of what could be a key.
class Walk {
 public:
  explicit Walk(std::string_view toml) : toml_(toml) {}

  std::optional<Place> go() {
    while (at_ < toml_.size()) {
      const char c = toml_[at_];
      if (c == '"' || c == '\'') {
        skip_string(c);
      } else if (c == '#') {
        skip_comment();
      } else if (c == '.') {
        if (parts_ == 0) begin_ = place();
        if (++parts_ >= kMostKeyParts) return begin_;
        step();
      } else {
        if (!in_bare_key(c) && c != ' ' && c != '\t') parts_ = 0;
        step();
      }
    }
    return std::nullopt;
  }

 private:
  Place place() const noexcept { return {line_, at_ - line_begin_ + 1}; }
  void step() noexcept {
    if (toml_[at_++] != '\n') return;
    ++line_;
    line_begin_ = at_;
  }
  void skip_comment() noexcept {
    while (at_ < toml_.size() && toml_[at_] != '\n') step();
  }
  /// A string of one line ends with its line at the latest: one that does not is no TOML.
  void skip_string(char quote) noexcept {
    const std::string_view rest = toml_.substr(at_);
    const bool long_form = rest.size() >= 3 && rest[1] == quote && rest[2] == quote;
    const std::size_t marks = long_form ? 3 : 1;
    for (std::size_t i = 0; i < marks; ++i) step();
    while (at_ < toml_.size()) {
      if (toml_[at_] == '\\' && quote == '"' && at_ + 1 < toml_.size()) {
        step();
      } else if (ends(quote, long_form)) {
        for (std::size_t i = 0; i < marks; ++i) step();
        // Up to two quotation marks may stand before the three that end it.
        while (long_form && at_ < toml_.size() && toml_[at_] == quote) step();
        return;
      } else if (!long_form && toml_[at_] == '\n') {
        return;
      }
      step();
    }
  }
  bool ends(char quote, bool long_form) const noexcept {
    if (!long_form) return toml_[at_] == quote;
    const std::string_view rest = toml_.substr(at_);
    return rest.size() >= 3 && rest[0] == quote && rest[1] == quote && rest[2] == quote;
  }

  std::string_view toml_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t line_begin_ = 0;
  std::size_t parts_ = 0;  ///< dots so far of what could be a key
  Place begin_;
};

}  // namespace

std::optional<Place> too_deep_key(std::string_view toml) {
  return Walk(toml).go();
}

}  // namespace config
