#include "cli/cansync/reference_effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

namespace cansync::cli {

std::string given_by_another(unsigned telegram, const client::MasterStatus& status, std::int32_t strength,
                             std::string_view consequence) {
  const auto& release = status.reference_release[telegram];
  const std::string_view writer = release.writer;
  if (writer.empty()) return "";
  const auto& guid = release.writer_guid;
  const bool program =
      std::any_of(std::begin(guid), std::end(guid), [](std::uint8_t byte) { return byte != 0; });
  if (!program) return fmt::format("telegram {} is given by {}, and no program may", telegram + 1, writer);
  if (strength > release.strength) return "";
  return fmt::format(
      "telegram {} is given by {} with strength {}: {}; --take-over or --strength {} takes over",
      telegram + 1, writer, release.strength, consequence, static_cast<std::int64_t>(release.strength) + 1);
}

std::int32_t strength_to_take_over(const Telegrams& telegrams, const client::MasterStatus& status,
                                   std::int32_t strength) noexcept {
  for (unsigned telegram = 0; telegram < telegrams.size(); ++telegram) {
    const std::int32_t other = status.reference_release[telegram].strength;
    if (telegrams[telegram].valid != 0 && other >= strength && other < INT32_MAX) strength = other + 1;
  }
  return strength;
}

ReferenceEffect::ReferenceEffect(const Telegrams& telegrams, std::int32_t strength, std::string own)
    : telegrams_(telegrams), strength_(strength), own_(std::move(own)) {}

void ReferenceEffect::take(const client::Event& event) {
  const std::string_view code = event.code;
  const std::string_view text = event.text;
  const unsigned telegram = text.find("telegram 2") != std::string_view::npos ? 1 : 0;
  if (code == "reference_refused") {
    const std::lock_guard lock(mutex_);
    known_[telegram].refused = text;
  }
  if (code != "reference_writer_began" && code != "reference_writer_taken_over") return;
  // Who begins stands first.
  if (text.substr(0, text.find("(strength")).find(own_) != std::string_view::npos)
    known_[telegram].heard = true;
}

std::string ReferenceEffect::look(const client::MasterStatus& status) {
  if (status.option_status == kActiveMaster) active_ = true;
  std::string now;
  for (unsigned telegram = 0; telegram < telegrams_.size(); ++telegram) {
    if (telegrams_[telegram].valid == 0) continue;
    Known& known = known_[telegram];
    const auto& release = status.reference_release[telegram];
    const std::string_view writer = release.writer;
    if (writer.find(own_) != std::string_view::npos) known.heard = true;
    // A stronger writer is heard with its first values, whatever the status of before says.
    known.giver = known.heard ? "" : writer;
    if (known.giver.empty()) continue;
    const std::string another = given_by_another(
        telegram, status, strength_,
        fmt::format("yours, with strength {}, have no effect while it gives them", strength_));
    if (!another.empty()) now += (now.empty() ? "" : "; ") + another;
  }
  if (now.empty() || now == told_) return "";
  told_ = now;
  return now;
}

bool ReferenceEffect::heard() const noexcept {
  for (unsigned telegram = 0; telegram < telegrams_.size(); ++telegram) {
    if (telegrams_[telegram].valid != 0 && !known_[telegram].heard) return false;
  }
  return true;
}

std::string ReferenceEffect::without_effect() const {
  if (!active_) return "the line was not in run; `cansync doctor` says how it gets there";
  const std::lock_guard lock(mutex_);
  for (unsigned telegram = 0; telegram < telegrams_.size(); ++telegram) {
    const Known& known = known_[telegram];
    if (telegrams_[telegram].valid == 0 || known.heard) continue;
    if (!known.giver.empty())
      return fmt::format("telegram {} is given by {}, whose strength is not lower", telegram + 1,
                         known.giver);
    if (!known.refused.empty()) return known.refused;
  }
  return "";
}

}  // namespace cansync::cli
