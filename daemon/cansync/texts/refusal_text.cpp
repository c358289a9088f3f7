#include "daemon/cansync/texts/refusal_text.h"

#include <fmt/format.h>

#include "cansync/dds/validate.h"
#include "cansync/settings/mode.h"
#include "daemon/cansync/texts/bus_text.h"

namespace cansyncd {
namespace {

using cansync::Refusal;
using cansync::SlaveMask;
using cansync::SlaveNumber;

/// The slave a request is for; nothing for a request to the whole line.
std::optional<unsigned> slave_of(const Request& request) {
  return std::visit(
      [](const auto& r) -> std::optional<unsigned> {
        if constexpr (requires { r.slave; }) return unsigned{r.slave.value()};
        return std::nullopt;
      },
      request);
}

/// The condition for set-up when the mode alone does not bring it about; empty: there is none.
std::string set_up_condition(const Config& config, const RefusalContext& context) {
  if (cansync::is_synchronous(context.state)) return {};
  switch (context.access) {
    case cansync::BusAccess::away:
      return fmt::format("interface {} is missing, down or bus-off: correct that first",
                         config.bus.interface);
    case cansync::BusAccess::listening:
      return "the master listens whether another one sends (startup.listen_ms): wait for its end";
    case cansync::BusAccess::other_master:
      return "another master sends: switch it off, wait 3 s";
    case cansync::BusAccess::granted:
      break;
  }
  if (context.waits_for_upper_sync) return "the upper bus of the cluster has no SYNC: start that one first";
  return {};
}

std::string wrong_state(const Request& request, const Config& config, const RefusalContext& context) {
  const std::string condition = set_up_condition(config, context);
  const std::string set_up =
      condition.empty() ? std::string("give mode setup") : condition + ", then give mode setup";
  const auto now = fmt::format("state: the master is in {} (0x{:04X})", cansync::name(context.state),
                               static_cast<unsigned>(context.state));
  if (std::holds_alternative<ModeRequest>(request))
    return fmt::format("{}; run is entered from setup alone: {}, then mode run", now, set_up);
  if (std::holds_alternative<cansync::ReferenceUpdate>(request)) {
    const bool is_set_up = context.state == cansync::State::setting_up_master;
    return fmt::format("{}; reference values are taken in run (0x0080) alone: {}", now,
                       is_set_up ? std::string("give mode run") : set_up + ", then mode run");
  }
  return fmt::format("{}; jobs are taken in setup (0x0043) and run (0x0080): {}", now, set_up);
}

std::string slaves_missing(const Config& config, const RefusalContext& context) {
  const bool synchronized = config.master.startup.enable == cansync::EnableRule::all_synchronized;
  const SlaveMask there = synchronized ? context.released : context.responding;
  const SlaveMask missing{config.master.configured().bits & ~there.bits};
  if (!missing.empty()) {
    return fmt::format("slaves: not yet {}: {}; wait for them, or give mode run with force",
                       synchronized ? "synchronized and released" : "responding",
                       slave_list(config, missing));
  }
  return "slaves: not yet known whether each is the drive expected, and one drive; `cansync slaves` and "
         "`cansync events` say which; wait for them, or give mode run with force";
}

std::string queue_full(const Request& request, const Config& config) {
  const auto& channel = config.master.command_channel;
  const auto full = [](std::string_view queue, unsigned limit) {
    return fmt::format("queue full: {} {} are open, at most {} are allowed; try again when one has ended",
                       limit, queue, limit);
  };
  if (std::holds_alternative<cansync::ParameterRequest>(request)) {
    return full("parameter jobs", channel.parameter_queue);
  }
  if (std::holds_alternative<cansync::TransferRequest>(request))
    return full("transfers", channel.transfer_queue);
  if (const auto* broadcast = std::get_if<cansync::BroadcastRequest>(&request)) {
    return full(fmt::format("broadcasts of priority {}", broadcast->priority), channel.broadcast_queue);
  }
  if (std::holds_alternative<cansync::ReferenceUpdate>(request)) {
    return "queue full: too many reference values wait for their interval; write them closer to it";
  }
  return "queue full: try again when an open request has ended";
}

/// "slave 3 'winder'" for a request to one slave; a broadcast names many.
std::string who(const Request& request, const Config& config) {
  const auto slave = slave_of(request);
  return slave ? slave_label(config, *slave) : std::string("a slave of the mask");
}

std::string slave_held(const Request& request, const Config& config) {
  return fmt::format(
      "control word: {} is held out, so that no control word with all of the bits 0x{:04X} is sent to it; "
      "`cansync slaves` and `cansync events` say why, then `cansync release`",
      who(request, config), config.master.startup.enabling_control_bits);
}

std::string other_master(const Config& config) {
  return fmt::format(
      "mode: another master sends on the bus of interface {}, so SYNC and telegrams of this one would "
      "disturb every drive; switch the other one off and wait 3 s, or, if you know that both may send: cansync "
      "mode setup --force",
      config.bus.interface);
}

std::string interval_passed(const Request& request, const Config& config, const RefusalContext& context) {
  const auto* update = std::get_if<cansync::ReferenceUpdate>(&request);
  return fmt::format(
      "from_interval {}: allowed 0 (the next) or {}..{}, which is the running interval and {} ahead",
      update != nullptr ? update->from_interval : 0, context.interval,
      context.interval + config.master.process.ahead_limit, config.master.process.ahead_limit);
}

std::string mapping_changed(std::uint64_t given, std::uint64_t in_force) {
  return fmt::format(
      "mapping_number {}: the values were made for another mapping of the reference values than the one in "
      "force, which is number {} (MasterStatus.mapping_number); look at `cansync map`, and let the program "
      "take up its telegrams again (ReferenceWriter::take_up), or start it again",
      given, in_force);
}

std::string mapping_changed(const Request& request, const RefusalContext& context) {
  const auto* update = std::get_if<cansync::ReferenceUpdate>(&request);
  return mapping_changed(update != nullptr ? update->mapping_number : 0, context.mapping_number);
}

std::string value_too_wide(const cansync::ReferenceUpdate& update, const RefusalContext& context) {
  const unsigned first = cansync::index(update.channel) * 4;
  const unsigned words = cansync::word_mask(context.reference_mapping);
  constexpr std::string_view remedy =
      "-32768..65535, because its low word alone is mapped; map its high word too, see `cansync map`";
  for (unsigned v = 0; v < 4; ++v) {
    if (((words >> (first + v)) & 1u) == 0 || ((update.valid_mask >> v) & 1u) == 0) continue;
    const auto value = static_cast<std::int32_t>(update.value[v]);
    if (cansync::fits_word(update.value[v])) continue;
    return fmt::format("value[{}] {}: reference value {} allows {}", v, value, first + v, remedy);
  }
  return fmt::format(
      "value: one that keeps what it got under another mapping is wider than a word; give every value, each "
      "{}",
      remedy);
}

std::string block_size(const Request& request, const Config& config) {
  const auto* transfer = std::get_if<cansync::TransferRequest>(&request);
  if (transfer == nullptr) return "block_size: out of range";
  const unsigned limit = config.master.slaves[transfer->slave.value()].block_limit;
  const unsigned step = config.master.command_channel.address_step;
  return fmt::format("block_size {}: allowed 1..{} in whole start addresses (multiples of {}), 0 = {}",
                     transfer->block_size, limit, step, limit);
}

}  // namespace

std::string slave_label(const Config& config, unsigned slave) {
  if (slave >= config.slaves.size() || config.slaves[slave].name.empty())
    return fmt::format("slave {}", slave);
  return fmt::format("slave {} '{}'", slave, config.slaves[slave].name);
}

std::string slave_list(const Config& config, SlaveMask slaves) {
  constexpr unsigned kSpelledOut = 8;
  std::string list;
  unsigned told = 0;
  unsigned more = 0;
  for (const SlaveNumber slave : slaves) {
    if (told == kSpelledOut) {
      ++more;
      continue;
    }
    if (told++ != 0) list += ", ";
    list += slave_label(config, slave.value());
  }
  if (more != 0) list += fmt::format(" and {} more", more);
  return told != 0 ? list : "none";
}

std::string refusal_text(Refusal refusal, const Request& request, const Config& config,
                         const RefusalContext& context) {
  switch (refusal) {
    case Refusal::wrong_state:
      return wrong_state(request, config, context);
    case Refusal::slaves_missing:
      return slaves_missing(config, context);
    case Refusal::other_master:
      return other_master(config);
    case Refusal::queue_full:
      return queue_full(request, config);
    case Refusal::not_permitted:
      return reset_not_permitted(config);
    case Refusal::bus_unavailable:
      return reset_unavailable(config);
    case Refusal::slave_lost:
      return fmt::format("slave: {} does not answer; check its power and the bus cable",
                         who(request, config));
    case Refusal::slave_held:
      return slave_held(request, config);
    case Refusal::not_held:
      return fmt::format("slave: {} is not held out; there is nothing to release", who(request, config));
    case Refusal::interval_passed:
      return interval_passed(request, config, context);
    case Refusal::too_old:
      return fmt::format(
          "age: more than {} ms when they came to the line, as when the daemon was suspended; at most {} ms "
          "are allowed (failsafe.reference_max_age_ms); write fresh values",
          config.failsafe.reference_max_age.count(), config.failsafe.reference_max_age.count());
    case Refusal::mapping_changed:
      return mapping_changed(request, context);
    case Refusal::lead_axis:
      if (std::holds_alternative<SetReferenceMapping>(request)) {
        return "reference mapping: it changes a telegram that the lead axis gives; leave the words of that "
               "one as they are, or change them in the daemon's file ([lower])";
      }
      return lead_axis_denial().reason;
    case Refusal::block_size:
      return block_size(request, config);
    case Refusal::value_too_wide:
      if (const auto* update = std::get_if<cansync::ReferenceUpdate>(&request)) {
        return value_too_wide(*update, context);
      }
      break;
    case Refusal::slave_not_configured:
      if (const auto slave = slave_of(request)) {
        return fmt::format("slave {}: not configured; configured are {}", *slave,
                           slave_list(config, config.master.configured()));
      }
      break;
    default:
      break;
  }
  return cansync::dds::explain(refusal, cansync::dds::limits_of(config.master));
}

gateway::dds::Denial denial_of(Refusal refusal, const Request& request, const Config& config,
                               const RefusalContext& context) {
  return {cansync::dds::to_cause(refusal), refusal_text(refusal, request, config, context)};
}

gateway::dds::Denial mapping_denial(std::uint64_t given, std::uint64_t in_force) {
  return {gateway_CAUSE_MAPPING_CHANGED, mapping_changed(given, in_force)};
}

gateway::dds::Denial lead_axis_denial() {
  return {cansync::dds::to_cause(Refusal::lead_axis),
          "reference values: the lead axis gives this telegram, so no program may; take its values out of "
          "[[lead]] in the daemon's file, or write the other telegram"};
}

std::string outcome_text(cansync::Outcome outcome, const Request& request, const Config& config) {
  if (outcome == cansync::Outcome::slave_held) return slave_held(request, config);
  if (outcome != cansync::Outcome::slave_lost) return {};
  const auto* parameter = std::get_if<cansync::ParameterRequest>(&request);
  const bool writes = parameter != nullptr && parameter->write;
  return fmt::format("{} stopped answering; check its power and the bus cable{}", who(request, config),
                     writes ? "; the value was not sent" : "");
}

}  // namespace cansyncd
