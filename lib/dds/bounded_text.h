#pragma once

#include <cstddef>
#include <string_view>

/// Bounded strings of the data model, as the C types have them.
namespace gateway::dds {

/// Copies `text` into a bounded IDL string, cut at the end (at a UTF-8 character) if too long; always
/// terminated.
void copy_text(std::string_view text, char* out, std::size_t size) noexcept;
template <std::size_t N>
void copy_text(std::string_view text, char (&out)[N]) noexcept {
  copy_text(text, out, N);
}

/// A bounded IDL string.
template <std::size_t N>
std::string_view text(const char (&in)[N]) noexcept {
  std::size_t length = 0;
  while (length < N && in[length] != '\0') ++length;
  return {in, length};
}

}  // namespace gateway::dds
