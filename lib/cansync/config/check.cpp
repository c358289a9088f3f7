#include "cansync/config/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "cansync/config/bus_budget.h"
#include "cansync/config/check_sync.h"
#include "cansync/config/expect.h"
#include "cansync/config/reference_limits.h"
#include "cansync/settings/settings_check.h"
#include "cansync/telegram/mapping.h"
#include "daemon_config/check_daemon.h"
#include "daemon_config/check_profiles.h"

namespace cansyncd {
namespace {

using Problems = std::vector<Problem>;

/// Fields of `MasterSettings` whose option has another name.
constexpr auto kOptionOfField = std::to_array<std::pair<std::string_view, std::string_view>>({
    {"bit_rate", "bus.bit_rate"},
    {"send_margin", "bus.send_margin_us"},
    {"sync", "sync.can_identifier"},
    {"startup.listen", "startup.listen_ms"},
    {"startup.status_period", "startup.status_period_ms"},
    {"process.polling[0]", "process.polling_1"},
    {"process.polling[1]", "process.polling_2"},
    {"command_channel.control_word", "command_channel.control_word_cursor"},
    {"command_channel.parameter", "command_channel.parameter_cursor"},
    {"command_channel.transfer", "command_channel.transfer_cursor"},
    {"command_channel.parameter_monitoring", "command_channel.parameter_timeout_ms"},
    {"command_channel.transfer_monitoring", "command_channel.transfer_timeout_ms"},
    {"command_channel.command_monitoring", "command_channel.command_timeout_ms"},
});

/// The checks, with the places of all options given.
class Checker {
 public:
  Checker(Draft& draft, const std::vector<Setting>& settings, const std::string& path)
      : draft_(draft), findings_(settings, path) {}

  Problems run() {
    mappings(draft_.reference, "process.reference", draft_.config.master.process.reference_mapping);
    cansync::ProcessMapping common = cansync::SlaveSettings{}.actual_mapping;
    mappings(draft_.actual_common, "process.actual", common);
    for (unsigned n = 0; n < cansync::kSlaves; ++n) {
      cansync::SlaveSettings& slave = draft_.config.master.slaves[n];
      slave.actual_mapping = common;
      if (slave.configured)
        mappings(draft_.actual[n], fmt::format("slave.{}.actual", n), slave.actual_mapping);
    }
    slave_names();
    value_names();
    status_values();
    return_parameters();
    for (LimitProblem& wrong : finish_reference_limits(draft_)) problem(wrong.key, std::move(wrong.text));
    check_daemon(draft_.config, findings_);
    failsafe();
    listening();
    profiles();
    expected();
    if (const auto wrong = wrong_sync_identifier(draft_.config.sync)) problem("sync.can_identifier", *wrong);
    if (findings_.problems().empty()) master();
    return std::move(findings_.problems());
  }

 private:
  const Setting* place(const std::string& key) const { return findings_.place(key); }

  void problem(const std::string& key, std::string text) { findings_.problem(key, std::move(text)); }

  void mappings(const MappingDrafts& drafts, const std::string& prefix, cansync::ProcessMapping& mapping) {
    for (unsigned telegram = 0; telegram < cansync::kChannels; ++telegram) {
      const MappingDraft& draft = drafts[telegram];
      const unsigned number = telegram + 1;
      const std::string registers = fmt::format("{}_registers_{}", prefix, number);
      const std::string values = fmt::format("{}_values_{}", prefix, number);
      const std::string high = fmt::format("{}_high_{}", prefix, number);
      if (draft.registers && (draft.values || draft.high)) {
        problem(registers, fmt::format("found beside {}; allowed: one form, registers or values and high",
                                       draft.values ? values : high));
      } else if (draft.registers) {
        from_registers(registers, *draft.registers, mapping[telegram]);
      } else if (draft.values && draft.high) {
        from_arrays(draft, mapping[telegram]);
      } else if (draft.values || draft.high) {
        problem(draft.values ? values : high,
                fmt::format("found without {}; allowed: both together", draft.values ? high : values));
      }
    }
  }

