#include "cli/cansync/wait_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cansync/settings/mode.h"
#include "cli/cansync/status_lines.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "cli/text/words.h"

namespace cansync::cli {
namespace {

using Of = WaitState::Of;

constexpr std::array<WaitState, 18> kStates = {{
    {"present", Of::daemon, "the daemon: it is there"},
    {"gone", Of::nobody, "the daemon: it is not there, or goes"},
    {"setup", Of::master, "the master: w_OPTION_STATUS 0x0043"},
    {"run", Of::master, "the master: w_OPTION_STATUS 0x0080"},
    {"stop", Of::master, "the master: no SYNC, 0x0001 to 0x0003"},
    {"error-active", Of::controller, "the CAN controller, as `status` shows it: no or few errors"},
    {"error-warning", Of::controller, "the CAN controller: many errors"},
    {"error-passive", Of::controller, "the CAN controller: too many errors"},
    {"bus-off", Of::controller, "the CAN controller: takes no part in the bus"},
    {"responding", Of::slaves,
     "slaves, as all below in setup or run only: they answer, RESPONDS in `slaves`"},
    {"synchronized", Of::slaves, "slaves: they have locked to SYNC, SYNCHRONIZED in `slaves`"},
    {"absent", Of::slaves, "slaves, here and below STATE in `slaves`: never answered"},
    {"starting", Of::slaves, "slaves: answer for the first time"},
    {"released", Of::slaves, "slaves: may be used with reference values"},
    {"lost", Of::slaves, "slaves: stopped answering"},
    {"returning", Of::slaves, "slaves: answer again and wait for SYNC"},
    {"checking", Of::slaves, "slaves: their return parameters are checked"},
    {"held", Of::slaves,
     "slaves: not the drive expected, two drives, or their return parameters are not right"},
}};

bool master_is_in(std::string_view name, std::uint32_t status) {
  const auto is = [status](State state) { return status == static_cast<std::uint32_t>(state); };
  if (name == "setup") return is(State::setting_up_master);
  if (name == "run") return is(State::active_master);
  return is(State::start_up) || is(State::waiting_for_initialisation) || is(State::waiting_for_start);
}

bool slave_is_in(std::string_view name, const client::SlaveStatus& slave) {
  if (name == "responding") return slave.responds;
  if (name == "synchronized") return slave.synchronized;
  return name == client::text(slave.state);
}

std::string slaves_seen(const WaitState& state, const WaitLook& now) {
  if (!asks_slaves(now.master))
    return fmt::format("the line is in {}: no slave is asked", client::text(now.master.state));
  std::string text;
  std::uint32_t known = 0;
  for (const client::SlaveStatus& slave : now.slaves) {
    known |= 1u << slave.slave;
    if (((now.wanted >> slave.slave) & 1u) == 0 || slave_is_in(state.name, slave)) continue;
    text += fmt::format("{}slave {} is {}, {}, {}", text.empty() ? "" : "; ", slave.slave,
                        client::text(slave.state), slave.responds ? "responds" : "does not respond",
                        slave.synchronized ? "synchronized" : "not synchronized");
  }
  if ((now.wanted & ~known) != 0)
    text += fmt::format("{}nothing of slaves {}", text.empty() ? "" : "; ",
                        format_slave_set(now.wanted & ~known));
  return text.empty() ? "all of them" : text;
}

}  // namespace

const WaitState& find_wait_state(std::string_view name) {
  const auto* found =
      std::find_if(kStates.begin(), kStates.end(), [&](const WaitState& s) { return s.name == name; });
  if (found != kStates.end()) return *found;
  std::vector<std::string> words;
  words.reserve(kStates.size());
  for (const WaitState& state : kStates) words.emplace_back(state.name);
  std::string allowed = wait_state_words();
  for (auto at = allowed.find('|'); at != std::string::npos; at = allowed.find('|'))
    allowed.replace(at, 1, ", ");
  throw UsageError(fmt::format("STATE: found '{}'{}; allowed: {}", name, did_you_mean(name, words), allowed));
}

std::string wait_state_words() {
  std::string words;
  for (const WaitState& state : kStates) words += (words.empty() ? "" : "|") + std::string(state.name);
  return words;
}

std::string wait_states_help() {
  std::vector<Explained> entries;
  entries.reserve(kStates.size());
  for (const WaitState& state : kStates)
    entries.emplace_back(std::string(state.name), std::string(state.help));
  return explanation("States", entries);
}

bool is_reached(const WaitState& state, const WaitLook& now) {
  switch (state.of) {
    case Of::daemon:
      return true;
    case Of::nobody:
      return false;
    case Of::master:
      return master_is_in(state.name, now.master.option_status);
    case Of::controller:
      return state.name == now.controller;
    case Of::slaves:
      break;
  }
  if (!asks_slaves(now.master)) return false;
  std::uint32_t in_state = 0;
  for (const client::SlaveStatus& slave : now.slaves)
    if (slave_is_in(state.name, slave)) in_state |= 1u << slave.slave;
  return now.wanted != 0 && (now.wanted & ~in_state) == 0;
}

std::string seen(const WaitState& state, const WaitLook& now) {
  switch (state.of) {
    case Of::daemon:
    case Of::nobody:
      return "the daemon is there";
    case Of::master:
      return fmt::format("the master is in {} (0x{:04X}){}", client::text(now.master.state),
                         now.master.option_status, now.master.second_master ? "; another master sends" : "");
    case Of::controller:
      return fmt::format("the controller is {}", now.controller);
    case Of::slaves:
      break;
  }
  return slaves_seen(state, now);
}

}  // namespace cansync::cli
