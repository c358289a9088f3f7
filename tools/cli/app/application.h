#pragma once

#include <cstdio>

#include "cli/base/exit_codes.h"

namespace cansync::cli {

/// The whole program: reads the arguments, runs the verb, writes data and remarks to these files. Never
/// throws.
ExitCode run(int argc, const char* const* argv, std::FILE* data, std::FILE* remarks);

}  // namespace cansync::cli
