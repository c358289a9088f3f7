#include "dds/malformed.h"

#include <dds/ddsrt/log.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <string_view>

namespace cansync::dds {
namespace {

struct Counted {
  std::mutex mutex;
  std::uint64_t count = 0;
  std::array<char, 200> newest = {};
  std::size_t length = 0;
  std::chrono::steady_clock::time_point second;
  unsigned lines = 0;
};

Counted& counted() noexcept {
  static Counted counted;
  return counted;
}

/// Cyclone's words for samples and packets it could not read (q_receive.c, version 0.10).
bool tells_of_malformed(std::string_view message) noexcept {
  const auto has = [message](std::string_view words) {
    return message.find(words) != std::string_view::npos;
  };
  return (has("deserialization") && has("failed")) || has("malformed packet") || has("malformed submessage");
}

/// Called by whichever thread logs, and never with an exception out of it.
void on_log(void* /*argument*/, const dds_log_data_t* data) {
  constexpr unsigned kLines = 20;
  Counted& all = counted();
  std::string_view message(data->message, data->size);
  while (message.ends_with('\n')) message.remove_suffix(1);
  const std::lock_guard lock(all.mutex);
  if (tells_of_malformed(message)) {
    ++all.count;
    all.length = std::min(message.size(), all.newest.size());
    std::copy_n(message.begin(), all.length, all.newest.begin());
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (now - all.second >= std::chrono::seconds(1)) {
    all.second = now;
    all.lines = 0;
  }
  if (all.lines++ >= kLines) return;
  (void)std::fprintf(stderr, "%.*s\n", static_cast<int>(message.size()), message.data());
}

}  // namespace

void count_malformed() noexcept {
  dds_set_log_sink(on_log, nullptr);
}

Malformed take_malformed() {
  Counted& all = counted();
  const std::lock_guard lock(all.mutex);
  Malformed taken{all.count, std::string(all.newest.data(), all.length)};
  all.count = 0;
  all.length = 0;
  return taken;
}

}  // namespace cansync::dds