  void from_registers(const std::string& key, const std::array<std::uint8_t, cansync::kWords>& bytes,
                      cansync::TelegramMapping& mapping) {
    for (unsigned word = 0; word < cansync::kWords; ++word) {
      const auto decoded = cansync::from_register(bytes[word]);
      if (decoded) {
        mapping.word[word] = *decoded;
        continue;
      }
      problem(key, fmt::format(
                       "found 0x{:02X} in word {}; allowed: 0 for an unused word, else bit 0 set, bit 1 for "
                       "the high word, value number 0..7 in bits 2..6",
                       bytes[word], word));
      return;
    }
  }

  void from_arrays(const MappingDraft& draft, cansync::TelegramMapping& mapping) {
    // The row has checked the numbers.
    if (const auto decoded = cansync::from_arrays(*draft.values, *draft.high)) mapping = *decoded;
  }

  void slave_names() {
    std::map<std::string_view, unsigned> seen;
    for (unsigned n = 0; n < cansync::kSlaves; ++n) {
      if (!draft_.config.master.slaves[n].configured) continue;
      const auto [first, fresh] = seen.emplace(draft_.config.slaves[n].name, n);
      if (fresh) continue;
      // A default name cannot be at fault: the one given says the same as it.
      const std::string own = fmt::format("slave.{}.name", n);
      const std::string other = fmt::format("slave.{}.name", first->second);
      const bool own_given = place(own) != nullptr;
      problem(own_given ? own : other,
              fmt::format("found \"{}\", which is the name of slave {} too; allowed: each name once",
                          first->first, own_given ? first->second : n));
    }
  }

  /// One value of a list with each name, and `valueN` is value N alone.
  void value_names() {
    names_once(draft_.config.references,
               [](unsigned value) { return fmt::format("reference.{}.name", value); });
    for (unsigned n = 0; n < cansync::kSlaves; ++n) {
      if (!draft_.config.master.slaves[n].configured) continue;
      names_once(draft_.config.slaves[n].actual, [this, n](unsigned value) {
        const std::string own = fmt::format("slave.{}.value.{}.name", n, value);
        return place(own) != nullptr ? own : fmt::format("actual.{}.name", value);
      });
    }
  }

  template <class KeyOf>
  void names_once(const ValueConfigs& values, const KeyOf& key_of) {
    std::map<std::string, unsigned> seen;
    for (unsigned value = 0; value < cansync::kValues; ++value)
      seen.emplace(fmt::format("value{}", value), value);
    for (unsigned value = 0; value < cansync::kValues; ++value) {
      const std::string& name = values[value].name;
      if (name.empty()) continue;
      const auto [first, fresh] = seen.emplace(name, value);
      if (fresh || first->second == value) continue;
      const std::string key = key_of(value);
      // That of [[actual]] is the same for every slave.
      if (!named_twice_.insert(key).second) continue;
      problem(key, fmt::format("found \"{}\", which means value {}, too; allowed: each name once", name,
                               first->second));
    }
  }

  void status_values() {
    for (unsigned n = 0; n < cansync::kSlaves; ++n) {
      cansync::SlaveSettings& slave = draft_.config.master.slaves[n];
      if (!draft_.status_high[n]) continue;
      if (slave.status_value) {
        slave.status_value->high = *draft_.status_high[n];
      } else if (slave.configured) {
        problem(fmt::format("slave.{}.status_high", n),
                "found without status_value; allowed: beside it, to say which of its words is meant");
      }
    }
  }

  void return_parameters() {
    using cansync::OnReturn;
    for (unsigned n = 0; n < cansync::kSlaves; ++n) {
      const cansync::SlaveSettings& slave = draft_.config.master.slaves[n];
      const bool listed = slave.return_count != 0;
      if (!slave.configured || listed == (slave.on_return != OnReturn::release)) continue;
      const std::string key = fmt::format("slave.{}.on_return", n);
      if (listed) {
        problem(
            place(key) != nullptr ? key : fmt::format("slave.{}.return_parameters", n),
            "found return_parameters, but on_return = \"release\" uses none; allowed: on_return = \"check\" "
            "or \"write\" beside them");
      } else {
        problem(key, fmt::format("found \"{}\" without return_parameters; allowed: a list with at least one",
                                 slave.on_return == OnReturn::check ? "check" : "write"));
      }
    }
  }

