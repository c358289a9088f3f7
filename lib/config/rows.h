#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/document.h"
#include "config/option.h"
#include "config/value.h"

/// Rows: options with what takes their values; and what rows are written with. Main thread only.
namespace config {

/// An option, and where its value goes. `Draft` is what its owner fills while a file is read.
template <class Draft>
struct Row {
  Option option;
  void (*apply)(Draft&, const Value&) = nullptr;  ///< takes a value that the option takes
  /// A check beside the option's type; null: none. With `OptionType::other` the only one.
  bool (*takes)(const Draft&, const Value&) = nullptr;
  /// The default, read from a draft as it is made; null: `option.initial` says it.
  Value (*initial)(Draft&) = nullptr;
};

/// The rows of one owner, which fill a whole draft or one part of it.
template <class Draft>
class Part {
 public:
  /// A row and what it fills, seen from the whole draft.
  struct Entry {
    Option option;
    std::function<void(Draft&, const Value&)> apply;
    std::function<bool(const Draft&, const Value&)> takes;  ///< empty: as `Row::takes`
    std::function<Value(Draft&)> initial;                   ///< empty: as `Row::initial`
  };

  /// Rows of the draft itself; implicit, so that a list of parts may name them as they are.
  Part(std::span<const Row<Draft>> rows) {
    for (const Row<Draft>& row : rows) {
      entries_.push_back({row.option, row.apply, row.takes, row.initial});
    }
  }

  /// Rows that fill the draft's member `member`, or a base of it.
  template <class Own, class Member>
  Part(std::span<const Row<Own>> rows, Member Draft::*member) {
    for (const Row<Own>& row : rows) {
      Entry entry;
      entry.option = row.option;
      entry.apply = [apply = row.apply, member](Draft& draft, const Value& value) {
        apply(draft.*member, value);
      };
      if (row.takes != nullptr) {
        entry.takes = [takes = row.takes, member](const Draft& draft, const Value& value) {
          return takes(draft.*member, value);
        };
      }
      if (row.initial != nullptr) {
        entry.initial = [initial = row.initial, member](Draft& draft) { return initial(draft.*member); };
      }
      entries_.push_back(std::move(entry));
    }
  }

  const std::vector<Entry>& entries() const noexcept { return entries_; }

 private:
  std::vector<Entry> entries_;
};

/// The rows of one file, from several owners.
template <class Draft>
class Rows {
 public:
  /// As for `Table`; rows of one section keep the order of `parts`.
  Rows(std::span<const Section> sections, const std::vector<Part<Draft>>& parts) {
    const auto fresh = std::make_unique<Draft>();
    std::vector<Option> options;
    for (const Part<Draft>& part : parts) {
      for (Entry row : part.entries()) {
        if (row.initial) row.option.initial = initials_.emplace_back(row.initial(*fresh).text);
        options.push_back(row.option);
        rows_.push_back(std::move(row));
      }
    }
    table_ = Table(sections, std::move(options));
    std::stable_sort(rows_.begin(), rows_.end(), [&](const Entry& a, const Entry& b) {
      return table_.place_of(a.option) < table_.place_of(b.option);
    });
  }

  Rows(const Rows&) = delete;  // the options point at the texts of their defaults
  Rows& operator=(const Rows&) = delete;

  const Table& table() const noexcept { return table_; }

  /// Puts a value into the draft. Returns what was found and what is allowed when the option, one of
  /// `table()`, does not take it.
  std::optional<std::string> apply(const Option& option, const Value& value, Draft& draft) const {
    const Entry& row = rows_[static_cast<std::size_t>(&option - table_.options().data())];
    if (!takes(option, value) || (row.takes && !row.takes(draft, value))) {
      return mismatch_text(option, value);
    }
    row.apply(draft, value);
    return std::nullopt;
  }

 private:
  using Entry = typename Part<Draft>::Entry;

  std::deque<std::string> initials_;
  Table table_;
  std::vector<Entry> rows_;  ///< in the order of the table
};

/// What the options of rows are written with. A default in round brackets is what holds when the option is
/// not given, in words.
namespace rows {

constexpr Option plain(std::string_view key, OptionType type, std::string_view initial,
                       std::string_view help) {
  Option option;
  option.key = key;
  option.type = type;
  option.initial = initial;
  option.help = help;
  return option;
}

constexpr Option boolean(std::string_view key, std::string_view initial, std::string_view help) {
  return plain(key, OptionType::boolean, initial, help);
}

constexpr Option whole_number(std::string_view key, std::string_view initial, std::int64_t minimum,
                              std::int64_t maximum, std::string_view unit, std::string_view help) {
  Option option = plain(key, OptionType::integer, initial, help);
  option.minimum = minimum;
  option.maximum = maximum;
  option.unit = unit;
  return option;
}

/// The number of a section, 0..maximum, that means nothing by itself.
constexpr Option label(std::string_view key, std::int64_t maximum, std::string_view help) {
  Option option = whole_number(key, "(required)", 0, maximum, "", help);
  option.label = true;
  return option;
}

/// One of a few whole numbers, separated by '|'.
constexpr Option one_number(std::string_view key, std::string_view initial, std::string_view choices,
                            std::string_view unit, std::string_view help) {
  Option option = plain(key, OptionType::integer, initial, help);
  option.choices = choices;
  option.unit = unit;
  return option;
}

constexpr Option real_number(std::string_view key, std::string_view initial, bool not_zero,
                             std::string_view help) {
  Option option = plain(key, OptionType::number, initial, help);
  option.not_zero = not_zero;
  return option;
}

/// One of a few words, separated by '|'.
constexpr Option choice(std::string_view key, std::string_view initial, std::string_view choices,
                        std::string_view help) {
  Option option = plain(key, OptionType::choice, initial, help);
  option.choices = choices;
  return option;
}

/// A string of minimum..maximum bytes.
constexpr Option string(std::string_view key, OptionType type, std::string_view initial, std::int64_t minimum,
                        std::int64_t maximum, std::string_view help) {
  Option option = plain(key, type, initial, help);
  option.minimum = minimum;
  option.maximum = maximum;
  return option;
}

/// What the row's own check takes; `words` says what is allowed.
constexpr Option other(std::string_view key, std::string_view words, std::string_view initial,
                       std::string_view help) {
  Option option = plain(key, OptionType::other, initial, help);
  option.words = words;
  return option;
}

constexpr Option reloadable(Option option) {
  option.reload = true;
  return option;
}

/// With a value to show for an option without a fixed default.
constexpr Option example(std::string_view value, Option option) {
  option.example = value;
  return option;
}

// --- what a row takes out of a value that has passed its option

template <class T>
T whole(const Value& value) {
  return static_cast<T>(std::get<std::int64_t>(value.items.front()));
}

inline std::chrono::milliseconds milliseconds(const Value& value) {
  return std::chrono::milliseconds(whole<std::int64_t>(value));
}

inline bool flag(const Value& value) {
  return std::get<bool>(value.items.front());
}

inline const std::string& words(const Value& value) {
  return std::get<std::string>(value.items.front());
}

inline double real(const Value& value) {
  if (const auto* number = scalar<std::int64_t>(value)) return static_cast<double>(*number);
  return std::get<double>(value.items.front());
}

}  // namespace rows
}  // namespace config
