// A lead axis: gives every drive of a line a position reference value for every interval, each released exactly once, and
// shows at the end how far each follower is behind. IT MOVES EVERY DRIVE of the line that follows, from where they stand:
// for a simulated line. Values are written eight intervals ahead, so that this program may be late now and then. The
// daemon's Interval topic is the clock (dds.interval_topic, process.poll_without_reference); 65536 increments are one turn.
// Usage: lead_axis DOMAIN BUS RPM SECONDS        Exit code: 0 done, 1 failed
#include <cansync/client.h>
#include <cansync/topics.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <semaphore>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace {

using namespace cansync::client;

constexpr std::uint64_t kAhead = 8;

/// From where `position` is to an actual value; positions go round after 2^32 increments.
std::int32_t behind(double position, const ActualValues& values) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(std::llround(position)) - values.raw[0]);
}

/// What a drive tells from now on: what is known may be from before the line ran, and drives can be moved by hand.
ActualValues of_now(const Client& client, std::uint8_t slave) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  const auto known = client.actual_values(slave, std::chrono::seconds(10));
  while (known && std::chrono::steady_clock::now() < end) {
    const auto values = client.actual_values(slave);
    if (values && values->interval[0] != known->interval[0]) return *values;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw std::runtime_error("no actual values: is process.poll_without_reference on, and does the line run?");
}

/// Where the drives stand, at most a turn apart.
double standing(const Client& client) {
  double position = 0;
  bool first = true;
  for (const SlaveStatus& slave : client.slaves()) {
    const ActualValues values = of_now(client, slave.slave);
    if (std::exchange(first, false)) position = static_cast<std::int32_t>(values.raw[0]);
    if (std::abs(behind(position, values)) > 65536)
      throw std::runtime_error("the drives stand apart: none is moved");
  }
  return position;
}

int lead(const Options& options, double rpm, double seconds) {
  Client client = Client::connect(options);
  const Validity meant_for = client.validity();  // as the line is looked at from here on
  double position = standing(client);
  const double interval = static_cast<double>(client.master_status().interval_length) * 1e-9;
  ReferenceWriter writer(client, 10);
  writer.take_up(meant_for);

  std::counting_semaphore<> begun(0);
  std::atomic<std::uint64_t> number{0};
  const Subscription subscription = client.on_interval([&](const Interval& now) {
    number = now.number;
    begun.release();
  });

  const double full_step = rpm / 60 * 65536 * interval;
  const auto steps = static_cast<std::uint64_t>(seconds / interval);
  std::uint64_t next = 0;  // the interval that gets a value next
  for (std::uint64_t done = 0; done < steps;) {
    if (!begun.try_acquire_for(std::chrono::seconds(20)))
      throw std::runtime_error("no interval for 20 s: is dds.interval_topic on, and does the line run?");
    const std::uint64_t now = number;
    if (next > now + kAhead + 1)
      throw std::runtime_error("the intervals begin anew: the daemon was started again");
    for (next = std::max(next, now + 1); next <= now + kAhead; ++next, ++done) {
      // Two seconds to full speed.
      position += full_step * std::min(static_cast<double>(done) * interval / 2, 1.0);
      const auto raw = static_cast<std::int32_t>(static_cast<std::uint32_t>(std::llround(position)));
      if (const std::string failed = writer.write(1, {raw, 0, 0, 0}, 0b0001, 1, next); !failed.empty())
        throw std::runtime_error(failed);
    }
  }
  for (const SlaveStatus& slave : client.slaves()) {
    if (const auto values = client.actual_values(slave.slave))
      std::printf("slave %d: %d increments behind\n", slave.slave, behind(position, *values));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return std::fprintf(stderr, "usage: %s DOMAIN BUS RPM SECONDS\n", argv[0]), 1;
  try {
    Options options;
    options.domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
    options.bus = argv[2];
    options.client_name = "lead axis";
    // As for the command cansync. NOLINTNEXTLINE(concurrency-mt-unsafe): nobody changes the environment
    const char* types = std::getenv("CANSYNC_TYPES");
    options.final_types = types != nullptr && std::string(types) == "final";
    return lead(options, std::atof(argv[3]), std::atof(argv[4]));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
