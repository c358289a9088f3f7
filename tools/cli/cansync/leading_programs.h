#pragma once

#include <cansync/topics.h>

#include <string>

namespace cansync::cli {

/// The programs that lead drives, with their telegrams and the slaves that follow: "'plc' (plc, process 12 on host cab) gives
/// the reference values of telegrams 1 and 2; slaves 0-3 report a fault without them". Empty: no program does, or the master is
/// in stop, where nothing is sent. Thread-safe.
std::string leading_programs(const client::MasterStatus& status);

/// The writers alone: "'plc' (plc, process 12 on host cab) gives the reference values of telegrams 1 and 2"; empty likewise.
/// Thread-safe.
std::string leading_writers(const client::MasterStatus& status);

}  // namespace cansync::cli
