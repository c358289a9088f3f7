#include "daemon/cansync/status/profile_topic.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <set>
#include <vector>

#include "dds/bounded_text.h"
#include "profile/source.h"

namespace cansyncd {
namespace {

/// The bytes that 64 hexadecimal digits stand for.
void copy_hash(std::string_view digits, std::uint8_t (&out)[32]) {
  for (std::size_t i = 0; i < std::size(out) && 2 * i + 2 <= digits.size(); ++i)
    (void)std::from_chars(digits.data() + 2 * i, digits.data() + 2 * i + 2, out[i], 16);
}

}  // namespace

void ProfileTopic::tell(const Config& config) {
  std::set<std::string> wanted;
  for (const auto& slave : config.slaves) {
    if (slave.parameters == nullptr) continue;
    const profile::Profile& profile = *slave.parameters;
    if (!wanted.insert(profile.hash).second || told_.contains(profile.hash)) continue;
    gateway_DriveProfile sample = {};
    copy_hash(profile.hash, sample.hash);
    gateway::dds::copy_text(profile.name, sample.name);
    told_.emplace(profile.hash, sample);
    const profile::Source source = profile::source_of(profile.hash);
    sample.size = static_cast<std::uint32_t>(source.size);
    std::vector<std::uint8_t> text(source.text.begin(), source.text.end());
    sample.text._length = sample.text._maximum = static_cast<std::uint32_t>(text.size());
    sample.text._buffer = text.data();  // lent for the call
    (void)writer_.write(sample);
  }
  for (auto next = told_.begin(); next != told_.end();) {
    const auto here = next++;
    if (wanted.contains(here->first)) continue;
    (void)writer_.dispose(here->second);
    told_.erase(here);
  }
}

}  // namespace cansyncd
