// Every public function of the client's classes and of the C face ends within the time that its documentation names, whatever its daemon
// does and from whatever callback it is called. The calls are made from the headers (every_call.py).
#include <cansync/cansync_c.h>
#include <cansync/client.h>
#include <cansync/reference_repeater.h>
#include <cansync/topics.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "client/client_rig.h"
#include "client/fake_daemon.h"
#include "client/src/c_face/handle.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

namespace cansync::client {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// Five times what is documented: a computer that stands still for a moment is no fault, a wait without an end is.
constexpr std::chrono::seconds kMost(10);

/// What the calls are made on, each thread with its own.
struct On {
  Client& client;
  ReferenceWriter& writer;
  ReferenceRepeater& repeater;
  TransferJob& job;
  const std::atomic<bool>& stop;
  std::string words;  ///< that the last call gave as a reason
};

template <class T>
void said(On& on, T&& value) {
  if constexpr (std::is_base_of_v<Reply, std::decay_t<T>>) on.words = describe(value);
  if constexpr (std::is_same_v<std::decay_t<T>, SlaveLookup>) on.words = value.problem;
}

template <class T>
std::shared_ptr<void> kept(T&& value) {
  return std::make_shared<std::decay_t<T>>(std::forward<T>(value));
}

struct Call {
  const char* name;
  void (*run)(On& on);
};
/// A call that takes a callback; what it gives keeps the callback alive.
struct Callback {
  const char* name;
  std::shared_ptr<void> (*run)(On& on, const std::function<void()>& run);
};

/// Likewise of the C face, whose handles are for one thread at a time.
struct OnC {
  cansync_client& handle;
  cansync_job* job;
  void* user;  ///< of callbacks that run something: a std::function<void()>
};

struct CCall {
  const char* name;
  void (*run)(OnC& on);
};
struct CSubscription {
  const char* name;
  std::shared_ptr<void> (*run)(OnC& on);
};

/// Where the C face puts what it gives.
template <class T>
T* room() {
  thread_local T value = {};
  return &value;
}

void run_from(void* user) {
  (*static_cast<const std::function<void()>*>(user))();
}

#include "every_call.inc"

/// What went wrong, of several threads.
class Faults {
 public:
  void add(const std::string& text) {
    const std::lock_guard lock(mutex_);
    text_ += text + "\n";
  }
  std::string text() {
    const std::lock_guard lock(mutex_);
    return text_;
  }

 private:
  std::mutex mutex_;
  std::string text_;
};

/// The daemon of these tests has the library's own protocol and data model.
bool is_false(const std::string& reason) {
  return reason.find("data model") != std::string::npos || reason.find("it speaks") != std::string::npos;
}

/// Its writer and repeater find a daemon; the job is one that would never end by itself.
class Objects {
 public:
  explicit Objects(Client& client)
      : writer_(client),
        repeater_(client, std::chrono::milliseconds(20)),
        job_(client.submit(TransferRequest{
            .slave = 1, .address = FakeDaemon::kEndlessAddress, .length = 4, .timeout_ms = 50})),
        on_{client, writer_, repeater_, job_, stop_, ""} {}
  On& on() { return on_; }

  /// Calls everything; `where` is said with each fault.
  void call_all(const std::string& where, Faults& faults) {
    for (const Call& call : kCalls) {
      const auto began = Clock::now();
      std::string words;
      on_.words.clear();
      try {
        call.run(on_);
        words = on_.words;
      } catch (const NoDaemon& error) {
        words = error.what();
      }
      if (Clock::now() - began > kMost) faults.add(where + ": " + call.name + " took too long");
      if (is_false(words)) faults.add(where + ": " + call.name + " says: " + words);
    }
  }

 private:
  ReferenceWriter writer_;
  ReferenceRepeater repeater_;
  TransferJob job_;
  std::atomic<bool> stop_ = false;
  On on_;
};

/// The objects of the C face, on a connection of their own.
class CObjects {
 public:
  /// `run`: in callbacks of what `kCSubscriptions` has.
  explicit CObjects(
      const Options& options, std::function<void()> run = [] {})
      : run_(std::move(run)) {
    handle_.client.emplace(Client::connect(options));
    const cansync_transfer_request endless = {
        .slave = 1, .address = FakeDaemon::kEndlessAddress, .size = 4, .timeout_ms = 50};
    job_.reset(cansync_submit_transfer(&handle_, &endless));
    on_.job = job_.get();
    (void)cansync_take_references(&handle_, 0);
  }
  OnC& on() { return on_; }

