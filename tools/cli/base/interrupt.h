#pragma once

#include <atomic>
#include <chrono>

/// Ctrl-C and SIGTERM: the first one asks the running verb to end in order (a job is cancelled on the bus);
/// the second one ends the program at once. SIGCONT: what the program believed of the daemon is old.
namespace cansync::cli {

/// Takes over SIGINT, SIGTERM and SIGCONT for the rest of the program's life.
void install_interrupt_handlers();

/// True once one of the two signals came.
const std::atomic<bool>& interrupt_flag() noexcept;

/// True for 10 s after the program was continued (SIGCONT, as from Ctrl-Z and `fg`): while it stood still the lease
/// of the daemon may have ended, and DDS needs up to its announcement, some 4 s, to find it again. Any thread.
bool just_continued() noexcept;

/// Waits until `instant`, or until a signal came (noticed within 20 ms). True when a signal came.
bool wait_until(std::chrono::steady_clock::time_point instant);

}  // namespace cansync::cli
