#pragma once

#include <cansync/topics.h>
#include <cansync/types.h>

#include <string>
#include <vector>

/// What `status` writes for people. Pure functions.
namespace cansync::cli {

/// The lines, each a label and what it tells; those that do not apply are left out.
std::vector<std::string> status_lines(const client::MasterStatus& status);

/// Every label with its explanation, for the help.
std::string status_lines_help();

}  // namespace cansync::cli
