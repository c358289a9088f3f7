// A consumer in the manner of a ROS node, without ROS: callbacks put messages into a queue of fixed depth,
// and spin_once() runs the node's own callbacks on the main thread. Prints the joints' positions ten times a
// second. Usage: ros_style_consumer DOMAIN BUS MESSAGES        Exit code: 0 done, 1 failed
#include <cansync/client.h>
#include <cansync/topics.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>

namespace {

using namespace cansync::client;
using Clock = std::chrono::steady_clock;

class Node {
 public:
  /// The oldest message goes when the queue is full.
  explicit Node(Client& client, std::size_t depth = 100)
      : depth_(depth),
        subscription_(client.on_actual_values([this](const ActualValues& sample) { queue(sample); })) {}

  /// Runs `callback` for every message that waits; waits at most `time` for the first.
  void spin_once(std::chrono::milliseconds time, const std::function<void(const ActualValues&)>& callback) {
    std::unique_lock lock(mutex_);
    come_.wait_for(lock, time, [&] { return !waiting_.empty(); });
    std::deque<ActualValues> taken;
    taken.swap(waiting_);
    lock.unlock();
    for (const ActualValues& sample : taken) callback(sample);
  }

 private:
  void queue(const ActualValues& sample) {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() == depth_) waiting_.pop_front();
    waiting_.push_back(sample);
    come_.notify_one();
  }

  std::mutex mutex_;
  std::condition_variable come_;
  std::size_t depth_;
  std::deque<ActualValues> waiting_;
  Subscription subscription_;  // last: its callbacks need everything above
};

int consume(Client& client, long messages) {
  Node node(client);
  std::array<double, cansync_SLAVES> position = {};
  const std::size_t joints = client.slaves().size();
  for (auto next = Clock::now() + std::chrono::milliseconds(100); messages > 0;) {
    node.spin_once(std::chrono::milliseconds(10), [&](const ActualValues& sample) {
      position[sample.slave % cansync_SLAVES] = sample.scaled[0];
    });
    if (Clock::now() < next) continue;
    next = Clock::now() + std::chrono::milliseconds(100);
    --messages;
    std::printf("joint_states:");
    for (std::size_t joint = 0; joint < joints; ++joint) std::printf(" %.3f", position[joint]);
    std::printf("\n");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: %s DOMAIN BUS MESSAGES\n", argv[0]), 1;
  Client client = Client::connect({.domain = static_cast<std::uint32_t>(std::atoi(argv[1])), .bus = argv[2]});
  return consume(client, std::atol(argv[3]));
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
