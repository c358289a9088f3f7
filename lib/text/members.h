#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "text/json.h"

/// Structs looked into by a table of their members: what shows all of them needs no list of its own. The
/// tables are made of the data model (idl/members.py). Pure functions; not for realtime threads.
namespace text {

enum class MemberType : std::uint8_t {
  boolean,
  octet,
  unsigned_short,
  signed_long,
  unsigned_long,
  signed_long_long,
  unsigned_long_long,
  real,
  text,      ///< characters with a zero at their end
  identity,  ///< 16 random bytes
  structure
};

/// One member.
struct Member {
  std::string_view name;
  std::string_view unit;  ///< "1": a plain number; empty: no number
  MemberType type;
  std::size_t offset;               ///< in the struct
  std::size_t size;                 ///< bytes, of one element
  std::size_t count;                ///< elements of an array; 0: no array
  std::span<const Member> members;  ///< of a structure
  std::string_view text;            ///< what it is, for people
};

/// The members of a struct that has a table, in the order of the data model.
template <class T>
struct HasNoTable;
template <class T>
inline constexpr std::span<const Member> members_of = HasNoTable<T>::none;

/// A member's value that is neither array nor structure; `element` of an array. An identity is a text of 32
/// hexadecimal digits.
using MemberValue = std::variant<bool, std::int64_t, std::uint64_t, double, std::string>;
MemberValue value_of(const Member& member, const void* sample, std::size_t element = 0);

/// The key of a member in JSON: its name, and its unit when that is a time or a share ("interval_length_ns").
std::string key_of(const Member& member);

/// Adds every member of a sample; `without`: but the one of that name.
void add_members(JsonObject& object, std::span<const Member> members, const void* sample,
                 std::string_view without = {});
template <class T>
void add_members(JsonObject& object, const T& sample, std::string_view without = {}) {
  add_members(object, members_of<T>, &sample, without);
}

}  // namespace text
