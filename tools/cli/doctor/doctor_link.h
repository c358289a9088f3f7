#pragma once

#include <string_view>

#include "cli/base/finding_list.h"
#include "cli/doctor/doctor_findings.h"

/// What `doctor` says of the CAN interface and the controller behind it. Pure functions.
namespace cansync::cli {

/// Name of the interface of a simulated line.
inline constexpr std::string_view kSimulated = "sim";

/// The daemon is on another computer, and the interface with it.
bool is_elsewhere(const DoctorInput& in);
/// The daemon has the interface, and this program does not see it: it is in a network namespace.
bool is_apart(const DoctorInput& in);

/// Is it there and up, and set as the bus needs it: bit rate, sample point, restart-ms, one-shot, echo,
/// txqueuelen? A simulated line and a virtual interface have nothing to set.
void look_at_link(const DoctorInput& in, FindingList& out);

/// State and error counters of the controller: as the daemon tells them, else as the kernel does.
void look_at_controller(const DoctorInput& in, FindingList& out);

}  // namespace cansync::cli
