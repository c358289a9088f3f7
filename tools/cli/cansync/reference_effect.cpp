#include "cli/cansync/reference_effect.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace cansync::cli {

std::string name_of_this_process() {
  // The daemon shortens what peers say of themselves.
  constexpr std::size_t kLongestPart = 40;
  std::array<char, 256> host{};
  static_cast<void>(::gethostname(host.data(), host.size() - 1));
  return fmt::format("process {} on host {}", ::getpid(),
                     std::string_view(host.data()).substr(0, kLongestPart));
}

ReferenceEffect::ReferenceEffect(const Telegrams& telegrams, std::int32_t strength, std::string own)
    : telegrams_(telegrams), strength_(strength), own_(std::move(own)) {}

void ReferenceEffect::take(const client::Event& event) {
  const std::string_view code = event.code;
  if (code != "reference_writer_began" && code != "reference_writer_taken_over") return;
  // Who begins stands first.
  const std::string_view text = event.text;
  if (text.substr(0, text.find("(strength")).find(own_) != std::string_view::npos) heard_ = true;
}

std::string ReferenceEffect::look(const client::MasterStatus& status) {
  std::string now;
  for (unsigned telegram = 0; telegram < telegrams_.size(); ++telegram) {
    if (telegrams_[telegram].valid == 0) continue;
    const auto& release = status.reference_release[telegram];
    const std::string_view writer = release.writer;
    if (writer.empty()) continue;
    if (writer.find(own_) != std::string_view::npos) {
      heard_ = true;
      continue;
    }
    now = fmt::format(
        "telegram {} is given by {} with strength {}: yours, with strength {}, have no effect while it gives "
        "them; --strength {} takes over",
        telegram + 1, writer, release.strength, strength_,
        static_cast<std::int64_t>(std::max(release.strength, strength_)) + 1);
  }
  if (status.option_status == kActiveMaster && heard_) had_effect_ = true;
  // A stronger writer is heard with its first values, whatever the status of before says.
  if (heard_ || now == told_) return "";
  told_ = now;
  return now;
}

}  // namespace cansync::cli
