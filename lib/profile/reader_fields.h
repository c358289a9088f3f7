#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/document.h"
#include "profile/profile.h"
#include "profile/reader.h"

/// One section of a table while it is read; only for readers.
namespace profile::detail {

/// Takes values out of a section by key, checks their type, and collects what is wrong. A key that is not
/// there gives nothing and is no problem.
class Fields {
 public:
  /// `prefix`: the name of the section, for the problems. All must outlive the object.
  Fields(const config::Content& content, std::string_view prefix, std::vector<config::Problem>& problems)
      : content_(content), prefix_(prefix), problems_(problems) {}

  bool has(std::string_view key) const { return content_.find(key) != nullptr; }
  /// Problems for every key that is none of these.
  void only(std::initializer_list<std::string_view> keys);
  /// A problem when the key is not there.
  void require(std::string_view key, std::string_view allowed);

  /// A string of at most `most` bytes without control characters.
  std::optional<std::string> text(std::string_view key, std::size_t most);
  /// A string without blanks as well.
  std::optional<std::string> word(std::string_view key, std::size_t most);
  /// A name as `is_name` takes it.
  std::optional<std::string> name(std::string_view key);
  /// The place in `choices` of a string.
  std::optional<std::size_t> choice(std::string_view key, std::initializer_list<std::string_view> choices);
  std::optional<std::int64_t> integer(std::string_view key, std::int64_t minimum, std::int64_t maximum);
  /// A finite number.
  std::optional<double> number(std::string_view key);
  std::optional<bool> flag(std::string_view key);

  /// A list of "NUMBER WORDS", each number 0..`highest` at most once; words that end in '!' tell a fault.
  std::vector<Meaning> meanings(std::string_view key, std::int64_t highest);

  /// A list of "NUMBER=VALUE", each parameter number at most once.
  std::vector<Recognition> recognitions(std::string_view key);

  /// A problem at the value of `key`, or at the section when the key is not there.
  void problem(std::string_view key, std::string text);

 private:
  /// What stands there, as a problem names it.
  std::string found(std::string_view key) const;
  void mismatch(std::string_view key, std::string_view allowed);

  template <class T>
  const T* value(std::string_view key) const;

  const config::Content& content_;
  std::string_view prefix_;
  std::vector<config::Problem>& problems_;
};

}  // namespace profile::detail
