#include "simulator/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <string_view>
#include <utility>

#include "can/typed/identifier.h"
#include "cansync/config/drive_settings.h"
#include "cansync/config/file.h"
#include "cansync/config/options.h"
#include "cansync/sim/drive_faults.h"
#include "cansync/telegram/telegram.h"
#include "config/document.h"
#include "sim/device_script.h"
#include "sim/fault_script.h"
#include "simulator/first_look.h"

namespace cansync_sim {
namespace {

// A whole number in decimal or, after 0x, hexadecimal digits.
std::optional<std::uint32_t> parse_number(std::string_view text) {
  int base = 10;
  if (text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X')) {
    base = 16;
    text.remove_prefix(2);
  }
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<cansync::SlaveNumber> parse_slave(std::string_view text) {
  const auto number = text.starts_with("0x") ? std::nullopt : parse_number(text);
  return number ? cansync::SlaveNumber::from(*number) : std::nullopt;
}

template <class Number>
bool read_whole(std::string_view text, Number& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc{} && end == text.data() + text.size();
}

// "0=1000+7": value 0 is 1000 in interval 0 and rises by 7.
std::optional<std::pair<unsigned, sim::ReferenceCurve>> parse_reference(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return std::nullopt;
  const std::string_view raw = text.substr(equals + 1);
  const std::size_t plus = raw.find('+');
  unsigned number = 0;
  std::int32_t offset = 0;
  std::int32_t step = 0;
  if (!read_whole(text.substr(0, equals), number) || number >= cansync::kValues) return std::nullopt;
  if (!read_whole(raw.substr(0, plus), offset)) return std::nullopt;
  if (plus != std::string_view::npos && !read_whole(raw.substr(plus + 1), step)) return std::nullopt;
  sim::ReferenceCurve curve;
  curve.kind = sim::ReferenceCurve::Kind::ramp;
  curve.offset = offset;
  curve.step = step;
  return std::pair{number, curve};
}

// The options of the command line as settings of the daemon's configuration.
std::vector<std::string> overrides(const Arguments& arguments) {
  std::vector<std::string> out = arguments.set;
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) out.push_back(fmt::format("{}={}", key, value));
  };
  if (!arguments.config.empty()) add("bus.interface", arguments.interface);
  add("bus.bit_rate", arguments.bit_rate);
  add("startup.status_parameter", arguments.status_parameter);
  add("sim.lock_time_ms", arguments.lock_time);
  add("sim.memory_bytes", arguments.memory);
  add("sim.missing_references", arguments.missing_references);
  add("sim.seed", arguments.seed);
  return out;
}

// A line of these slaves with defaults for everything else.
cansyncd::ConfigFile plain_line(const std::string& interface, cansync::SlaveMask slaves,
                                const std::vector<std::string>& settings) {
  constexpr const char* kName = "command line";
  std::string text = fmt::format("[bus]\ninterface = '{}'\n", interface);
  for (const cansync::SlaveNumber slave : slaves)
    text += fmt::format("[[slave]]\nnumber = {}\n", slave.value());
  config::Settings given = config::resolve(config::parse_document(text, kName), cansyncd::options());
  for (const std::string& setting : settings) config::override_setting(given, setting, cansyncd::options());
  return cansyncd::build_config(std::move(given), kName);
}

class SetupReader {
 public:
  explicit SetupReader(const Arguments& arguments) : arguments_(arguments) {}

  Setup read() {
    const cansync::SlaveMask slaves = read_slaves();
    read_sync_identifier();
    read_references();
    if (arguments_.interface.empty() && arguments_.config.empty())
      problem("no interface given; usage: cansync-sim INTERFACE, or cansync-sim --help");
    // The name becomes a part of a configuration, between quotes.
    const auto strange = [](char c) { return c <= ' ' || c >= '\x7f' || c == '\''; };
    if (std::any_of(arguments_.interface.begin(), arguments_.interface.end(), strange))
      problem(
          fmt::format("bus.interface: found \"{}\"; allowed: printable characters but space and ', such as "
                      "vcan0 or can0",
                      arguments_.interface));
    if (!setup_.problems.empty()) return std::move(setup_);
    arguments_.device.empty() ? read_line(slaves) : read_device();
    return std::move(setup_);
  }

