#include "text/members.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstring>

namespace text {
namespace {

template <class T>
T read(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

const std::byte* place_of(const Member& member, const void* sample, std::size_t element) {
  return static_cast<const std::byte*>(sample) + member.offset + element * member.size;
}

std::string text_at(const std::byte* from, std::size_t size) {
  const std::string_view all(reinterpret_cast<const char*>(from), size);
  return std::string(all.substr(0, all.find('\0')));
}

void add_value(JsonArray& array, const MemberValue& value) {
  std::visit([&array](const auto& known) { array.add(known); }, value);
}

std::string object_text(const Member& member, const void* sample, std::size_t element) {
  JsonObject object;
  add_members(object, member.members, place_of(member, sample, element));
  return object.text();
}

}  // namespace

MemberValue value_of(const Member& member, const void* sample, std::size_t element) {
  const std::byte* from = place_of(member, sample, element);
  switch (member.type) {
    case MemberType::boolean:
      return read<bool>(from);
    case MemberType::octet:
      return std::uint64_t{read<std::uint8_t>(from)};
    case MemberType::unsigned_short:
      return std::uint64_t{read<std::uint16_t>(from)};
    case MemberType::signed_long:
      return std::int64_t{read<std::int32_t>(from)};
    case MemberType::unsigned_long:
      return std::uint64_t{read<std::uint32_t>(from)};
    case MemberType::signed_long_long:
      return read<std::int64_t>(from);
    case MemberType::unsigned_long_long:
      return read<std::uint64_t>(from);
    case MemberType::real:
      return read<double>(from);
    case MemberType::identity:
      return fmt::format("{:02x}", fmt::join(read<std::array<std::uint8_t, 16>>(from), ""));
    case MemberType::text:
    case MemberType::structure:
      break;
  }
  return text_at(from, member.size);
}

std::string key_of(const Member& member) {
  for (const std::string_view unit : {"ns", "ms", "permille"})
    if (member.unit == unit) return fmt::format("{}_{}", member.name, unit);
  return std::string(member.name);
}

void add_members(JsonObject& object, std::span<const Member> members, const void* sample,
                 std::string_view without) {
  for (const Member& member : members) {
    if (!without.empty() && member.name == without) continue;
    const std::string key = key_of(member);
    if (member.count == 0 && member.type == MemberType::structure) {
      object.add_json(key, object_text(member, sample, 0));
    } else if (member.count == 0) {
      std::visit([&](const auto& value) { object.add(key, value); }, value_of(member, sample));
    } else {
      JsonArray array;
      for (std::size_t element = 0; element < member.count; ++element) {
        if (member.type == MemberType::structure)
          array.add_json(object_text(member, sample, element));
        else
          add_value(array, value_of(member, sample, element));
      }
      object.add(key, array);
    }
  }
}

}  // namespace text
