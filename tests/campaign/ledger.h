#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "daemon/cansync/exchange.h"

namespace cansyncd::campaign {

/// A request that is to be answered.
struct Job {
  enum class Kind : std::uint8_t { parameter, transfer, command, mode, setting };
  cansync::JobId id = 0;
  Kind kind = Kind::parameter;
  unsigned client = 0;
  std::uint64_t pushed = 0;             ///< SYNC edges before
  cansync::ParameterRequest parameter;  ///< kind parameter
  cansync::SlaveNumber slave;           ///< kind transfer
  std::uint32_t bytes = 0;              ///< kind transfer
  bool download = false;                ///< kind transfer
};

/// All requests that have no answer yet. Notes every answer that must not be.
class Ledger {
 public:
  /// A number for the next request.
  cansync::JobId next_id() noexcept { return ++last_id_; }

  /// The request was pushed.
  void opened(const Job& job) {
    open_.emplace(job.id, job);
    ++pushed_;
  }

  /// The job that `terminal` answers, which is open no longer; nothing when there is no such job.
  std::optional<Job> answered(const Terminal& terminal) {
    const cansync::JobId id = std::visit([](const auto& typed) { return typed.id; }, terminal);
    const auto found = open_.find(id);
    if (found == open_.end()) {
      complain("request " + std::to_string(id) +
               (id <= last_id_ ? " is answered a second time" : " was never made, and is answered"));
      return std::nullopt;
    }
    const Job job = found->second;
    open_.erase(found);
    if (!fits(job.kind, terminal)) complain("request " + std::to_string(id) + " has another kind of answer");
    return job;
  }

  const std::map<cansync::JobId, Job>& open() const noexcept { return open_; }
  std::uint64_t pushed() const noexcept { return pushed_; }
  /// What was wrong first; empty: nothing.
  const std::string& complaint() const noexcept { return complaint_; }

 private:
  void complain(std::string text) {
    if (complaint_.empty()) complaint_ = std::move(text);
  }
  static bool fits(Job::Kind kind, const Terminal& terminal) noexcept {
    if (std::holds_alternative<Refused>(terminal)) return true;
    if (kind == Job::Kind::parameter) return std::holds_alternative<ParameterDone>(terminal);
    if (kind == Job::Kind::transfer) return std::holds_alternative<TransferDone>(terminal);
    return std::holds_alternative<CommandDone>(terminal);
  }

  std::map<cansync::JobId, Job> open_;
  cansync::JobId last_id_ = 0;
  std::uint64_t pushed_ = 0;
  std::string complaint_;
};

}  // namespace cansyncd::campaign
