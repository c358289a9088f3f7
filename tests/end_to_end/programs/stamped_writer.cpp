// Gives reference values that tell when they were written: value 0 is the time of CLOCK_MONOTONIC in
// milliseconds. Tells on standard output, a line for each, the value and when it had surely been written. For
// suspension_test.py, which compares that with the time at which the telegram was on the bus.
//   stamped_writer DOMAIN BUS PERIOD_MS RELEASE_INTERVALS [NAME [INTERFACE]]
#include <cansync/client.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>

namespace {

std::int64_t milliseconds_now() {
  using std::chrono::milliseconds;
  return std::chrono::floor<milliseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

int main(int count, char** arguments) {
  using std::chrono::milliseconds;
  using std::chrono::steady_clock;
  namespace client = cansync::client;
  if (count < 5 || count > 7) {
    std::fprintf(stderr, "usage: %s DOMAIN BUS PERIOD_MS RELEASE_INTERVALS [NAME [INTERFACE]]\n",
                 arguments[0]);
    return EXIT_FAILURE;
  }
  const milliseconds period(std::strtol(arguments[3], nullptr, 10));
  const auto release = static_cast<std::uint32_t>(std::strtoul(arguments[4], nullptr, 10));
  try {
    client::Options options;
    options.domain = static_cast<std::uint32_t>(std::strtoul(arguments[1], nullptr, 10));
    options.bus = arguments[2];
    options.client_name = count >= 6 ? arguments[5] : "stamped writer";
    if (count >= 7) options.interface = arguments[6];
    options.wait = std::chrono::minutes(2);
    client::Client link = client::Client::connect(options);
    client::ReferenceWriter writer(link);
    for (auto next = steady_clock::now();; next += period) {
      std::this_thread::sleep_until(next);
      const std::int64_t now = milliseconds_now();
      const std::array<std::int32_t, 4> value = {static_cast<std::int32_t>(now & 0x7FFF'FFFF)};
      const std::string failed = writer.write(1, value, 1, release);
      if (!failed.empty()) std::fprintf(stderr, "not written: %s\n", failed.c_str());
      std::printf("%d %lld\n", value[0], static_cast<long long>(milliseconds_now()));
      std::fflush(stdout);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