  void profiles() {
    ProfileFiles files(std::filesystem::path(findings_.path()).parent_path().string());
    for (unsigned n = 0; n < cansync::kSlaves; ++n) {
      SlaveConfig& slave = draft_.config.slaves[n];
      if (slave.profile.empty()) continue;
      const std::string key = fmt::format("slave.{}.profile", n);
      const Setting* setting = place(key);
      const bool typed = setting != nullptr && setting->overridden;
      auto [parameters, problem_text, found] = files.load(slave.profile, typed);
      slave.parameters = std::move(parameters);
      if (!problem_text.empty())
        draft_.profile_problems.push_back(findings_.at(key, std::move(problem_text)));
      for (Problem& wrong : found) draft_.profile_problems.push_back(std::move(wrong));
    }
  }

  void expected() {
    for (unsigned n = 0; n < cansync::kSlaves; ++n) {
      cansync::SlaveSettings& slave = draft_.config.master.slaves[n];
      if (draft_.expect[n].empty() || !slave.configured) continue;
      const std::string key = fmt::format("slave.{}.expect", n);
      const Setting* setting = place(key);
      const bool typed = setting != nullptr && setting->overridden;
      const auto read =
          expected_values(draft_.expect[n], draft_.config.slaves[n].parameters.get(),
                          typed ? "" : std::filesystem::path(findings_.path()).parent_path().string());
      if (const auto* wrong = std::get_if<std::string>(&read)) {
        const SlaveConfig& config = draft_.config.slaves[n];
        const bool unread = !config.profile.empty() && config.parameters == nullptr;
        problem(key, unread ? fmt::format("{}; profile {} was not read", *wrong, config.profile) : *wrong);
        continue;
      }
      const auto& values = std::get<std::vector<cansync::ParameterValue>>(read);
      std::copy(values.begin(), values.end(), slave.expect.begin());
      slave.expect_count = static_cast<std::uint8_t>(values.size());
    }
  }

  void failsafe() {
    const FailsafeConfig& failsafe = draft_.config.failsafe;
    if (failsafe.reaction == LossReaction::control_word && !failsafe.control_word) {
      problem("failsafe.reaction",
              "found \"control_word\" without failsafe.control_word; allowed: both together");
    }
    const bool hold = failsafe.reaction == LossReaction::hold;
    draft_.config.master.process.hold_too_old = hold ? failsafe.hold_intervals : 0;
  }

  void listening() {
    const bool listens =
        draft_.config.bus.kind != BusKind::simulated || place("startup.listen_ms") != nullptr;
    draft_.config.master.startup.listen =
        listens ? draft_.config.startup.listen : std::chrono::milliseconds(0);
  }

  /// The option a field of the master's settings came from.
  std::string option_of(const std::string& field) const {
    for (const auto& [name, option] : kOptionOfField) {
      if (field == name) return std::string(option);
    }
    if (field == "slaves") return "slave";
    std::string key = field;
    if (key.starts_with("slaves[")) {
      key.replace(0, 7, "slave.");
      key.erase(key.find(']'), 1);
    }
    const std::size_t mapping = key.find("_mapping[");
    if (mapping == std::string::npos) return key;
    const std::string telegram = key.substr(mapping + 9, 1) == "0" ? "1" : "2";
    std::string stem = key.substr(0, mapping);
    for (const std::string& owner : {stem, std::string("process.actual")}) {
      for (const std::string_view form : {"_registers_", "_values_"}) {
        std::string option = fmt::format("{}{}{}", owner, form, telegram);
        if (place(option) != nullptr) return option;
      }
    }
    return stem;
  }

  void master() {
    auto found_problems = cansync::check(draft_.config.master);
    if (found_problems.empty()) found_problems = check_budget(budget_input(draft_.config));
    for (const cansync::SettingProblem& found : found_problems) {
      const std::string key = option_of(found.field);
      const std::size_t word = found.field.find(".word[");
      const std::string where =
          word == std::string::npos ? "" : " in word " + found.field.substr(word + 6, 1);
      problem(key, fmt::format("found {}{}; allowed: {}", found.found, where, found.allowed));
    }
  }

  Draft& draft_;
  std::set<std::string> named_twice_;
  Findings findings_;
};

}  // namespace

std::vector<Problem> check_and_finish(Draft& draft, const std::vector<Setting>& settings,
                                      const std::string& path) {
  return Checker(draft, settings, path).run();
}

}  // namespace cansyncd