  /// Calls everything but `without`.
  void call_all(const std::string& where, Faults& faults, std::string_view without = "") {
    for (const CCall& call : kCCalls) {
      if (call.name == without) continue;
      const auto began = Clock::now();
      handle_.error.clear();
      call.run(on_);
      if (Clock::now() - began > kMost) faults.add(where + ": " + call.name + " took too long");
      if (is_false(handle_.error)) faults.add(where + ": " + call.name + " says: " + handle_.error);
    }
  }

 private:
  std::function<void()> run_;
  cansync_client handle_;
  std::unique_ptr<cansync_job, decltype(&cansync_job_free)> job_{nullptr, &cansync_job_free};
  OnC on_{handle_, nullptr, &run_};
};

class EveryCall : public ::testing::Test {
 protected:
  Options options() const {
    Options options = options_for(places.there);
    options.grace = milliseconds(600);
    return options;
  }
  /// From two threads for each face at once, while `daemon_does()` runs beside them.
  template <class DaemonDoes>
  void call_all_while(const std::string& situation, DaemonDoes&& daemon_does) {
    Client client = Client::connect(options());
    std::array<std::optional<Objects>, 2> objects;
    for (auto& one : objects) one.emplace(client);
    std::array<std::optional<CObjects>, 2> c_objects;
    for (auto& one : c_objects) one.emplace(options());
    std::vector<std::future<void>> calls;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      calls.push_back(std::async(std::launch::async, [&, i] { objects[i]->call_all(situation, faults); }));
      calls.push_back(std::async(std::launch::async, [&, i] { c_objects[i]->call_all(situation, faults); }));
    }
    daemon_does();
    for (auto& call : calls) call.get();
    EXPECT_EQ(faults.text(), "");
  }

  TwoPlaces places;
  std::optional<FakeDaemon> daemon{std::in_place, places.here};
  Faults faults;
};

TEST_F(EveryCall, WithADaemonThatAnswers) {
  daemon->publish_rest();
  call_all_while("answers", [] {});
}

TEST_F(EveryCall, WithADaemonThatIsSilent) {
  daemon->publish_rest();
  daemon->answer_nothing();
  call_all_while("silent", [] {});
}

TEST_F(EveryCall, WithADaemonThatTellsWithoutAnEnd) {
  std::atomic<bool> stop = false;
  std::thread flood([&] {
    while (!stop) {
      daemon->publish_rest();
      std::this_thread::sleep_for(milliseconds(1));
    }
  });
  call_all_while("floods", [] {});
  stop = true;
  flood.join();
}

TEST_F(EveryCall, WithADaemonThatGoesAndComesBack) {
  daemon->publish_rest();
  call_all_while("goes and comes back", [&] {
    for (int i = 0; i < 3; ++i) {
      std::this_thread::sleep_for(milliseconds(150));
      daemon.reset();
      std::this_thread::sleep_for(milliseconds(150));
      daemon.emplace(places.here);
      daemon->publish_rest();
    }
  });
}

TEST_F(EveryCall, WithADaemonThatIsGone) {
  daemon->publish_rest();
  Client client = Client::connect(options());
  Objects objects(client);
  CObjects c_objects(options());
  daemon.reset();
  objects.call_all("gone", faults);
  c_objects.call_all("gone", faults);
  EXPECT_EQ(faults.text(), "");
}

