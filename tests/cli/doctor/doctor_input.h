#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <string_view>
#include <vector>

#include "cli/doctor/doctor_facts.h"
#include "cli/doctor/doctor_findings.h"

/// What the doctor looks at, and what it found of that.
namespace cansync::cli {

template <std::size_t N>
void put(char (&out)[N], const char* text) {
  std::snprintf(out, N, "%s", text);
}

/// An interface that is up, of drivers of this kind.
inline can::LinkFacts can_link(std::string_view kind) {
  can::LinkFacts link;
  link.present = link.is_can = link.up = true;
  link.index = 3;
  link.queue_length = 10;
  std::copy(kind.begin(), kind.end(), link.driver_kind.begin());
  return link;
}

/// Everything well: a real bus with all rights.
inline DoctorInput healthy() {
  DoctorInput in;
  in.bus = in.unit = "can0";
  in.cli_version = "1.2.3";
  in.data_model = 4;
  in.participants = 2;
  in.machine = {"6.1.0-rt", "PREEMPT_RT", "2-3", {{"C6", 133}}};
  in.host = {true, {}, true, "", {{"performance", 4}}, true, "30s", {77}};
  in.interface_name = "can0";
  in.link = can_link("can");
  in.link.timing = can::LinkTiming{500'000, 600};
  in.link.state = can::ControllerState::error_active;
  in.link.restart_ms = 100;
  in.link.one_shot = true;
  in.link.echoes = true;
  in.link.has_counters = true;
  DaemonStatus status = {{}, {}, {}, client::MasterStatus{}};
  put(status.gateway.bus, "can0");
  status.reset_command = "cansync mode reset-can";
  status.gateway.process = 77;
  put(status.master->state, "active");
  status.master->option_status = 0x0080;
  status.master->slaves_configured = status.master->slaves_released = 1;
  status.master->interval = 5000;
  status.master->interval_length = 2'000'000;  // ns
  for (auto& release : status.master->reference_release) {
    put(release.state, "released");
    put(release.writer, "'plc' (plc, process 12 on host cab)");
  }
  put(status.gateway.version, "1.2.3");
  put(status.bus.controller_state, "error-active");
  put(status.bus.bus_interface, "can0");
  put(status.gateway.dds_interface, "lo");
  put(status.bus.link_state, "up");
  put(status.bus.timestamp_source, "hardware");
  put(status.realtime.sync_output, "gpio");
  put(status.realtime.sync_input, "pps");
  put(status.realtime.sync_state, "locked");
  client::SlaveStatus slave{};
  put(slave.name, "winder");
  put(slave.state, "released");
  slave.responds = slave.status_known = slave.synchronized = true;
  slave.last_seen = 4990;
  status.slaves = {slave};
  status.gateway.data_model = 4;
  status.bus.bit_rate = 500'000;
  status.bus.sample_point_wanted = 600;
  status.realtime.realtime_priority = status.realtime.realtime_priority_wanted = 60;
  status.realtime.realtime_cpu = status.realtime.realtime_cpu_wanted = 2;
  status.realtime.memory_locked = status.realtime.memory_lock_wanted = status.realtime.cpu_held_awake = true;
  in.status = status;
  return in;
}

/// The interface is in a network namespace with the daemon, which says that it is up.
inline DoctorInput apart() {
  DoctorInput in = healthy();
  in.link = {};
  return in;
}

inline client::SlaveStatus& first_slave(DoctorInput& in) {
  return in.status->slaves.front();
}

/// What is found of `topic`; nothing when it is not looked at.
inline const Finding* find(const std::vector<Finding>& findings, std::string_view topic) {
  const auto found =
      std::find_if(findings.begin(), findings.end(), [topic](const Finding& f) { return f.topic == topic; });
  return found == findings.end() ? nullptr : &*found;
}

}  // namespace cansync::cli
