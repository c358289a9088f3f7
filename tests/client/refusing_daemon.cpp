#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include "client/fake_daemon.h"

/// A daemon without a bus as a program of its own: it refuses a read of parameter 3400 + n with cause n, so
/// that every cause can be seen from outside, also those that no program can bring about. Prints "serving",
/// and ends when its standard input does. Usage: refusing_daemon DOMAIN BUS
int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: %s DOMAIN BUS\n", argv[0]), EXIT_FAILURE;
  try {
    gateway::dds::ParticipantOptions options;
    options.domain = static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10));
    options.partition = argv[2];
    options.serves = true;
    FakeDaemon daemon(options);
    // Clients take a daemon for dead that has not told its state for some seconds.
    std::jthread telling([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        daemon.tell();
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
      }
    });
    std::puts("serving");
    std::fflush(stdout);
    while (std::getchar() != EOF) {
    }
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
