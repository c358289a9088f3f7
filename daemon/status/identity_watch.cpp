#include "daemon/status/identity_watch.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <string>

#include "text/counts.h"

namespace cansyncd {
namespace {

using std::chrono::days;
using std::chrono::seconds;

/// Each is told once.
constexpr std::array<seconds, 4> kSteps{IdentityWatch::kNotice, days{7}, days{1}, seconds{0}};

std::string date_text(IdentityWatch::WallTime at) {
  return fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::chrono::system_clock::to_time_t(at)));
}

constexpr const char* kAtTheEnd =
    "at that time DDS removes the daemon's participant: no client reaches it, and reference values stop";

std::string remedy(const gateway::dds::IdentityEnd& in_use,
                   const std::optional<gateway::dds::IdentityEnd>& on_disk) {
  if (on_disk && on_disk->at > in_use.at)
    return fmt::format("the files on disk are valid until {}: restart the daemon when the line may stop",
                       date_text(on_disk->at));
  if (in_use.is_authority)
    return "an authority cannot be renewed: make new ones (cansync-security init) and new identities for the daemon "
           "and all clients, and restart them when the line may stop";
  return "renew it where the authorities are (cansync-security renew DIR NAME), copy the folder DIR/NAME here, and "
         "restart the daemon when the line may stop";
}

}  // namespace

std::optional<EventText> IdentityWatch::look(WallTime now,
                                             const std::optional<gateway::dds::IdentityEnd>& on_disk) {
  if (!in_use_) return std::nullopt;
  const auto left = in_use_->at - now;
  const auto reached = static_cast<unsigned>(
      std::count_if(kSteps.begin(), kSteps.end(), [left](seconds step) { return left <= step; }));
  const bool is_new = reached > told_;
  told_ = reached;
  if (!is_new) return std::nullopt;
  const std::string what = fmt::format("the identity of DDS Security ({})", in_use_->file);
  const std::string how = remedy(*in_use_, on_disk);
  if (reached == kSteps.size())
    return EventText{gateway_SEVERITY_ERROR, "identity_ended", -1,
                     fmt::format("{} ended on {}; {}", what, date_text(in_use_->at), how), std::nullopt};
  const auto whole = std::chrono::floor<days>(left).count();
  return EventText{gateway_SEVERITY_WARNING, "identity_ending", -1,
                   fmt::format("{} ends on {}, in {}; {}; {}", what, date_text(in_use_->at),
                               whole == 0 ? std::string("less than a day")
                                          : text::counted(static_cast<std::uint64_t>(whole), "day"),
                               kAtTheEnd, how),
                   std::nullopt};
}

seconds IdentityWatch::time_left(WallTime now) const noexcept {
  if (!in_use_ || in_use_->at <= now) return seconds{0};
  return std::chrono::duration_cast<seconds>(in_use_->at - now);
}

}  // namespace cansyncd
