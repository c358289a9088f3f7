// Every function of the C face of a slave's application ends within the time that its header names, whatever its daemon does. The calls
// are made from the header (every_call.py).
#include <cansync/cansync_c_slave.h>

#include <array>
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "slave_rig.h"

namespace cansync::client::function_blocks {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Five times the longest that is documented: a computer that stands still for a moment is no fault, a wait without an end is.
constexpr std::chrono::seconds kMost(15);

/// What the calls are made on: a handle is for one thread at a time.
struct OnApplication {
  cansync_application* application;
};
struct ApplicationCall {
  const char* name;
  void (*run)(OnApplication& on);
};

/// Where the C face puts what it gives.
template <class T>
T* room() {
  thread_local T value = {};
  return &value;
}

#include "every_application_call.inc"

class EveryApplicationCall : public ::testing::Test {
 protected:
  using Handle = std::unique_ptr<cansync_application, void (*)(cansync_application*)>;

  Handle connected() {
    Handle handle{cansync_application_new(), &cansync_application_free};
    cansync_options options = {};
    options.domain = places.here.domain;
    options.bus = places.here.partition.c_str();
    options.wait_ms = 60'000;
    EXPECT_EQ(cansync_application_connect(handle.get(), &options), CANSYNC_DONE)
        << cansync_application_last_error(handle.get());
    return handle;
  }

  /// Calls everything; what was wrong, a line each.
  static std::string faults(cansync_application* application) {
    std::string found;
    OnApplication on{application};
    for (const ApplicationCall& call : kApplicationCalls) {
      const auto began = steady_clock::now();
      call.run(on);
      if (steady_clock::now() - began > kMost) found += std::string(call.name) + " took too long\n";
      // The daemon of these tests has the library's own protocol and data model.
      const std::string_view words = cansync_application_last_error(application);
      if (words.find("data model") != words.npos || words.find("it speaks") != words.npos)
        found += std::string(call.name) + " says: " + std::string(words) + "\n";
    }
    return found;
  }

  /// From two threads, while `daemon_does()` runs again and again.
  template <class DaemonDoes>
  void call_all_while(DaemonDoes&& daemon_does) {
    const std::array<Handle, 2> handles{connected(), connected()};
    std::vector<std::future<std::string>> calls;
    for (const Handle& handle : handles)
      calls.push_back(std::async(std::launch::async, &EveryApplicationCall::faults, handle.get()));
    for (auto& call : calls) {
      while (call.wait_for(milliseconds(1)) != std::future_status::ready) daemon_does();
      EXPECT_EQ(call.get(), "");
    }
  }

  TwoPlaces places;
  std::optional<FakeSlaveDaemon> daemon{std::in_place, places.here};
};

TEST_F(EveryApplicationCall, WithADaemonThatAnswers) {
  // What is released before DDS has found the daemon's reader reaches nobody.
  const auto end = steady_clock::now() + gateway::kLongWait;
  do call_all_while([&] { daemon->take(); });
  while (daemon->releases.empty() && steady_clock::now() < end);
  EXPECT_FALSE(daemon->commands.empty());
  EXPECT_FALSE(daemon->releases.empty());
}

TEST_F(EveryApplicationCall, WithADaemonThatIsSilent) {
  call_all_while([] {});
}

TEST_F(EveryApplicationCall, WithADaemonThatTellsWithoutAnEnd) {
  std::uint64_t interval = 0;
  call_all_while([&] {
    daemon->references(1, 0, ++interval);
    daemon->monitored(7, 1, 0, interval);
    daemon->tell();
    daemon->take();
  });
}

TEST_F(EveryApplicationCall, WithADaemonThatGoesAndComesBack) {
  call_all_while([&] {
    daemon.reset();
    std::this_thread::sleep_for(milliseconds(150));
    daemon.emplace(places.here);
    std::this_thread::sleep_for(milliseconds(150));
  });
}

TEST_F(EveryApplicationCall, WithADaemonThatIsGone) {
  const Handle handle = connected();
  daemon.reset();
  EXPECT_EQ(faults(handle.get()), "");
}

}  // namespace
}  // namespace cansync::client::function_blocks
