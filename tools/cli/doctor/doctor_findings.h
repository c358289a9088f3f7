#pragma once

#include <cansync/topics.h>
#include <cansync/types.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/adapter/adapters.h"
#include "can/link_facts.h"
#include "cli/base/exit_codes.h"
#include "cli/base/finding_list.h"
#include "cli/doctor/doctor_facts.h"
#include "cli/doctor/doctor_host.h"
#include "dds/loopback_holders.h"

/// What is well and what is not with a bus, its daemon and this computer. Pure functions.
namespace cansync::cli {

/// "ok", "warning", "error".
std::string_view name(Level level) noexcept;

/// What the daemon tells.
struct DaemonStatus {
  client::GatewayStatus gateway;
  client::BusStatus bus;
  client::RealtimeStatus realtime;
  std::optional<client::MasterStatus> master;    ///< of a line of CANsync alone
  std::vector<client::SlaveStatus> slaves = {};  ///< likewise
  std::map<unsigned, std::string> faults = {};   ///< what profiles call the faults of slaves, by number
  bool has_sync = true;                          ///< its bus has SYNC edges
  std::string_view reset_command = {};           ///< resets its CAN controller; empty: its protocol has none
};

/// Everything the findings are made of.
struct DoctorInput {
  std::string bus;   ///< the bus that is looked for
  std::string unit;  ///< instance of cansyncd@.service that serves it
  std::string cli_version;
  std::uint32_t data_model = 0;        ///< of this program
  std::optional<DaemonStatus> status;  ///< nothing: no daemon was found
  std::string no_daemon;               ///< why not
  std::string several_daemons;         ///< who they are, when more than one serves the bus; empty: not so
  std::uint32_t participants = 0;      ///< other DDS participants in the domain
  gateway::dds::PlacesTaken places;    ///< of the domain on this computer
  std::uint32_t incompatible = 0;      ///< programs that do not match the daemon
  std::string newest_incompatible;     ///< the event that told of the newest; empty: none is known
  std::string newest_missed;           ///< when SYNC edges were missed last; empty: not known
  std::string reload_refused;  ///< why the newest reading of the configuration was refused; empty: it was not
  std::string host_name;       ///< of this computer
  MachineFacts machine;
  HostFacts host;
  std::string interface_name;                   ///< the bus's CAN interface; "sim" for a simulated line
  can::LinkFacts link;                          ///< what the kernel of this computer knows of it
  std::vector<can::InterfaceAdapter> adapters;  ///< every CAN adapter of this computer
  std::string kernel_silent;  ///< why it could not be asked; empty: it was, or there was nothing to ask
  std::vector<Finding> of_protocol;  ///< what the bus's protocol has found itself
};

/// The findings with `options` in the commands of their remedies, so that they reach the bus that was looked at:
/// "cansync --bus can1 mode run". `options`: such as "--bus can1"; empty: as they are.
std::vector<Finding> with_options(std::vector<Finding> findings, std::string_view options);

/// Findings in a fixed order. Without a daemon those that need it are missing, and one says so.
std::vector<Finding> diagnose(const DoctorInput& input);

/// The same findings, with those that slaves have alike as one: "32 slaves (0-31): OVERTEMPERATURE".
std::vector<Finding> grouped(const std::vector<Finding>& findings);

/// What is to be fixed first: the first error with a remedy, for what comes later may follow from it; the operating state, which
/// waits for slaves, after theirs; without an error the first warning. Null: nothing. As long as `findings` lives.
const Finding* first_to_fix(const std::vector<Finding>& findings);

/// What is not ok in one line, the worse first, each topic once: "1 error: drive fault; 2 warnings: missed,
/// kernel". What scrolled away on a small terminal is named here.
std::string summary(const std::vector<Finding>& findings);

/// Exit code for these findings: not_reachable without a daemon, else faults for an error, failed (1) for a
/// warning.
ExitCode exit_code(const std::vector<Finding>& findings, bool daemon_found) noexcept;

}  // namespace cansync::cli
