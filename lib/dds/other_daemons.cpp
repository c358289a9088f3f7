#include "dds/other_daemons.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "dds/bounded_text.h"
#include "text/visible.h"

namespace gateway::dds {
namespace {

/// Printable ASCII of what a peer says.
std::string printable(std::string_view said) {
  constexpr std::size_t kLongest = 255;  // of a name in DDS
  return ::text::visible_ascii(said.empty() ? "(not told)" : said, kLongest);
}

std::string own_name(const gateway_GatewayStatus& status) {
  return fmt::format("cansyncd {}, process {} on host {}", printable(text(status.version)), status.process,
                     printable(text(status.host)));
}

}  // namespace

OtherDaemons::OtherDaemons(const Participant& participant, const DaemonIdentity& own, DataSignal* signal)
    : own_(own), reader_(participant, signal) {}

OtherDaemons::News OtherDaemons::look() {
  News news;
  // Before the samples: who has left since then is gone with the next look.
  std::array<dds_instance_handle_t, kMost> matched = {};
  const dds_return_t count = dds_get_matched_publications(reader_.handle(), matched.data(), matched.size());
  const auto living =
      std::span(matched).first(std::min(static_cast<std::size_t>(std::max(count, 0)), matched.size()));
  (void)reader_.take_batch([&](const gateway_GatewayStatus& status, const dds_sample_info_t& info) {
    const DaemonIdentity identity = daemon_of(status);
    if (!info.valid_data || identity == own_ || there_.size() >= kMost) return;
    const auto known = std::find_if(there_.begin(), there_.end(), [&](const OtherDaemon& other) {
      return other.writer == info.publication_handle;
    });
    if (known != there_.end()) return;
    there_.push_back(
        {info.publication_handle, identity, own_name(status), printable(text(status.host)), status.process});
    news.came.push_back(there_.back());
  });
  std::erase_if(there_, [&](const OtherDaemon& other) {
    const auto is_it = [&](const OtherDaemon& each) { return each.writer == other.writer; };
    const bool here = std::find(living.begin(), living.end(), other.writer) != living.end() ||
                      std::any_of(news.came.begin(), news.came.end(), is_it);
    if (!here) news.gone.push_back(other);
    return !here;
  });
  return news;
}

std::vector<std::optional<OtherDaemon>> names_in_use(std::span<const Participant> buses) {
  using Clock = std::chrono::steady_clock;
  DataSignal signal;
  std::vector<OtherDaemons> others;
  others.reserve(buses.size());
  for (const Participant& bus : buses) others.emplace_back(bus, DaemonIdentity{}, &signal);
  const auto begin = Clock::now();
  const auto found = [&] {
    return std::any_of(others.begin(), others.end(), [](const auto& bus) { return !bus.there().empty(); });
  };
  const auto alone = [&] {
    return std::all_of(buses.begin(), buses.end(), [](const auto& bus) { return bus.others() == 0; });
  };
  while (!found()) {
    const auto waited = Clock::now() - begin;
    const auto end = alone() ? kShortLook : kLongestLook;
    if (waited >= end) break;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - waited);
    // Others are found without a signal.
    constexpr std::chrono::milliseconds kLook{20};
    (void)signal.wait(static_cast<int>(std::min(left, kLook).count()));
    signal.clear();
    for (OtherDaemons& bus : others) (void)bus.look();
  }
  std::vector<std::optional<OtherDaemon>> first;
  first.reserve(others.size());
  for (const OtherDaemons& bus : others)
    first.push_back(bus.there().empty() ? std::nullopt : std::optional(bus.there().front()));
  return first;
}

}  // namespace gateway::dds
