#include "parameter_truth.h"

#include <algorithm>

namespace cansyncd::campaign {
namespace {

using Values = std::vector<std::uint32_t>;

/// Values remembered of what a parameter held before.
constexpr std::size_t kPast = 64;

bool holds(const Values& values, std::uint32_t value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

void add(Values& values, std::uint32_t value) {
  if (!holds(values, value)) values.push_back(value);
}

std::string text(const Values& values) {
  std::string result;
  for (const std::uint32_t value : values) result += (result.empty() ? "" : ", ") + std::to_string(value);
  return result;
}

std::string parameter_text(unsigned slave, unsigned number) {
  return "parameter " + std::to_string(number) + " of slave " + std::to_string(slave);
}

}  // namespace

void ParameterTruth::powered_on(const sim::Drive& drive) {
  for (const std::uint16_t number : kWritten) {
    Cell& cell = cells_[{drive.number().value(), number}];
    for (const std::uint32_t value : cell.held) add(cell.past, value);
    cell.held = {drive.parameters().value(number).value_or(0)};
    // A telegram that was held up may still reach the drive.
    for (const std::uint32_t value : cell.unsure) add(cell.held, value);
    cell.before_power_on = last_pushed_;
    for (auto& [id, may_give] : reads_) add(may_give, cell.held.front());
  }
}

ParameterTruth::Cell* ParameterTruth::cell(const cansync::ParameterRequest& request) {
  const auto found = cells_.find({request.slave.value(), request.number.value()});
  return found == cells_.end() ? nullptr : &found->second;
}

void ParameterTruth::pushed(const cansync::ParameterRequest& request) {
  last_pushed_ = request.id;
  Cell* at = cell(request);
  if (at == nullptr || request.element != cansync::kValueElement || request.sub_slave.value != 0) return;
  if (!request.write) {
    Values& may_give = reads_[request.id];
    may_give = at->held;
    for (const auto& [id, value] : at->open) add(may_give, value);
    return;
  }
  at->open.emplace_back(request.id, request.value);
  // Reads of other parameters than this one do not need it, and are none the worse for it.
  for (auto& [id, may_give] : reads_) add(may_give, request.value);
}

void ParameterTruth::refused(const cansync::ParameterRequest& request) {
  reads_.erase(request.id);
  if (Cell* at = cell(request)) {
    std::erase_if(at->open, [&](const auto& write) { return write.first == request.id; });
  }
}

void ParameterTruth::answered(const cansync::ParameterRequest& request,
                              const cansync::ParameterResult& result, bool doubtful) {
  using cansync::Outcome;
  if (!request.write) {
    check_read(request, result, doubtful);
    reads_.erase(request.id);
    return;
  }
  Cell* at = cell(request);
  const bool watched = at != nullptr && std::erase_if(at->open, [&](const auto& write) {
                                          return write.first == request.id;
                                        }) != 0;
  if (!watched) return;
  // "Cancelled", "master stopped" and "slave lost" say that the drive has nothing.
  const bool unknown = result.outcome == Outcome::no_answer || result.outcome == Outcome::timeout ||
                       result.outcome == Outcome::taken;
  if (result.outcome == Outcome::done) {
    for (const std::uint32_t value : at->held) add(at->past, value);
    if (!doubtful && request.id > at->before_power_on) {
      at->held.clear();
      at->unsure.clear();
    }
  }
  if (unknown) add(at->unsure, request.value);
  if (result.outcome == Outcome::done || unknown || doubtful) add(at->held, request.value);
  if (at->past.size() > kPast) at->past.erase(at->past.begin(), at->past.end() - kPast / 2);
}

void ParameterTruth::check_read(const cansync::ParameterRequest& request,
                                const cansync::ParameterResult& result, bool doubtful) {
  const auto read = reads_.find(request.id);
  if (result.outcome != cansync::Outcome::done || read == reads_.end()) return;
  if (holds(read->second, result.value)) return;
  if (doubtful && holds(cell(request)->past, result.value)) return;
  complain("request " + std::to_string(request.id) + " read " + std::to_string(result.value) + " from " +
           parameter_text(request.slave.value(), request.number.value()) + ", which held only " +
           text(read->second) + " since it was asked");
}

void ParameterTruth::look(const sim::Drive& drive) {
  for (const std::uint16_t number : kWritten) {
    const Cell& at = cells_.at({drive.number().value(), number});
    const std::uint32_t value = drive.parameters().value(number).value_or(0);
    const bool open = std::any_of(at.open.begin(), at.open.end(),
                                  [value](const auto& write) { return write.second == value; });
    if (open || holds(at.held, value)) continue;
    complain(parameter_text(drive.number().value(), number) + " holds " + std::to_string(value) +
             ", and by the answers it can only hold " + text(at.held));
  }
}

}  // namespace cansyncd::campaign
