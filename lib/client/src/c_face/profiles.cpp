#include <cansync/topics.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstddef>
#include <limits>

#include "client/src/c_face/handle.h"
#include "profile/named.h"
#include "profile/scaling.h"
#include "text/counts.h"

/// Parameters by name and in their unit, of the C face.
namespace {

using cansync::client::Client;
using cansync::client::SlaveStatus;
using cansync::client::c_face::connected;
using cansync::client::c_face::fail;

constexpr std::uint32_t kHighestParameter = 4095;

template <std::size_t N>
void copy_to(char (&to)[N], std::string_view from) {
  const std::size_t count = std::min(from.size(), N - 1);
  std::copy_n(from.begin(), count, to);
  to[count] = '\0';
}

cansync_parameter_info to_c(const profile::Parameter& from) {
  cansync_parameter_info to = {};
  to.number = from.number;
  copy_to(to.name, from.name);
  copy_to(to.unit, from.unit);
  copy_to(to.group, from.group);
  copy_to(to.text, from.text);
  to.doubleword = from.format == profile::Format::doubleword ? 1 : 0;
  to.is_signed = from.is_signed ? 1 : 0;
  to.factor = from.factor;
  to.offset = from.offset;
  to.access = static_cast<int>(from.access);
  to.is_volatile = from.is_volatile ? 1 : 0;
  to.limited = from.limited ? 1 : 0;
  to.minimum = from.minimum;
  to.maximum = from.maximum;
  return to;
}
static_assert(static_cast<int>(profile::Access::none) == 2);

/// A number without a profile: any value of 32 bits, as it is.
cansync_parameter_info unknown(std::uint32_t number) {
  profile::Parameter plain;
  plain.number = static_cast<std::uint16_t>(number);
  plain.format = profile::Format::doubleword;
  cansync_parameter_info info = to_c(plain);
  info.doubleword = -1;
  return info;
}

/// What scaling and limits look at.
profile::Parameter of_c(const cansync_parameter_info& from) {
  profile::Parameter to;
  to.number = static_cast<std::uint16_t>(from.number);
  to.name = from.name[0] == '\0' ? "value" : from.name;
  to.unit = from.unit;
  to.format = from.doubleword != 0 ? profile::Format::doubleword : profile::Format::word;
  to.is_signed = from.is_signed != 0;
  to.factor = from.factor;
  to.offset = from.offset;
  to.access = static_cast<profile::Access>(from.access);
  to.limited = from.limited != 0;
  to.minimum = to.limited ? from.minimum : profile::format_minimum(to);
  to.maximum = to.limited ? from.maximum : profile::format_maximum(to);
  return to;
}

/// The profile of a slave as the daemon names it now; each file is read once.
profile::NamedProfile profile_of(cansync_client& open, const Client& client, std::uint32_t number) {
  const auto is_it = [&](const SlaveStatus& status) { return status.slave == number; };
  std::vector<SlaveStatus> slaves = client.slaves(std::chrono::milliseconds(0));
  auto slave = std::find_if(slaves.begin(), slaves.end(), is_it);
  if (slave == slaves.end()) {
    slaves = client.slaves();
    slave = std::find_if(slaves.begin(), slaves.end(), is_it);
  }
  if (slave == slaves.end()) return {nullptr, fmt::format("slave {} is not configured", number)};
  const std::string_view name = cansync::client::text(slave->profile);
  if (name.empty()) {
    return {nullptr,
            fmt::format("slave {} has no profile, so that its parameters have no names; set profile = "
                        "\"NAME\" in its [[slave]] section of the daemon's configuration",
                        number)};
  }
  const std::string hash(cansync::client::text(slave->profile_hash));
  if (const auto known = open.profiles.find(hash); known != open.profiles.end()) return known->second;
  profile::NamedProfile found =
      profile::find_named(name, hash, open.profile_folders, {"the option profiles of the connection", ""});
  if (found.profile == nullptr) return {nullptr, fmt::format("slave {}: {}", number, found.problem)};
  return open.profiles[hash] = std::move(found);
}

int forbid(cansync_client& open, const profile::Refused& refused) {
  open.cause = cansync::client::RefusalCause::profile;
  return fail(open, CANSYNC_REFUSED, "client: " + refused.text);
}

/// Decimal, or hexadecimal with 0x; nothing when `text` is no number.
std::optional<std::uint32_t> parse_number(std::string_view text) {
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (hexadecimal) text.remove_prefix(2);
  std::uint32_t value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value, hexadecimal ? 16 : 10);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

int cansync_find_parameter(cansync_client* handle, uint32_t slave, const char* number_or_name,
                           cansync_parameter_info* out) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (number_or_name == nullptr || out == nullptr)
      return fail(open, CANSYNC_INVALID, "client: number_or_name or out is NULL");
    const auto number = parse_number(number_or_name);
    if (number && *number > kHighestParameter)
      return fail(open, CANSYNC_INVALID, fmt::format("client: parameter {}: allowed 0..4095", *number));
    const profile::NamedProfile found = profile_of(open, client, slave);
    if (found.profile == nullptr && !number)
      return fail(open, CANSYNC_INVALID, fmt::format("client: '{}': {}", number_or_name, found.problem));
    const profile::Parameter* parameter = nullptr;
    if (found.profile != nullptr)
      parameter =
          number ? found.profile->find(*number) : found.profile->find(std::string_view(number_or_name));
    if (parameter == nullptr && !number) {
      return fail(open, CANSYNC_INVALID,
                  fmt::format("client: profile '{}' of slave {} has no parameter '{}'; allowed: 0..4095 or a "
                              "name of the profile",
                              found.profile->name, slave, number_or_name));
    }
    *out = parameter != nullptr ? to_c(*parameter) : unknown(*number);
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_list_parameter(cansync_client* handle, uint32_t slave, uint32_t index,
                           cansync_parameter_info* out) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (out == nullptr) return fail(open, CANSYNC_INVALID, "client: out is NULL");
    const profile::NamedProfile found = profile_of(open, client, slave);
    if (found.profile == nullptr) return fail(open, CANSYNC_INVALID, "client: " + found.problem);
    const std::vector<profile::Parameter>& parameters = found.profile->parameters;
    if (index >= parameters.size()) {
      return fail(open, CANSYNC_NO_DATA,
                  fmt::format("client: profile '{}' has {}", found.profile->name,
                              text::counted(parameters.size(), "parameter")));
    }
    *out = to_c(parameters[index]);
    return static_cast<int>(CANSYNC_DONE);
  });
}

