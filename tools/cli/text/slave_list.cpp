#include "cli/text/slave_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "cli/text/values.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kHighestSlave = 31;
constexpr std::string_view kNumber = "{slave}";
constexpr std::string_view kName = "{name}";

std::vector<std::string_view> items_of(std::string_view text) {
  std::vector<std::string_view> items;
  for (;;) {
    const auto comma = text.find(',');
    items.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return items;
    text.remove_prefix(comma + 1);
  }
}

unsigned parse_number(std::string_view text) {
  return static_cast<unsigned>(parse_integer(text, "SLAVE", 0, kHighestSlave));
}

/// Mask of a number or a range of numbers.
std::uint32_t parse_numbers(std::string_view item) {
  const auto dash = item.find('-', 1);
  if (dash == std::string_view::npos) return 1u << parse_number(item);
  const unsigned first = parse_number(item.substr(0, dash));
  const unsigned last = parse_number(item.substr(dash + 1));
  if (first > last) {
    throw UsageError(
        fmt::format("SLAVE: found range '{}'; allowed: the smaller number first, such as 4-7", item));
  }
  std::uint32_t mask = 0;
  for (unsigned slave = first; slave <= last; ++slave) mask |= 1u << slave;
  return mask;
}

/// Refuses a list, range or word that a slave has for its name: whom it means cannot be said.
void expect_no_name(std::string_view text, const std::vector<std::string_view>& items,
                    const SlaveDirectory& directory) {
  const auto refuse_name = [&directory](std::string_view name) {
    const int slave = directory.find(name);
    if (slave < 0) return;
    throw UsageError(fmt::format(
        "SLAVE: '{}' is ambiguous: slave {} has this name, and it is a number, a range, a list or 'all', too; "
        "type {}, and give the slave another name in the configuration",
        name, slave, slave));
  };
  if (items.size() > 1) refuse_name(text);
  for (const std::string_view item : items)
    if (item == "all" || (looks_like_number(item) && item.find('-', 1) != std::string_view::npos))
      refuse_name(item);
}

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

}  // namespace

bool is_number_list(std::string_view text) noexcept {
  for (;;) {
    const auto comma = text.find(',');
    if (!looks_like_number(text.substr(0, comma))) return false;
    if (comma == std::string_view::npos) return true;
    text.remove_prefix(comma + 1);
  }
}

bool names_all(std::string_view text) noexcept {
  for (;;) {
    const auto comma = text.find(',');
    if (text.substr(0, comma) == "all") return true;
    if (comma == std::string_view::npos) return false;
    text.remove_prefix(comma + 1);
  }
}

void check_slave_list(std::string_view text) {
  for (const std::string_view item : items_of(text))
    if (looks_like_number(item)) static_cast<void>(parse_numbers(item));
}

std::uint32_t parse_slave_list(std::string_view text, const SlaveDirectory& directory) {
  const std::vector<std::string_view> items = items_of(text);
  std::uint32_t mask = 0;
  for (const std::string_view item : items)
    if (looks_like_number(item)) mask |= parse_numbers(item);
  expect_no_name(text, items, directory);
  for (const std::string_view item : items) {
    if (looks_like_number(item)) continue;
    if (item.empty()) {
      throw UsageError(fmt::format(
          "SLAVE: found '{}'; allowed: a number, a name, or a list of them such as 1,3,5-9,winder, or all",
          text));
    }
    if (item == "all") {
      mask |= directory.configured();
    } else if (const int slave = directory.find(item); slave >= 0) {
      mask |= 1u << static_cast<unsigned>(slave);
    } else {
      throw UsageError("SLAVE: " + directory.problem(item));
    }
  }
  if (mask == 0) throw UsageError("SLAVE: found 'all'; no slave is configured");
  return mask;
}

bool is_file_pattern(std::string_view pattern) noexcept {
  return pattern.find(kNumber) != std::string_view::npos || pattern.find(kName) != std::string_view::npos;
}

std::string file_of_slave(std::string_view pattern, unsigned slave, std::string_view name) {
  std::string file(pattern);
  // A name is put in last and alone: it may look like a placeholder itself.
  replace_all(file, kNumber, std::to_string(slave));
  if (file.find(kName) == std::string::npos) return file;
  if (name.empty() || name.find('/') != std::string_view::npos) {
    throw UsageError(fmt::format(
        "FILE: slave {} has the name '{}', which cannot be part of a file name; use {{slave}}", slave, name));
  }
  replace_all(file, kName, name);
  return file;
}

}  // namespace cansync::cli
