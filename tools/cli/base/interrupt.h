#pragma once

#include <atomic>
#include <chrono>

/// Ctrl-C and SIGTERM. The first one asks the running verb to end in order (a job is cancelled on the bus);
/// the second one ends the program at once.
namespace cansync::cli {

/// Takes over SIGINT and SIGTERM for the rest of the program's life.
void install_interrupt_handlers();

/// True once one of the two signals came.
const std::atomic<bool>& interrupt_flag() noexcept;

/// Waits until `instant`, or until a signal came (noticed within 20 ms). True when a signal came.
bool wait_until(std::chrono::steady_clock::time_point instant);

}  // namespace cansync::cli
