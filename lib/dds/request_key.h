#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace gateway::dds {

/// Who asked, and by which number: all that is to be kept of a request until it is answered.
struct RequestKey {
  std::array<std::uint8_t, 16> client = {};
  std::uint64_t request = 0;
  friend bool operator==(const RequestKey&, const RequestKey&) = default;
};
/// Of a request of any kind.
template <class Request>
RequestKey key_of(const Request& request) noexcept {
  RequestKey key;
  for (std::size_t i = 0; i < key.client.size(); ++i) key.client[i] = request.client[i];
  key.request = request.request;
  return key;
}

}  // namespace gateway::dds
