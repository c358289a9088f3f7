#pragma once

/// Ctrl-C and SIGTERM. The first one asks the running verb to end in order (a job is cancelled on the bus);
/// the second one ends the program at once.
namespace cansync::cli {

/// Takes over SIGINT and SIGTERM for the rest of the program's life.
void install_interrupt_handlers();

/// True once one of the two signals came.
bool interrupted() noexcept;

}  // namespace cansync::cli
