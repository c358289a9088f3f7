#include "cli/text/words.h"

namespace cansync::cli {
namespace {

bool is_blank(char c) noexcept {
  return c == ' ' || c == '\t' || c == '\r';
}

/// Walks over one line.
class Splitter {
 public:
  explicit Splitter(std::string_view line) : line_(line) {}

  std::vector<Word> run() {
    std::vector<Word> words;
    for (;;) {
      while (at_ < line_.size() && is_blank(line_[at_])) ++at_;
      if (at_ == line_.size() || line_[at_] == '#') return words;
      words.push_back({"", at_ + 1});
      take_word(words.back().text);
    }
  }

 private:
  void take_word(std::string& word) {
    while (at_ < line_.size() && !is_blank(line_[at_])) {
      const char c = line_[at_];
      if (c == '\'' || c == '"') {
        take_quotation(word, c);
      } else if (c == '\\') {
        if (at_ + 1 == line_.size())
          throw WordError(at_ + 1, "found \\ at the end of the line; allowed: \\ before a character");
        word += line_[at_ + 1];
        at_ += 2;
      } else {
        word += c;
        ++at_;
      }
    }
  }

  void take_quotation(std::string& word, char mark) {
    const std::size_t start = at_++;
    for (; at_ < line_.size(); ++at_) {
      const char c = line_[at_];
      if (c == mark) {
        ++at_;
        return;
      }
      const bool escapes = mark == '"' && c == '\\' && at_ + 1 < line_.size() &&
                           (line_[at_ + 1] == '"' || line_[at_ + 1] == '\\');
      word += escapes ? line_[++at_] : c;
    }
    throw WordError(start + 1, std::string("found ") + mark + " without a second one on the line");
  }

  std::string_view line_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<Word> split_words(std::string_view line) {
  return Splitter(line).run();
}

}  // namespace cansync::cli