 private:
  void problem(std::string text) { setup_.problems.push_back(std::move(text)); }

  cansync::SlaveMask read_slaves() {
    if (arguments_.slaves.empty()) return cansync::SlaveMask::of(*cansync::SlaveNumber::from(0));
    const auto slaves = parse_slaves(arguments_.slaves);
    if (!slaves)
      problem(fmt::format("--slaves: found '{}'; allowed: slave numbers 0..31 and ranges, such as 0,3,5-7",
                          arguments_.slaves));
    return slaves.value_or(cansync::SlaveMask{});
  }

  void read_sync_identifier() {
    if (arguments_.sync_id.empty()) return;
    const auto identifier = can::typed_identifier(arguments_.sync_id);
    if (!identifier || identifier->extended) {
      problem(fmt::format(
          "--sync-id: found '{}'; allowed: hexadecimal, as candump prints it: 000..7FF, or 0x0..0x7FF",
          arguments_.sync_id));
    } else if (is_cansync_identifier(identifier->value)) {
      problem(
          fmt::format("--sync-id: found '{}', which CANsync uses itself; allowed: all but 0x010, "
                      "0x100..0x1FF, 0x300..0x3FF and 0x500..0x5FF",
                      arguments_.sync_id));
    } else {
      setup_.bench.sync_identifier = identifier->value;
    }
  }

  void read_references() {
    if (!arguments_.references.empty() && !arguments_.master)
      problem("--reference: given without --master; drives take their reference values from the bus");
    for (const std::string& text : arguments_.references) {
      if (const auto given = parse_reference(text)) {
        references_[given->first] = given->second;
      } else {
        problem(
            fmt::format("--reference: found '{}'; allowed: NUMBER=RAW or NUMBER=RAW+STEP with a number of "
                        "0 to 7, such as 0=1000+7",
                        text));
      }
    }
  }

  void read_master(const cansyncd::Config& config) {
    if (!arguments_.faults.empty()) problem("--faults: given with --master; allowed: with simulated drives");
    setup_.master.emplace();
    setup_.master->master = config.master;
    setup_.master->references = references_;
  }

  void read_device() {
    for (const auto& [option, given] :
         {std::pair{"--config", !arguments_.config.empty()},
          std::pair{"--slaves", !arguments_.slaves.empty()},
          std::pair{"--faults", !arguments_.faults.empty()}, std::pair{"--master", arguments_.master}})
      if (given) problem(fmt::format("{}: given with --device; allowed: one of the two", option));
    sim::DeviceScript script = sim::load_device_script(arguments_.device);
    take_errors(script);
    setup_.interface = arguments_.interface;
    setup_.device = std::move(script.device);
  }

  void read_line(cansync::SlaveMask slaves) {
    const std::vector<std::string> settings = overrides(arguments_);
    cansyncd::ConfigFile file = arguments_.config.empty()
                                    ? plain_line(arguments_.interface, slaves, settings)
                                    : cansyncd::load_config(arguments_.config, settings);
    if (arguments_.sync_id.empty()) setup_.bench.sync_identifier = file.config.sync.can_identifier;
    for (const config::Problem& found : file.problems) problem(to_string(found));
    if (!setup_.problems.empty()) return;
    cansyncd::Config& config = file.config;
    if (config.bus.kind == cansyncd::BusKind::simulated) {
      return problem(
          "interface: found 'sim', which is the daemon's own simulated line; allowed: a CAN interface of the "
          "kernel, such as vcan0 or can0");
    }
    cansync::SlaveMask chosen = config.drives.slaves;
    if (!arguments_.config.empty() && !arguments_.slaves.empty()) {
      chosen = slaves;
      const cansync::SlaveMask strange{chosen.bits & ~config.master.configured().bits};
      if (!strange.empty()) {
        return problem(fmt::format("--slaves: {} has no [[slave]] with number {}; allowed: {}",
                                   arguments_.config, list_of(strange), list_of(config.master.configured())));
      }
    }
    setup_.interface = config.bus.interface;
    if (arguments_.sync_id.empty()) setup_.bench.sync_identifier = config.sync.can_identifier;
    setup_.bench.bit_rate = config.master.bit_rate;
    setup_.bench.seed = config.sim.seed;
    if (arguments_.master) return read_master(config);
    for (const cansync::SlaveNumber slave : chosen) {
      setup_.drives.push_back(cansyncd::drive_settings(config, slave));
      // This process takes its time by itself.
      setup_.drives.back().processing_delay = cansync::Duration{0};
    }
    read_faults(arguments_.faults.empty() ? config.sim.fault_script : arguments_.faults);
  }

