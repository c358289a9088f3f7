#include <fmt/format.h>

#include <bit>
#include <span>
#include <stdexcept>
#include <utility>

#include "cli/base/endings.h"
#include "cli/base/session.h"
#include "cli/text/slave_list.h"
#include "cli/text/values.h"
#include "text/counts.h"

/// The slaves a command line names.
namespace cansync::cli {
namespace {

std::vector<unsigned> numbers_of(std::uint32_t mask) {
  std::vector<unsigned> numbers;
  for (unsigned slave = 0; slave < kSlaves; ++slave)
    if (((mask >> slave) & 1u) != 0) numbers.push_back(slave);
  return numbers;
}

std::uint32_t mask_of(std::span<const unsigned> slaves) {
  std::uint32_t mask = 0;
  for (const unsigned slave : slaves) mask |= 1u << slave;
  return mask;
}

std::uint32_t mask_of(const std::vector<client::SlaveStatus>& slaves) {
  std::uint32_t mask = 0;
  for (const client::SlaveStatus& status : slaves) mask |= 1u << status.slave;
  return mask;
}

}  // namespace

std::uint32_t Session::slave_mask(std::string_view list) {
  std::string problem;
  return parse_slave_list(list, {[&](std::string_view name) {
                                   hold_names();
                                   const client::SlaveLookup found = client().find_slave(name);
                                   problem = found.problem;
                                   return found.slave ? int{*found.slave} : -1;
                                 },
                                 [this] { return client().master_status().slaves_configured; },
                                 [&](std::string_view /*name*/) { return problem; }});
}

std::vector<unsigned> Session::slaves(std::string_view list) {
  const std::uint32_t mask = slave_mask(list);
  std::vector<unsigned> numbers = numbers_of(mask);
  // A single number goes to the daemon as it is, which says what is wrong with it.
  if (numbers.size() > 1) expect_configured(mask);
  return numbers;
}

void Session::expect_configured(std::uint32_t slaves) {
  const std::uint32_t configured = client().master_status().slaves_configured;
  if ((slaves & ~configured) == 0) return;
  throw UsageError(fmt::format("SLAVE: {} not configured; configured are {}",
                               format_slave_set(slaves & ~configured), format_slave_set(configured)));
}

std::uint32_t Session::configured_slaves(const std::vector<std::string>& texts) {
  std::uint32_t wanted = 0;
  for (const std::string& text : texts) wanted |= slave_mask(text);
  if (texts.empty()) return client().master_status().slaves_configured;
  expect_configured(wanted);
  return wanted;
}

std::string Session::slave_name(unsigned slave) {
  hold_names();
  for (const client::SlaveStatus& status : every_slave())
    if (status.slave == slave) return std::string(client::text(status.name));
  return "";
}

std::vector<client::SlaveStatus> Session::every_slave() {
  std::vector<client::SlaveStatus> slaves = client().slaves(search_time());
  const std::uint32_t missing = client().master_status().slaves_configured & ~mask_of(slaves);
  if (missing == 0) return slaves;
  throw std::runtime_error(fmt::format("the daemon has not told of {} {} yet; try again",
                                       std::has_single_bit(missing) ? "slave" : "slaves",
                                       format_slave_set(missing)));
}

void Session::hold_names() {
  if (!held_) held_.emplace(client().master_status(), every_slave());
}

std::optional<std::string> Session::change_of_names(std::chrono::milliseconds time) {
  if (!held_) return "";
  try {
    const std::vector<client::SlaveStatus> slaves = client().slaves(time);
    const client::MasterStatus master = client().master_status();
    if ((master.slaves_configured & ~mask_of(slaves)) != 0) return std::nullopt;
    return held_->change_to({master, slaves});
  } catch (const client::OtherProtocol&) {
    throw;
  } catch (const client::NoDaemon&) {
    return std::nullopt;
  }
}

std::string Session::names_changed() {
  return change_of_names(std::chrono::milliseconds(0)).value_or("");
}

void Session::expect_names() {
  const std::optional<std::string> change = change_of_names(search_time());
  // Without a daemon the request says so; after a new start of it the first one is refused, and this is asked again.
  if (change ? change->empty() : !client().daemon_present()) return;
  throw Ended(
      ExitCode::refused,
      fmt::format(
          "{} since this command was looked up: not sent; look at `cansync slaves`, then give it again",
          change.value_or("the daemon has not told the names of all slaves")));
}

bool Session::follow_names(const std::function<void()>& look_up, bool quiet) {
  constexpr std::chrono::seconds kLongest{2};
  const std::string change = names_changed();
  if (change.empty()) return true;
  const auto now = std::chrono::steady_clock::now();
  if (!unsettled_since_) unsettled_since_ = now;
  const std::optional<HeldNames> before = std::exchange(held_, std::nullopt);
  try {
    look_up();
  } catch (const UsageError&) {
    held_ = before;
    if (now >= *unsettled_since_ + kLongest) throw;
    return false;
  }
  unsettled_since_.reset();
  if (!quiet) output_.remark(change + "; names are looked up again");
  return true;
}

std::vector<std::string> Session::files(std::string_view pattern, const std::vector<unsigned>& slaves) {
  if (slaves.size() > 1 && !is_file_pattern(pattern)) {
    throw UsageError(fmt::format(
        "FILE: found '{}' for {}; allowed: a name with {{slave}} (the number) or {{name}} in it, so that "
        "each slave has a file of its own, such as {{name}}.toml",
        pattern, text::counted(slaves.size(), "slave")));
  }
  std::vector<std::string> files;
  for (const unsigned slave : slaves) {
    const bool by_name = pattern.find("{name}") != std::string_view::npos;
    files.push_back(file_of_slave(pattern, slave, by_name ? slave_name(slave) : ""));
  }
  return files;
}

ExitCode Session::for_each(const std::vector<unsigned>& slaves,
                           const std::function<ExitCode(std::size_t)>& one, Lines lines) {
  if (slaves.size() == 1) return one(0);
  ExitCode first = ExitCode::done;
  several_ = true;
  if (lines != Lines::each) output_.begin_group();
  for (std::size_t index = 0; index < slaves.size(); ++index) {
    ExitCode code = ExitCode::done;
    output_.set_slave(slaves[index]);
    try {
      expect_names();
      code = one(index);
    } catch (const std::exception& error) {
      output_.remark(fmt::format("slave {}: {}", slaves[index], error.what()));
      code = code_of(error);
    }
    if (code == ExitCode::done && lines == Lines::failures_grouped) output_.say_kept();
    output_.set_slave(std::nullopt);
    if (first == ExitCode::done) first = code;
    if (!interrupt_flag().load()) continue;
    const auto left = std::span(slaves).subspan(index + 1);
    if (left.empty()) break;
    output_.remark(fmt::format("{} {}: not done", left.size() == 1 ? "slave" : "slaves",
                               format_slave_set(mask_of(left))));
    if (first == ExitCode::done) first = ExitCode::cancelled;
    break;
  }
  several_ = false;
  output_.end_group();
  return first;
}

}  // namespace cansync::cli
