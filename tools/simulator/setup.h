#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cansync/sim/drive.h"
#include "cansync/sim/master_node.h"
#include "sim/scripted_device.h"
#include "simulator/arguments.h"
#include "simulator/bench.h"

namespace cansync_sim {

/// What the program runs with, or all that is wrong with its arguments.
struct Setup {
  std::string interface;
  BenchSettings bench;
  std::vector<sim::DriveSettings> drives;         ///< none with `master`
  std::optional<sim::MasterNodeSettings> master;  ///< a master instead of drives
  std::optional<sim::DeviceSettings> device;      ///< the device of a script instead of drives
  std::vector<std::string> problems;              ///< one line each: what was found, where, what is allowed
  std::vector<std::string> left_out;              ///< likewise, of scripts that can be used in part
};

/// Slave numbers written as "3", "0-31" or "0,3,5-7"; nothing when the text is no such list.
std::optional<cansync::SlaveMask> parse_slaves(const std::string& text);

/// True when a CANsync channel uses this standard identifier (section 1 of the protocol: 0x010, 0x100..0x1FF,
/// 0x300..0x3FF, 0x500..0x5FF).
bool is_cansync_identifier(std::uint32_t identifier) noexcept;

/// Reads the files the arguments name and checks everything.
Setup make_setup(const Arguments& arguments);

}  // namespace cansync_sim