double cansync_to_unit(const cansync_parameter_info* parameter, uint32_t raw) noexcept {
  constexpr std::uint32_t kGreatestWord = 0xFFFF;
  if (parameter->doubleword == 0 && raw > kGreatestWord) return std::numeric_limits<double>::quiet_NaN();
  profile::Parameter plain;
  plain.format = parameter->doubleword != 0 ? profile::Format::doubleword : profile::Format::word;
  plain.is_signed = parameter->is_signed != 0;
  plain.factor = parameter->factor;
  plain.offset = parameter->offset;
  return profile::scaled(plain, profile::raw_number(plain, raw));
}

int cansync_from_unit(cansync_client* handle, const cansync_parameter_info* parameter, double value,
                      uint32_t* raw) noexcept {
  return connected(handle, [&](cansync_client& open, Client&) {
    if (parameter == nullptr || raw == nullptr)
      return fail(open, CANSYNC_INVALID, "client: parameter or raw is NULL");
    const profile::Parameter known = of_c(*parameter);
    const auto nearest = profile::to_raw(known, fmt::format("{}", value));
    if (const auto* refused = std::get_if<profile::Refused>(&nearest)) return forbid(open, *refused);
    if (const auto refused = profile::write_problem(known, std::get<std::uint32_t>(nearest)))
      return forbid(open, *refused);
    *raw = std::get<std::uint32_t>(nearest);
    return static_cast<int>(CANSYNC_DONE);
  });
}
