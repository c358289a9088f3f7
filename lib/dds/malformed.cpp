#include "dds/malformed.h"

#include <dds/ddsrt/log.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <string_view>

namespace gateway::dds {
namespace {

constexpr std::size_t kLines = 20;
constexpr std::size_t kLength = 200;

struct Line {
  std::array<char, kLength> text = {};
  std::size_t length = 0;

  void set(std::string_view message) noexcept {
    length = std::min(message.size(), text.size());
    std::copy_n(message.begin(), length, text.begin());
  }
  std::string string() const { return {text.data(), length}; }
};

struct Counted {
  std::mutex mutex;
  std::uint64_t count = 0;
  Line newest;
  std::array<Line, kLines> further;
  std::size_t lines = 0;
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
  Counted& all = counted();
  std::string_view message(data->message, data->size);
  while (message.ends_with('\n')) message.remove_suffix(1);
  const std::lock_guard lock(all.mutex);
  if (tells_of_malformed(message)) {
    ++all.count;
    all.newest.set(message);
  } else if (all.lines < kLines) {
    all.further[all.lines++].set(message);
  }
}

}  // namespace

void count_malformed() noexcept {
  dds_set_log_sink(on_log, nullptr);
}

Malformed take_malformed() {
  Counted& all = counted();
  const std::lock_guard lock(all.mutex);
  Malformed taken{all.count, all.newest.string(), {}};
  for (std::size_t i = 0; i < all.lines; ++i) taken.further.push_back(all.further[i].string());
  all.count = 0;
  all.newest.length = 0;
  all.lines = 0;
  return taken;
}

}  // namespace gateway::dds
