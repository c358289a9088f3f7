#pragma once

#include <cansync/client.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

/// What programs of function blocks have in common: a cycle of 1 ms until all has happened, and their
/// arguments DOMAIN BUS SECONDS.
namespace cansync::client::function_blocks {

/// Calls `programme.cycle()` until it is complete; 1 when it is not at `end`, and says what went wrong.
template <class Programme>
int run_cycles(Programme& programme, std::chrono::steady_clock::time_point end) {
  while (!programme.complete()) {
    if (std::chrono::steady_clock::now() > end)
      return std::fprintf(stderr, "not all: %s\n", programme.errors().c_str()), 1;
    programme.cycle();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return 0;
}

/// The exit status of `run(options, end)`.
template <class Run>
int run_program(int argc, char** argv, const char* name, Run&& run) {
  if (argc != 4) return 2;
  try {
    Options options;
    options.domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
    options.bus = argv[2];
    options.client_name = name;
    return run(options, std::chrono::steady_clock::now() + std::chrono::seconds(std::atoi(argv[3])));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}

}  // namespace cansync::client::function_blocks
