#include <cansync/function_blocks/actual_value_inbox.h>
#include <cansync/topics.h>

#include <mutex>

namespace cansync::client::function_blocks {

struct ActualValueInbox::Shared {
  std::mutex mutex;
  News news;
  std::array<std::uint64_t, 2> newest_interval = {};

  void add(const ActualValues& sample) {
    if (sample.slave >= news.values.size()) return;
    const std::lock_guard lock(mutex);
    news.arrived[sample.slave] |= sample.arrived;
    for (std::size_t i = 0; i < news.values[sample.slave].size(); ++i)
      news.values[sample.slave][i] = static_cast<DINT>(sample.raw[i]);
    for (unsigned telegram = 0; telegram < 2; ++telegram) {
      if (((sample.arrived >> telegram) & 1u) == 0 || sample.interval[telegram] < newest_interval[telegram])
        continue;
      newest_interval[telegram] = sample.interval[telegram];
      news.newest[telegram] = static_cast<SINT>(sample.slave);
    }
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
  return news;
}

}  // namespace cansync::client::function_blocks
