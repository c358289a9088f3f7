#include "cansync/config/expect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include "cansync/config/return_parameters.h"
#include "profile/passport.h"
#include "profile/scaling.h"

namespace cansyncd {
namespace {

using cansync::ParameterValue;

constexpr std::string_view kProfile = "profile";
constexpr std::string_view kPassport = "passport ";

/// What is wrong with an item; ends the reading.
struct Wrong : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Collects what the items of one slave stand for.
class Reader {
 public:
  Reader(const profile::Profile* profile, const std::string& folder) : profile_(profile), folder_(folder) {}

  void take(const std::string& item) {
    if (item == kProfile) return take_profile();
    if (item.starts_with(kPassport)) return take_passport(item.substr(kPassport.size()));
    take_pair(item);
  }

  std::vector<ParameterValue> values() && { return std::move(values_); }

 private:
  void add(unsigned number, std::uint32_t value, const std::string& from) {
    const auto parameter = cansync::ParameterNumber::from(number);
    if (!parameter) throw Wrong(fmt::format("found {}; allowed: parameter numbers 0..4095", from));
    const auto known = std::find_if(values_.begin(), values_.end(),
                                    [&](const ParameterValue& one) { return one.number == *parameter; });
    if (known == values_.end()) {
      if (values_.size() == cansync::kListedParameters)
        throw Wrong(
            fmt::format("found more parameters than {0}; allowed: at most {0}", cansync::kListedParameters));
      values_.push_back({*parameter, value});
    } else if (known->value != value) {
      throw Wrong(fmt::format("found parameter {} with the values {} and {}; allowed: one value", number,
                              known->value, value));
    }
  }

  void take_profile() {
    if (profile_ == nullptr) throw Wrong("found \"profile\" without a profile; allowed: with slave.profile");
    if (profile_->recognised_by.empty())
      throw Wrong(fmt::format(
          "found \"profile\", but profile {} has no recognised_by; allowed: \"NAME=VALUE\"", profile_->name));
    for (const profile::Recognition& one : profile_->recognised_by) add(one.number, one.value, "profile");
  }

  void take_passport(const std::string& name) {
    std::filesystem::path path = name;
    if (path.is_relative()) path = std::filesystem::path(folder_) / path;
    profile::PassportReading reading;
    try {
      reading = profile::read_passport(path.string());
    } catch (const std::runtime_error& error) {
      throw Wrong(error.what());
    }
    const profile::Passport& passport = *reading.passport;
    if (reading.changed)
      throw Wrong(
          fmt::format("{}: found a checksum that does not fit; allowed: a passport as `cansync backup` "
                      "has written it",
                      path.string()));
    std::size_t found = 0;
    for (const profile::PassportEntry& entry : passport.entries) {
      if (entry.identity == profile::Identity::none || !entry.raw) continue;
      add(entry.number, *entry.raw, entry.name);
      ++found;
    }
    if (found == 0)
      throw Wrong(
          fmt::format("{}: found no line 'type' or 'unit' with a value; allowed: a passport of a drive "
                      "whose profile gives identity to a parameter",
                      path.string()));
  }

  void take_pair(const std::string& item) {
    const std::size_t equals = item.find('=');
    const std::string left = item.substr(0, equals);
    const std::string right = item.substr(equals + 1);
    if (const auto number = to_raw_number(left)) {
      const auto value = to_raw_number(right);
      if (!value)
        throw Wrong(fmt::format("found \"{}\"; allowed: a raw value 0..4294967295, decimal or 0x..", item));
      if (profile_ != nullptr) check(profile_->find(*number), *value, item);
      return add(*number, *value, '"' + item + '"');
    }
    if (profile_ == nullptr)
      throw Wrong(
          fmt::format("found \"{}\"; allowed: a parameter number, or a name with slave.profile", item));
    const profile::Parameter* parameter = profile_->find(std::string_view(left));
    if (parameter == nullptr)
      throw Wrong(fmt::format("found \"{}\"; allowed: a name that profile {} has", item, profile_->name));
    add(parameter->number, value_of(*parameter, right, item), '"' + item + '"');
  }

  /// A value in the parameter's unit, or raw as 0x...
  static std::uint32_t value_of(const profile::Parameter& parameter, const std::string& text,
                                const std::string& item) {
    if (const auto raw = to_raw_number(text); raw && text.size() > 1 && (text[1] == 'x' || text[1] == 'X')) {
      check(&parameter, *raw, item);
      return *raw;
    }
    const auto scaled = profile::to_raw(parameter, text);
    if (const auto* refused = std::get_if<profile::Refused>(&scaled))
      throw Wrong(fmt::format("found \"{}\": {}", item, refused->text));
    const std::uint32_t raw = std::get<std::uint32_t>(scaled);
    check(&parameter, raw, item);
    return raw;
  }

  /// Can the parameter tell who a drive is, and hold the value?
  static void check(const profile::Parameter* parameter, std::uint32_t raw, const std::string& item) {
    if (parameter == nullptr) return;
    if (parameter->format == profile::Format::word && raw > 0xFFFF)
      throw Wrong(
          fmt::format("found \"{}\": {} is a word; allowed: 0..65535", item, profile::label(*parameter)));
    if (parameter->access == profile::Access::none)
      throw Wrong(fmt::format("found \"{}\": {} cannot be read; allowed: one that can", item,
                              profile::label(*parameter)));
    if (parameter->is_volatile)
      throw Wrong(fmt::format("found \"{}\": {} changes while the drive runs; allowed: one that stays", item,
                              profile::label(*parameter)));
  }

  const profile::Profile* profile_;
  const std::string& folder_;
  std::vector<ParameterValue> values_;
};

bool is_form(const std::string& item) {
  if (item == kProfile) return true;
  if (item.starts_with(kPassport)) return item.size() > kPassport.size();
  const std::size_t equals = item.find('=');
  return equals != std::string::npos && equals > 0 && equals + 1 < item.size();
}

}  // namespace

bool takes_expect(const Draft& /*draft*/, const Value& value) {
  if (value.kind != Value::Kind::list || value.items.size() > cansync::kListedParameters) return false;
  return std::all_of(value.items.begin(), value.items.end(), [](const Scalar& item) {
    const auto* text = std::get_if<std::string>(&item);
    return text != nullptr && is_form(*text);
  });
}

std::variant<std::vector<ParameterValue>, std::string> expected_values(const std::vector<std::string>& items,
                                                                       const profile::Profile* profile,
                                                                       const std::string& folder) {
  try {
    Reader reader(profile, folder);
    for (const std::string& item : items) reader.take(item);
    return std::move(reader).values();
  } catch (const Wrong& wrong) {
    return std::string(wrong.what());
  }
}

}  // namespace cansyncd
