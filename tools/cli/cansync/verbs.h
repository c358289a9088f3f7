#pragma once

#include "cli/base/protocol_verbs.h"

namespace cansync::cli {

/// The help of an argument SLAVE that may be a list.
inline constexpr const char* kSlavesHelp =
    "number 0..31 or name, a list with ranges (1,3,5-9,winder), or all = every configured slave";

/// All verbs of CANsync: those below.
extern const ProtocolVerbs cansync_verbs;

void add_slaves_verb(CLI::App& app, Verb& chosen);      ///< slaves
void add_timing_verb(CLI::App& app, Verb& chosen);      ///< timing
void add_parameter_verbs(CLI::App& app, Verb& chosen);  ///< read, write
void add_params_verb(CLI::App& app, Verb& chosen);      ///< params
void add_passport_verbs(CLI::App& app, Verb& chosen);   ///< backup, diff, verify
void add_restore_verb(CLI::App& app, Verb& chosen);     ///< restore
void add_transfer_verbs(CLI::App& app, Verb& chosen);   ///< upload, download
void add_command_verbs(CLI::App& app, Verb& chosen);    ///< control, broadcast, mode, release
void add_reference_verb(CLI::App& app, Verb& chosen);   ///< set
void add_polling_verb(CLI::App& app, Verb& chosen);     ///< poll
void add_mapping_verb(CLI::App& app, Verb& chosen);     ///< map

}  // namespace cansync::cli
