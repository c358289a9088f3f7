#include <cansync/function_blocks/actual_value_inbox.h>
#include <cansync/topics.h>

#include <mutex>
#include <optional>
#include <utility>

namespace cansync::client::function_blocks {

struct ActualValueInbox::Shared {
  std::mutex mutex;
  News news;
  std::array<std::uint64_t, 2> newest_interval = {};  ///< of what came since the last look
  /// Interval of the telegram that is known of each slave; empty: none. Numbers begin anew with a daemon.
  std::array<std::array<std::optional<std::uint64_t>, 2>, 32> known = {};

  void add(const ActualValues& sample) {
    if (sample.slave >= news.values.size()) return;
    const std::lock_guard lock(mutex);
    const unsigned fresh = fresh_telegrams(sample);
    news.arrived[sample.slave] |= static_cast<std::uint8_t>(fresh);
    for (std::size_t i = 0; i < news.values[sample.slave].size(); ++i)
      news.values[sample.slave][i] = static_cast<DINT>(sample.raw[i]);
    for (unsigned telegram = 0; telegram < 2; ++telegram) {
      if (((fresh >> telegram) & 1u) == 0 || sample.interval[telegram] < newest_interval[telegram]) continue;
      newest_interval[telegram] = sample.interval[telegram];
      news.newest[telegram] = static_cast<SINT>(sample.slave);
    }
  }

  /// Which telegrams of a sample are news. The first ones of a slave are not: they may be what the daemon
  /// kept from long ago and gives to whoever comes.
  unsigned fresh_telegrams(const ActualValues& sample) {
    unsigned fresh = 0;
    for (unsigned telegram = 0; telegram < 2; ++telegram) {
      if ((((sample.arrived | sample.ever) >> telegram) & 1u) == 0) continue;
      const std::optional<std::uint64_t> before =
          std::exchange(known[sample.slave][telegram], sample.interval[telegram]);
      if (((sample.arrived >> telegram) & 1u) != 0 && before && *before != sample.interval[telegram])
        fresh |= 1u << telegram;
    }
    return fresh;
  }
};

ActualValueInbox::ActualValueInbox(Client& client)
    : shared_(std::make_shared<Shared>()),
      subscription_(
          client.on_actual_values([shared = shared_](const ActualValues& sample) { shared->add(sample); })) {}

ActualValueInbox::News ActualValueInbox::take() {
  const std::lock_guard lock(shared_->mutex);
  const News news = shared_->news;
  shared_->news.arrived = {};
  shared_->news.newest = {kAutomaticNumber, kAutomaticNumber};
  shared_->newest_interval = {};
  return news;
}

}  // namespace cansync::client::function_blocks