  /// What is wrong with a script: it is refused, or what this is in is left out.
  template <class Script>
  void take_errors(const Script& script) {
    for (const config::Problem& error : script.errors)
      (script.refused() ? setup_.problems : setup_.left_out).push_back(to_string(error));
  }

  void read_faults(const std::string& path) {
    if (path.empty()) return;
    sim::FaultScript script = sim::load_fault_script(path, sim::drive_faults());
    take_errors(script);
    for (std::size_t i = 0; i < script.faults.size(); ++i) {
      const std::string reason = impossible(script.faults[i]);
      if (reason.empty()) continue;
      problem(fmt::format("{}:{}:{}: kind = \"{}\": {}", path, script.places[i].line, script.places[i].column,
                          sim::name(script.faults[i].kind), reason));
    }
    setup_.bench.faults = std::move(script.faults);
  }

  // Why a fault cannot be made by a participant of a real bus; empty when it can.
  static std::string impossible(const sim::Fault& fault) {
    constexpr const char* kElsewhere = "; allowed on the simulated line alone (interface = \"sim\")";
    if (fault.kind == sim::FaultKind::corrupted)
      return fmt::format("a drive cannot destroy a frame on a real bus{}", kElsewhere);
    if (fault.kind == sim::FaultKind::late && !may_be_of_drive(fault))
      return fmt::format("only the master decides when its own frames are sent{}", kElsewhere);
    return {};
  }

  // True when a drive sends one of the frames that pass the fault's filter.
  static bool may_be_of_drive(const sim::Fault& fault) {
    for (std::uint32_t n = 0; n < cansync::kSlaves; ++n) {
      for (const std::uint32_t channel : {cansync::identifier::actual_one, cansync::identifier::actual_two,
                                          cansync::identifier::response}) {
        if ((((channel + n) ^ fault.identifier) & fault.mask) == 0) return true;
      }
    }
    return false;
  }

  const Arguments& arguments_;
  std::array<sim::ReferenceCurve, cansync::kValues> references_ = {};
  Setup setup_;
};

}  // namespace

std::optional<cansync::SlaveMask> parse_slaves(const std::string& text) {
  cansync::SlaveMask slaves;
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    const std::string_view part = rest.substr(0, comma);
    const std::size_t dash = part.find('-');
    const auto first = parse_slave(part.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : parse_slave(part.substr(dash + 1));
    if (!first || !last || last->value() < first->value()) return std::nullopt;
    for (unsigned n = first->value(); n <= last->value(); ++n) slaves.set(*cansync::SlaveNumber::from(n));
    if (comma == std::string_view::npos) return slaves;
    rest.remove_prefix(comma + 1);
  }
}

bool is_cansync_identifier(std::uint32_t identifier) noexcept {
  if (identifier == cansync::identifier::action) return true;
  switch (cansync::identifier::channel_of(identifier)) {
    case cansync::identifier::reference_one:
    case cansync::identifier::reference_two:
    case cansync::identifier::actual_one:
    case cansync::identifier::actual_two:
    case cansync::identifier::command:
    case cansync::identifier::response:
      return true;
    default:
      return false;
  }
}

Setup make_setup(const Arguments& arguments) {
  return SetupReader(arguments).read();
}

}  // namespace cansync_sim
