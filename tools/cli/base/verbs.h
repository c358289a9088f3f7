#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "cli/base/session.h"

/// Every function adds its verbs to the program; a verb that was named on the command line puts what is to be
/// done into `chosen`, which is called once after parsing.
namespace cansync::cli {

/// The help of an argument SLAVE that may be a list.
inline constexpr const char* kSlavesHelp =
    "number 0..31 or name, a list with ranges (1,3,5-9,winder), or all = every configured slave";

using Verb = std::function<ExitCode(Session&)>;

void add_status_verbs(CLI::App& app, Verb& chosen);     ///< status, slaves
void add_timing_verb(CLI::App& app, Verb& chosen);      ///< timing
void add_doctor_verb(CLI::App& app, Verb& chosen);      ///< doctor
void add_trace_verb(CLI::App& app, Verb& chosen);       ///< trace
void add_watch_verb(CLI::App& app, Verb& chosen);       ///< watch
void add_record_verb(CLI::App& app, Verb& chosen);      ///< record
void add_plot_verb(CLI::App& app, Verb& chosen);        ///< plot
void add_event_verb(CLI::App& app, Verb& chosen);       ///< events
void add_parameter_verbs(CLI::App& app, Verb& chosen);  ///< read, write
void add_params_verb(CLI::App& app, Verb& chosen);      ///< params
void add_passport_verbs(CLI::App& app, Verb& chosen);   ///< backup, diff, verify
void add_restore_verb(CLI::App& app, Verb& chosen);     ///< restore
void add_transfer_verbs(CLI::App& app, Verb& chosen);   ///< upload, download
void add_command_verbs(CLI::App& app, Verb& chosen);    ///< control, broadcast, mode
void add_reference_verb(CLI::App& app, Verb& chosen);   ///< set
void add_polling_verb(CLI::App& app, Verb& chosen);     ///< poll
void add_mapping_verb(CLI::App& app, Verb& chosen);     ///< map

void add_wait_verb(CLI::App& app, Verb& chosen);   ///< wait
void add_batch_verb(CLI::App& app, Verb& chosen);  ///< batch

}  // namespace cansync::cli
