#pragma once

#include <mutex>
#include <optional>
#include <utility>

namespace cansyncd {

/// A configuration that was read again, on its way to the thread that takes it over. Any thread gives and
/// takes; of several given before one is taken the newest counts. Not realtime safe.
template <class Configuration>
class NewConfiguration {
 public:
  /// Leaves a configuration to be taken.
  void give(const Configuration& configuration) {
    const std::lock_guard lock(mutex_);
    waiting_ = configuration;
  }
  /// What was given since this was asked last; nothing: nothing was.
  std::optional<Configuration> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waiting_, std::nullopt);
  }

 private:
  std::mutex mutex_;
  std::optional<Configuration> waiting_;
};

}  // namespace cansyncd
