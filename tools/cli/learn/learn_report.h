#pragma once

#include "cansync/observe/learned.h"
#include "cli/base/output.h"

namespace cansync::cli {

/// What the report says beside the points.
struct ReportOptions {
  bool all_steps = false;  ///< every step of the master, not the first ones alone
};

/// Writes what was on the line and what was learned of it: tables, or with --json one object for each point,
/// slot, slave, telegram and step.
void write_learn_report(Output& output, const observe::Observation& observation,
                        const observe::Learned& learned, const ReportOptions& options);

/// Of a recording that does not look like CANsync: its protocol, its time stamps, and how many frames it has.
void write_other_protocol(Output& output, const observe::Observation& observation,
                          const observe::Learned& learned);

/// A step of the master in words: "write slave 3 parameter 400 = 20, done".
std::string step_text(const observe::Step& step);

/// The columns of the tables beside that of the points, as parts of the help.
std::string report_tables_help();

}  // namespace cansync::cli
