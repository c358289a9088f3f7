#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/value.h"

/// Options and their sections: what a file may say. Whoever has options brings them; reader, printers and
/// reload all derive from the one table. Main thread only.
namespace config {

/// What an option takes.
enum class OptionType : std::uint8_t {
  text,        ///< any string
  identifier,  ///< letters, digits, `_`, `.`, `-`
  name,        ///< a string without control characters that is no number and none of `choices`
  integer,     ///< minimum..maximum, or one of `choices`
  number,      ///< a finite number
  boolean,     ///< true or false
  choice,      ///< a string, one of `choices`
  other,       ///< what the row's own check takes; `words` says what that is
};

/// One option as documents and messages need it. All texts must outlive it: they are literals.
struct Option {
  std::string_view key;  ///< "section.name", or "section.inner.name" of a section in a section
  OptionType type = OptionType::text;
  std::string_view initial;  ///< default in TOML's notation; in round brackets: words, no fixed default
  std::int64_t minimum = 0;  ///< smallest number; fewest bytes of a string
  std::int64_t maximum = 0;
  bool not_zero = false;     ///< number: 0 is not allowed
  std::string_view choices;  ///< separated by '|'; empty: no list
  std::string_view words;    ///< with `other`: what is allowed
  std::string_view unit;     ///< empty: none
  std::string_view example;  ///< without a fixed default: a value to show
  bool reload = false;       ///< may change while the program runs
  bool label = false;        ///< the number of a section that means nothing by itself
  std::string_view help;

  /// Does the option have a fixed default?
  constexpr bool has_initial() const noexcept { return !initial.starts_with('('); }
  /// "section" of "section.name", "section.inner" of "section.inner.name".
  constexpr std::string_view section() const noexcept { return key.substr(0, key.rfind('.')); }
  /// "name" of "section.name".
  constexpr std::string_view name() const noexcept { return key.substr(key.rfind('.') + 1); }
  /// Does it number the sections of its name?
  constexpr bool numbers_section() const noexcept { return name() == "number"; }
};

/// One section. A numbered one stands in double brackets, each time with another `number`.
struct Section {
  std::string_view name;  ///< "section", "section.inner"
  std::string_view
      numbers;  ///< what the numbers are: "channel numbers"; empty: not numbered, in single brackets
  std::string_view help;  ///< empty: nothing is to be said
};

/// Every option, section by section in the order of the sections.
class Table {
 public:
  Table() = default;
  /// `options` are sorted by their sections, each of which must be among `sections`; those of one section
  /// keep their order. Each numbered section has an option "number".
  Table(std::span<const Section> sections, std::vector<Option> options);

  std::span<const Option> options() const noexcept { return options_; }
  std::span<const Section> sections() const noexcept { return sections_; }

  /// The option of a key, without the numbers of its sections; null when there is none.
  const Option* find(std::string_view key) const noexcept;
  /// The section of that name; null when there is none.
  const Section* find_section(std::string_view name) const noexcept;
  /// Does this section stand in double brackets?
  bool is_numbered(std::string_view section) const noexcept;
  /// The place of an option's section in `sections()`.
  std::size_t place_of(const Option& option) const noexcept;

 private:
  std::vector<Section> sections_;
  std::vector<Option> options_;
};

/// As it stands in a file: "[section]", or "[[section]]" when it is numbered.
std::string title(const Section& section);

/// What the option takes, in words: "1..31", "true or false".
std::string allowed(const Option& option);

/// Does the option take the value? With `other` always: the row's own check says it.
bool takes(const Option& option, const Value& value);

/// What was found and what is allowed.
std::string mismatch_text(const Option& option, const Value& value);

}  // namespace config
