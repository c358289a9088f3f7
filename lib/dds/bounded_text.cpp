#include "dds/bounded_text.h"

#include <algorithm>

namespace gateway::dds {

void copy_text(std::string_view text, char* out, std::size_t size) noexcept {
  if (size == 0) return;
  std::size_t length = std::min(text.size(), size - 1);
  if (length < text.size()) {
    // 10xxxxxx continues a UTF-8 character: do not cut inside one.
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0u) == 0x80u) --length;
  }
  std::copy_n(text.begin(), length, out);
  std::fill(out + length, out + size, '\0');
}

}  // namespace gateway::dds
