#include "text/completion.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace text {
namespace {

/// Parts of `text` between the separators; empty ones are left out.
std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(separator));
    if (!part.empty()) parts.emplace_back(part);
    text.remove_prefix(std::min(part.size() + 1, text.size()));
  }
  return parts;
}

/// What the shell knows best, by the argument's name.
std::string shell_knows(std::string_view placeholder) {
  if (placeholder == "FILE" || placeholder == "CONFIG") return ":files";
  if (placeholder == "FOLDER") return ":folders";
  if (placeholder == "INTERFACE") return ":interfaces";
  if (placeholder == "BUS") return ":buses";
  return "";
}

/// Walks over the words before the cursor.
class Walk {
 public:
  explicit Walk(const CLI::App& app) : app_(app) {}

  void take(std::string_view word) {
    if (pending_ != nullptr) {
      line_.options["--" + pending_->get_lnames().front()] = word;
      pending_ = nullptr;
    } else if (!only_arguments_ && word == "--") {
      only_arguments_ = true;
    } else if (word != "-" && is_option(word)) {
      take_option(word);
    } else if (const CLI::App* verb = verb_named(word); verb != nullptr) {
      line_.verb += (line_.verb.empty() ? "" : " ") + verb->get_name();
      verb_ = verb;
    } else if (has_verbs() && verb_ == nullptr) {
      lost_ = true;
    } else {
      line_.arguments.emplace_back(word);
    }
  }

  /// The candidates for the word at the cursor.
  std::vector<std::string> candidates(std::string_view word, const CandidateLookup& lookup) const {
    if (pending_ != nullptr) return filtered(word, values(pending_->get_type_name(), lookup));
    if (lost_) return {};
    if (is_option(word)) {
      const std::size_t equals = word.find('=');
      if (equals == std::string_view::npos) return filtered(word, option_names());
      const CLI::Option* option = find(word.substr(0, equals));
      if (option == nullptr || !takes_value(*option)) return {};
      std::vector<std::string> out =
          filtered(word.substr(equals + 1), values(option->get_type_name(), lookup));
      for (std::string& value : out)
        if (!value.starts_with(':')) value.insert(0, word.substr(0, equals + 1));
      return out;
    }
    std::vector<std::string> all;
    if (line_.arguments.empty()) all = verb_names();
    const std::vector<std::string> more = values(placeholder(), lookup);
    all.insert(all.end(), more.begin(), more.end());
    return filtered(word, all);
  }

 private:
  const CLI::App& place() const { return verb_ != nullptr ? *verb_ : app_; }
  bool has_verbs() const { return !app_.get_subcommands({}).empty(); }
  static bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

  /// A minus with a digit is a number; one alone is standard input.
  bool is_option(std::string_view word) const {
    return !only_arguments_ && word.starts_with('-') &&
           (word.size() == 1 || word[1] == '-' || std::isalpha(static_cast<unsigned char>(word[1])) != 0);
  }

  const CLI::Option* find(std::string_view name) const {
    const CLI::Option* option = place().get_option_no_throw(std::string(name));
    return option != nullptr ? option : app_.get_option_no_throw(std::string(name));
  }

  void take_option(std::string_view word) {
    const std::size_t equals = word.find('=');
    const CLI::Option* option = find(word.substr(0, equals));
    if (option == nullptr || !takes_value(*option) || option->get_lnames().empty()) return;
    if (equals == std::string_view::npos) {
      pending_ = option;
      return;
    }
    line_.options["--" + option->get_lnames().front()] = word.substr(equals + 1);
  }

  /// Those that may come next.
  std::vector<std::string> verb_names() const {
    std::vector<std::string> out;
    for (const CLI::App* verb : place().get_subcommands({})) out.push_back(verb->get_name());
    return out;
  }

  /// The verb, or its second word, that this word is where it stands; null: none.
  const CLI::App* verb_named(std::string_view word) const {
    if (lost_ || !line_.arguments.empty()) return nullptr;
    for (const CLI::App* verb : place().get_subcommands({}))
      if (verb->get_name() == word) return verb;
    return nullptr;
  }

  std::vector<std::string> option_names() const {
    std::vector<std::string> out;
    const auto add = [&out](const CLI::App& app) {
      for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
    };
    add(place());
    if (verb_ != nullptr) add(app_);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  /// The argument without an option that comes next; empty: there is none.
  std::string placeholder() const {
    std::size_t before = line_.arguments.size();
    for (const CLI::Option* option : place().get_options()) {
      if (!option->get_positional()) continue;
      const auto most = static_cast<std::size_t>(option->get_items_expected_max());
      if (before >= most) {
        before -= most;
        continue;
      }
      std::string choices = option->get_type_name();
      if (choices.find('|') != std::string::npos) return choices;
      // "CHANNEL WHO" come by turns.
      const std::vector<std::string> names = split(option->get_name(true), ' ');
      return names.empty() ? "" : names[before % names.size()];
    }
    return "";
  }

  std::vector<std::string> values(const std::string& placeholder, const CandidateLookup& lookup) const {
    if (placeholder.find('|') != std::string::npos) return split(placeholder, '|');
    if (const std::string asked = shell_knows(placeholder); !asked.empty()) return {asked};
    if (placeholder.empty() || !lookup) return {};
    return lookup(placeholder, line_);
  }

  /// Those that go on where `word` stops; what the shell is asked stays.
  static std::vector<std::string> filtered(std::string_view word, const std::vector<std::string>& all) {
    const std::size_t comma = word.rfind(',');
    const std::string_view kept = comma == std::string_view::npos ? "" : word.substr(0, comma + 1);
    const std::string_view begun = word.substr(kept.size());
    std::vector<std::string> out;
    for (const std::string& candidate : all) {
      if (candidate.starts_with(':'))
        out.push_back(candidate);
      else if (candidate.starts_with(begun))
        out.push_back(std::string(kept) + candidate);
    }
    return out;
  }

  const CLI::App& app_;
  const CLI::App* verb_ = nullptr;
  const CLI::Option* pending_ = nullptr;  ///< its value comes next
  bool only_arguments_ = false;           ///< after "--"
  bool lost_ = false;                     ///< a verb that there is not
  TypedLine line_;
};

}  // namespace

std::string completions(const CLI::App& app, std::span<const std::string_view> words,
                        const CandidateLookup& lookup) {
  Walk walk(app);
  for (std::size_t i = 0; i + 1 < words.size(); ++i) walk.take(words[i]);
  std::string out;
  for (const std::string& candidate : walk.candidates(words.empty() ? "" : words.back(), lookup))
    out += candidate + '\n';
  return out;
}

std::vector<std::string_view> words_to_complete(int argc, const char* const* argv) {
  if (argc < 3 || std::string_view(argv[1]) != "--complete") return {};
  return {argv + 2, argv + argc};
}

}  // namespace text