/// All calls from a callback, and meanwhile from another thread.
void call_all_from(const Callback& callback, const Options& options, Faults& faults) {
  Client client = Client::connect(options);
  Objects in_callback(client);
  Objects beside(client);
  std::atomic<bool> begun = false;
  std::promise<void> done;
  std::future<void> other;
  const auto run = [&] {
    if (begun.exchange(true)) return;
    other = std::async(std::launch::async,
                       [&] { beside.call_all(std::string("beside ") + callback.name, faults); });
    in_callback.call_all(std::string("in ") + callback.name, faults);
    done.set_value();
  };
  try {
    // A job may end before it has told of any progress: then with another one.
    std::vector<std::unique_ptr<Objects>> own;
    std::vector<std::shared_ptr<void>> keeps;
    const auto end = Clock::now() + gateway::kLongWait;
    for (auto is_done = done.get_future();
         is_done.wait_for(std::chrono::seconds(1)) != std::future_status::ready;) {
      if (Clock::now() > end)
        return faults.add(std::string(callback.name) + " was never called, or does not end");
      if (begun || (!keeps.empty() && keeps.back() != nullptr)) continue;
      own.push_back(std::make_unique<Objects>(client));
      keeps.push_back(callback.run(own.back()->on(), run));
    }
    other.get();
  } catch (const NoDaemon& error) {
    faults.add(std::string(callback.name) + ": " + error.what());
  }
}

TEST_F(EveryCall, FromEachCallbackAndBesideIt) {
  daemon->publish_rest();
  std::vector<std::future<void>> all;
  std::vector<std::future<void>> of_restarts;
  for (const Callback& callback : kCallbacks) {
    const bool restart = std::string_view(callback.name).starts_with("Client::on_restart");
    (restart ? of_restarts : all).push_back(std::async(std::launch::async, [&] {
      call_all_from(callback, options(), faults);
    }));
  }
  // Some of them need something new to be told.
  const auto await = [&](std::vector<std::future<void>>& calls) {
    for (auto& one : calls) {
      while (one.wait_for(milliseconds(200)) != std::future_status::ready) {
        daemon->tell();
        daemon->publish_rest();
      }
      one.get();
    }
  };
  await(all);
  daemon.emplace(places.here);
  await(of_restarts);
  EXPECT_EQ(faults.text(), "");
}

/// All calls of the C face while a callback of the same handle does not return.
void call_all_beside(const CSubscription& subscription, const Options& options, Faults& faults) {
  std::promise<void> called;
  std::promise<void> returns;
  std::atomic<bool> begun = false;
  CObjects objects(options, [&, may_return = returns.get_future().share()] {
    if (begun.exchange(true)) return;
    called.set_value();
    (void)may_return.wait_for(gateway::kLongWait);
  });
  const auto keeps = subscription.run(objects.on());
  if (called.get_future().wait_for(gateway::kLongWait) != std::future_status::ready)
    return faults.add(std::string(subscription.name) + ": its callback was never called");
  // Where a handle has one callback, another one in its place waits for it.
  objects.call_all(std::string("beside a callback of ") + subscription.name, faults,
                   keeps ? "" : subscription.name);
  returns.set_value();
}

TEST_F(EveryCall, OfTheCFaceBesideEachCallbackThatDoesNotReturn) {
  std::vector<std::future<void>> all;
  for (const CSubscription& subscription : kCSubscriptions)
    all.push_back(std::async(std::launch::async, [&] { call_all_beside(subscription, options(), faults); }));
  for (auto& one : all) {
    while (one.wait_for(milliseconds(200)) != std::future_status::ready) {
      daemon->tell();
      daemon->publish_rest();
    }
    one.get();
  }
  EXPECT_EQ(faults.text(), "");
}

TEST_F(EveryCall, ACallbackMayEndItsSubscriptionAndItsClient) {
  std::optional<Client> client{Client::connect(options())};
  std::optional<Subscription> ended;
  std::promise<void> first;
  std::promise<void> second;
  {
    std::promise<void> ready;
    auto is_ready = ready.get_future().share();
    ended = client->on_master_status([&, is_ready](const MasterStatus&) {
      is_ready.wait();
      ended.reset();
      first.set_value();
    });
    ready.set_value();
  }
  ASSERT_EQ(first.get_future().wait_for(gateway::kLongWait), std::future_status::ready);
  const ParameterJob job = client->submit(ParameterRequest{.slave = 1, .number = 7});
  job.then([&](const ParameterReply&) {
    client.reset();
    second.set_value();
  });
  ASSERT_EQ(second.get_future().wait_for(gateway::kLongWait), std::future_status::ready);
  EXPECT_FALSE(client);
  const auto end = Clock::now() + gateway::kLongWait;
  while (daemon->programs() != 0 && Clock::now() < end) std::this_thread::sleep_for(milliseconds(5));
  EXPECT_EQ(daemon->programs(), 0u) << "it is closed";
}

}  // namespace
}  // namespace cansync::client
