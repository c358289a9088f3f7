#include "cansync/interrupt.h"

#include <csignal>

namespace cansync::cli {
namespace {

volatile std::sig_atomic_t pending = 0;

void on_signal(int) {
  pending = 1;
}

}  // namespace

void install_interrupt_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  // The default comes back after the first signal, so a second one ends the program. System calls return.
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() noexcept {
  return pending != 0;
}

}  // namespace cansync::cli
