#pragma once

#include <string>

#include "cli/base/output.h"
#include "cli/scan/inquiry.h"

namespace cansync::cli {

/// The slaves that answered, and the parameters that were read.
void write_found_slaves(Output& output, const InquiryResult& result);

/// What the tables have, for the verb's help.
std::string found_tables_help();

}  // namespace cansync::cli
