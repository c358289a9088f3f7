#include "daemon/service/journal_queue.h"

#include <fmt/format.h>
#include <pthread.h>

#include <condition_variable>
#include <csignal>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "text/counts.h"

namespace cansyncd {
namespace {

/// Blocks every signal as long as it lives: threads started meanwhile take none.
class NoSignals {
 public:
  NoSignals() {
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~NoSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  NoSignals(const NoSignals&) = delete;
  NoSignals& operator=(const NoSignals&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

struct JournalQueue::Waiting {
  struct Entry {
    LogPriority priority;
    EventCode event;
    std::string message;
    std::vector<JournalField> fields;
  };

  Waiting(JournalSink& sink_in, std::string bus_in, JournalQueueLimits limits_in)
      : sink(sink_in), bus(std::move(bus_in)), limits(limits_in) {}

  void push(Entry entry) {
    const std::lock_guard lock(mutex);
    // Once one is lost all are, until that is told: entries keep their order.
    if (lost > 0 || entries.size() >= limits.entries) {
      ++lost;
      return;
    }
    entries.push_back(std::move(entry));
    changed.notify_all();
  }

  void run() {
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [this] { return stop || !entries.empty(); });
      if (entries.empty()) break;
      const Entry entry = std::move(entries.front());
      entries.pop_front();
      if (lost > 0 && entries.size() <= limits.entries / 2) tell_lost();
      lock.unlock();
      sink.write(entry.priority, entry.event, entry.message, entry.fields);
      lock.lock();
    }
    ended = true;
    changed.notify_all();
  }

  /// With the lock.
  void tell_lost() {
    entries.push_back(
        {LogPriority::warning,
         "journal_entries_lost",
         fmt::format("{} lost: the journal, or whoever reads standard error, did not take them in time",
                     text::counted(std::exchange(lost, 0), "entry of the journal was",
                                   "entries of the journal were")),
         {{"BUS", bus}}});
  }

  /// False: the thread is still in a write, and ends when that returns.
  bool end() {
    std::unique_lock lock(mutex);
    stop = true;
    changed.notify_all();
    if (changed.wait_for(lock, limits.at_end, [this] { return ended; })) return true;
    entries.clear();
    return false;
  }

  JournalSink& sink;
  const std::string bus;
  const JournalQueueLimits limits;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Entry> entries;
  std::size_t lost = 0;
  bool stop = false;
  bool ended = false;
  std::thread thread;
};

JournalQueue::JournalQueue(JournalSink& sink, std::string bus, JournalQueueLimits limits)
    : waiting_(std::make_shared<Waiting>(sink, std::move(bus), limits)) {
  const NoSignals no_signals;
  waiting_->thread = std::thread([waiting = waiting_] {
    pthread_setname_np(pthread_self(), "cansync-journal");  // for `top -H` and whoever measures
    waiting->run();
  });
}

JournalQueue::~JournalQueue() {
  if (waiting_->end()) {
    waiting_->thread.join();
  } else {
    waiting_->thread.detach();
  }
}

void JournalQueue::write(LogPriority priority, EventCode event, const std::string& message,
                         const std::vector<JournalField>& fields) {
  waiting_->push({priority, event, message, fields});
}

}  // namespace cansyncd
