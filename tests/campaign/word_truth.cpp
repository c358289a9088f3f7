#include "word_truth.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "parameter_truth.h"

namespace cansyncd::campaign {
namespace {

using Has = WordTruth::Has;
using cansync::Outcome;

/// What each word says: of a write, of a download, of a control word or broadcast.
struct Meaning {
  std::string_view word;
  Has write;
  Has download;
  Has action;
};

/// Of the field CANSYNC_RESULT, and `result` of an event.
constexpr std::array kResults = {
    Meaning{"done", Has::yes, Has::yes, Has::yes},
    Meaning{"slave error", Has::refused, Has::anything, Has::anything},
    Meaning{"timeout", Has::anything, Has::no, Has::no},
    Meaning{"no answer", Has::not_known, Has::not_known, Has::not_known},
    Meaning{"taken by the slave, no final answer", Has::not_known, Has::not_known, Has::not_known},
    Meaning{"word expected", Has::refused, Has::anything, Has::anything},
    Meaning{"doubleword expected", Has::refused, Has::anything, Has::anything},
    Meaning{"value too wide", Has::no, Has::anything, Has::anything},
    Meaning{"cancelled", Has::no, Has::no, Has::no},
    Meaning{"master stopped", Has::no, Has::no, Has::no},
    Meaning{"slave lost", Has::no, Has::no, Has::no},
    Meaning{"slave held out", Has::no, Has::no, Has::no},
    Meaning{"replaced", Has::no, Has::no, Has::no},
};

/// Of `EVENT`, and `code` of an event.
constexpr std::array kEvents = {
    Meaning{"request_done", Has::yes, Has::yes, Has::yes},
    Meaning{"request_failed", Has::anything, Has::anything, Has::anything},
    Meaning{"request_refused", Has::no, Has::no, Has::no},
};

/// Of the exit status of `cansync`.
constexpr std::array kStatuses = {
    Meaning{"0", Has::yes, Has::yes, Has::yes},
    Meaning{"3", Has::no, Has::no, Has::no},
    Meaning{"4", Has::refused, Has::anything, Has::anything},
    Meaning{"5", Has::anything, Has::anything, Has::anything},
    Meaning{"7", Has::no, Has::no, Has::no},
};

/// Of the reply code, by its number in the data model.
constexpr std::array kCodes = {
    Meaning{"0", Has::yes, Has::yes, Has::yes},                    // DONE
    Meaning{"1", Has::no, Has::no, Has::no},                       // REFUSED
    Meaning{"2", Has::refused, Has::anything, Has::anything},      // SLAVE_ERROR
    Meaning{"3", Has::anything, Has::no, Has::no},                 // TIMEOUT
    Meaning{"4", Has::not_known, Has::not_known, Has::not_known},  // NO_ANSWER
    Meaning{"5", Has::refused, Has::anything, Has::anything},      // WORD_EXPECTED
    Meaning{"6", Has::refused, Has::anything, Has::anything},      // DOUBLEWORD_EXPECTED
    Meaning{"7", Has::no, Has::anything, Has::anything},           // VALUE_TOO_WIDE
    Meaning{"8", Has::no, Has::no, Has::no},                       // CANCELLED
    Meaning{"9", Has::no, Has::no, Has::no},                       // MASTER_STOPPED
    Meaning{"10", Has::no, Has::no, Has::no},                      // SLAVE_LOST
    Meaning{"11", Has::no, Has::no, Has::no},                      // REPLACED
};

/// Of words of the reason.
constexpr std::array kPhrases = {
    Meaning{"not sent", Has::no, Has::no, Has::no},
    Meaning{"not known", Has::not_known, Has::not_known, Has::not_known},
    Meaning{"has taken the value", Has::not_known, Has::not_known, Has::not_known},
    Meaning{"a part of the data was sent", Has::not_known, Has::not_known, Has::not_known},
};

const cansync::ParameterRequest* parameter_in(const Request& request) {
  return std::get_if<cansync::ParameterRequest>(&request);
}

bool is_write(const Request& request) {
  const auto* parameter = parameter_in(request);
  return parameter != nullptr && parameter->write;
}

bool is_download(const Request& request) {
  const auto* transfer = std::get_if<cansync::TransferRequest>(&request);
  return transfer != nullptr && transfer->direction == cansync::TransferRequest::Direction::download;
}

std::optional<cansync::ActionCommand> action_in(const Request& request) {
  if (const auto* word = std::get_if<cansync::ControlWordRequest>(&request))
    return cansync::ActionCommand{cansync::SlaveMask::of(word->slave), 1, 0, word->control_word};
  const auto* broadcast = std::get_if<cansync::BroadcastRequest>(&request);
  return broadcast == nullptr ? std::nullopt : std::optional(broadcast->action);
}

/// What `meaning` says of a request of this kind; of one that has no truth here: nothing.
Has says(const Meaning& meaning, const Request& request) {
  if (is_write(request)) return meaning.write;
  if (is_download(request)) return meaning.download;
  return action_in(request) ? meaning.action : Has::anything;
}

/// A word without a meaning is one that this table has to learn: nothing means it.
template <std::size_t N>
std::optional<Has> meaning_of(const std::array<Meaning, N>& table, std::string_view word,
                              const Request& request) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const Meaning& m) { return m.word == word; });
  return found == table.end() ? std::nullopt : std::optional(says(*found, request));
}

std::optional<Has> meaning_of_result(std::string_view result, const Request& request) {
  if (result.starts_with("refused: ")) return says({"", Has::no, Has::no, Has::no}, request);
  return meaning_of(kResults, result, request);
}

bool changes_something(const Request& request) {
  if (const auto* transfer = std::get_if<cansync::TransferRequest>(&request))
    return transfer->direction == cansync::TransferRequest::Direction::download;
  const auto* parameter = parameter_in(request);
  return parameter == nullptr || parameter->write;
}

std::string request_text(cansync::JobId id) {
  return "request " + std::to_string(id);
}

void complain(std::string& first, std::string text) {
  if (first.empty()) first = std::move(text);
}

auto key_of(const cansync::ActionCommand& action) {
  return std::tuple{action.slaves.bits, action.command, action.data_byte, action.data_word};
}

bool watched(const cansync::ParameterRequest& request) {
  const auto& numbers = ParameterTruth::kWritten;
  return request.sub_slave.value == 0 &&
         std::find(std::begin(numbers), std::end(numbers), request.number.value()) != std::end(numbers);
}

}  // namespace

WordTruth::WordTruth(const Plan& plan, Exchange& exchange, SentTruth& sent, Coverage& coverage,
                     Tamper* tamper)
    : plan_(plan), sent_(sent), coverage_(coverage), tamper_(tamper), words_(plan, exchange) {}

void WordTruth::powered_on(sim::Drive& drive) {
  drive.watch(*this);
  for (const std::uint16_t number : ParameterTruth::kWritten) {
    Cell& cell = cells_[{drive.number().value(), number}];
    cell = {drive.parameters().value(number).value_or(0), true};
  }
}

void WordTruth::parameter_written(cansync::SlaveNumber drive, cansync::ParameterNumber number,
                                  std::uint32_t value) noexcept {
  const SentTruth::Write write{drive.value(), number.value(), value};
  ++taken_[write];
  Cell& cell = cells_[{write.slave, write.number}];
  for (auto& [id, asked] : open_) {
    const auto its = write_of(asked.request);
    if (!its || its->slave != write.slave || its->number != write.number) continue;
    if (!asked.replaced && its == write) asked.replaced = cell.value;
    asked.held.insert(value);
  }
  cell.value = value;
}

std::optional<SentTruth::Write> WordTruth::write_of(const Request& request) {
  if (!is_write(request)) return std::nullopt;
  const auto& write = *parameter_in(request);
  return SentTruth::Write{write.slave.value(), write.number.value(), write.value};
}

void WordTruth::forget_ended() {
  constexpr std::size_t kMany = 1000;
  if (taken_.size() + actions_.size() < kMany) return;
  std::erase_if(actions_, [](const auto& entry) {
    const Actions& all = entry.second;
    return all.asked == all.denied + all.done + all.unknown;
  });
  const auto is_open = [this](const SentTruth::Write& write) {
    return std::any_of(open_.begin(), open_.end(),
                       [&](const auto& entry) { return write_of(entry.second.request) == write; });
  };
  std::erase_if(taken_, [&](const auto& entry) { return !is_open(entry.first); });
  sent_.forget([&](const auto& key) {
    if constexpr (std::is_same_v<decltype(key), const SentTruth::Write&>)
      return is_open(key);
    else
      return actions_.contains(key);
  });
}

void WordTruth::pushed(cansync::JobId id, const Request& request) {
  forget_ended();
  Asked asked;
  asked.request = request;
  if (const auto write = write_of(request)) {
    asked.sent_before = sent_.writes(*write);
    asked.taken_before = taken_[*write];
    asked.held.insert(cells_[{write->slave, write->number}].value);
    for (auto& [other, open] : open_) {
      const auto its = write_of(open.request);
      if (!its || its->slave != write->slave || its->number != write->number) continue;
      // The daemon does not know yet how that one ends: what was before it is right for this one, too.
      asked.held.insert(open.held.begin(), open.held.end());
      if (its == write) asked.shares = open.shares = true;
    }
  }
  if (const auto action = action_in(request)) ++actions_[key_of(*action)].asked;
  open_.emplace(id, std::move(asked));
}

// --- what is known

WordTruth::Known WordTruth::known_of_action(const cansync::ActionCommand& action, const Terminal& terminal) {
  // Equal words of several requests cannot be told apart: they are counted.
  Actions& actions = actions_[key_of(action)];
  const auto* done = std::get_if<CommandDone>(&terminal);
  const Outcome outcome = done == nullptr ? Outcome::cancelled : done->outcome;
  ++(outcome == Outcome::done        ? actions.done
     : outcome == Outcome::no_answer ? actions.unknown
                                     : actions.denied);
  const SentTruth::Count count = sent_.action(action);
  Known known;
  known.has = count.on_bus >= actions.done;
  known.sent = count.handed >= actions.done + actions.unknown;
  known.untouched = count.handed <= actions.asked - actions.denied;
  return known;
}

WordTruth::Known WordTruth::known(const Asked& asked, const Terminal& terminal,
                                  const std::optional<MemoryTruth::Facts>& memory, bool doubtful) {
  if (const auto action = action_in(asked.request)) return known_of_action(*action, terminal);
  Known known;
  known.doubtful = doubtful;
  if (const auto write = write_of(asked.request)) {
    known.sent = sent_.writes(*write) != asked.sent_before;
    known.has = taken_[*write] != asked.taken_before;
    known.untouched = !known.has;
    known.certain = !asked.shares;
  } else if (is_download(asked.request) && memory) {
    known.sent = true;
    known.has = memory->has_all;
    known.untouched = memory->untouched;
  } else {
    known.certain = false;
  }
  return known;
}

// --- what is said

void WordTruth::judge_words(cansync::JobId id, const Asked& asked, const Said& said, const Known& known) {
  const auto judge = [&](std::string_view what, std::string_view word, std::optional<Has> means) {
    std::string wrong;
    if (!means) {
      wrong = "which means nothing here";
    } else if (!known.certain) {
      return;
    } else if (*means == Has::yes && !known.has && !known.doubtful) {
      wrong = "and the drive has not had it";
    } else if (*means == Has::no && !known.untouched) {
      wrong = "and the drive has it";
    } else if (*means == Has::refused && !known.untouched && !known.doubtful) {
      wrong = "and the drive has it";
    } else if (*means == Has::not_known && !known.sent) {
      wrong = "and nothing of it was sent";
    }
    if (wrong.empty()) return;
    complain(wrong_word_,
             std::string(what) + " of " + request_text(id) + " is '" + std::string(word) + "', " + wrong);
  };
  const Request& request = asked.request;
  const std::string code = std::to_string(said.code);
  judge("the reply code", code, meaning_of(kCodes, code, request));
  const std::string status = std::to_string(said.exit_status);
  judge("the exit status", status, meaning_of(kStatuses, status, request));
  for (const Meaning& phrase : kPhrases) {
    if (said.reason.find(phrase.word) != std::string::npos)
      judge("the reason", said.reason, says(phrase, request));
  }
  for (const JournalEntry& entry : said.entries) {
    judge("the entry", entry.event, meaning_of(kEvents, entry.event, request));
    const std::string_view result = entry.field("CANSYNC_RESULT");
    judge("the result in the journal", result, meaning_of_result(result, request));
  }
  for (const EventText& event : said.events) {
    judge("the event", event.code.word(), meaning_of(kEvents, event.code.word(), request));
    judge("the result in the event", event.request->result,
          meaning_of_result(event.request->result, request));
  }
}

void WordTruth::judge_entry(cansync::JobId id, const Asked& asked, const Said& said,
                            const Terminal& terminal) {
  const bool changes = changes_something(asked.request);
  const bool refused = std::holds_alternative<Refused>(terminal);
  if (changes && refused && said.entries.empty() && said.events.empty()) {
    ++refused_unrecorded_;  // told in a sum, which is looked at in the end
    return;
  }
  const std::size_t due = changes ? 1 : 0;
  if (said.entries.size() != due || said.events.size() != due) {
    complain(wrong_entry_, request_text(id) + " changes " + (changes ? "something" : "nothing") +
                               ", and has " + std::to_string(said.entries.size()) + " entries and " +
                               std::to_string(said.events.size()) + " events");
    return;
  }
  if (!changes) return;
  coverage_.met(Coverage::Met::changes_told);
  const JournalEntry& entry = said.entries.front();
  const EventText& event = said.events.front();
  const auto expect = [&](std::string_view name, const std::string& value) {
    if (entry.field(name) == value) return;
    complain(wrong_entry_, "the entry of " + request_text(id) + " has " + std::string(name) + " '" +
                               std::string(entry.field(name)) + "' instead of '" + value + "'");
  };
  expect("CANSYNC_REQUEST", std::to_string(id));
  if (is_write(asked.request)) {
    const auto& write = *parameter_in(asked.request);
    expect("CANSYNC_ACTION", "parameter_write");
    expect("SLAVE", std::to_string(write.slave.value()));
    expect("PARAMETER", std::to_string(write.number.value()));
    expect("CANSYNC_NEW", std::to_string(write.value));
  } else if (const auto* word = std::get_if<cansync::ControlWordRequest>(&asked.request)) {
    expect("CANSYNC_ACTION", "control_word");
    expect("SLAVE", std::to_string(word->slave.value()));
  } else if (std::holds_alternative<cansync::BroadcastRequest>(asked.request)) {
    expect("CANSYNC_ACTION", "broadcast");
  } else if (is_download(asked.request)) {
    expect("CANSYNC_ACTION", "download");
  }
  const bool same = event.code.word() == entry.event &&
                    event.request->action == entry.field("CANSYNC_ACTION") &&
                    event.request->old_value == entry.field("CANSYNC_OLD") &&
                    event.request->new_value == entry.field("CANSYNC_NEW") &&
                    event.request->result == entry.field("CANSYNC_RESULT");
  if (!same)
    complain(wrong_entry_, "the event of " + request_text(id) + " says something else than its entry");
}

void WordTruth::judge_before(cansync::JobId id, const Asked& asked, const Said& said,
                             const Terminal& terminal, bool doubtful) {
  const auto* done = std::get_if<ParameterDone>(&terminal);
  if (!is_write(asked.request) || done == nullptr || said.entries.empty()) return;
  const auto& write = *parameter_in(asked.request);
  const std::string_view before = said.entries.front().field("CANSYNC_OLD");
  if (!watched(write) || before == AuditTrail::kNotKnown || asked.shares || doubtful) return;
  const Cell& cell = cells_[{write.slave.value(), write.number.value()}];
  if (cell.forgotten) return;
  coverage_.met(Coverage::Met::values_before);
  // A gateway that hangs hears of the end when others have written since.
  const auto is_it = [&](std::uint32_t value) { return before == std::to_string(value); };
  const std::uint32_t had = asked.replaced.value_or(cell.value);
  if (is_it(had) || (!asked.replaced && std::any_of(asked.held.begin(), asked.held.end(), is_it))) return;
  complain(wrong_before_, "before " + request_text(id) + " was " + std::to_string(had) +
                              ", and its entry says " + std::string(before));
}

/// After a value that the daemon has read or written, what was before its drive's power-on counts no more.
void WordTruth::learn(const Asked& asked, const Terminal& terminal) {
  const auto* parameter = parameter_in(asked.request);
  const auto* done = std::get_if<ParameterDone>(&terminal);
  if (parameter == nullptr || done == nullptr || !watched(*parameter)) return;
  if (parameter->element != cansync::kValueElement || done->result.outcome != Outcome::done) return;
  Cell& cell = cells_[{parameter->slave.value(), parameter->number.value()}];
  cell.forgotten = cell.value != done->result.value;
}

void WordTruth::ended(const Terminal& terminal, const std::optional<MemoryTruth::Facts>& memory,
                      bool doubtful, cansync::State state, can::Time now) {
  const cansync::JobId id = std::visit([](const auto& typed) { return typed.id; }, terminal);
  const auto found = open_.find(id);
  if (found == open_.end()) return;
  const Asked asked = std::move(found->second);
  open_.erase(found);
  const bool remembers = tamper_ == nullptr || tamper_->remembers(asked.request);
  Said said = words_.ended(asked.request, terminal, state, remembers, SteadyTime(now));
  if (tamper_ != nullptr) tamper_->said(said);
  judge_words(id, asked, said, known(asked, terminal, memory, doubtful));
  judge_entry(id, asked, said, terminal);
  // A late telegram may have changed what was read before it came.
  judge_before(id, asked, said, terminal,
               plan_.doubtful_answers(0, static_cast<std::uint64_t>(now / plan_.interval())));
  learn(asked, terminal);
}

void WordTruth::all_ended(can::Time now) {
  const std::uint64_t summed_up = words_.summed_up(SteadyTime(now + std::chrono::seconds(2)));
  if (summed_up == refused_unrecorded_) return;
  complain(wrong_entry_, std::to_string(refused_unrecorded_) + " refused requests have no entry, and " +
                             std::to_string(summed_up) + " are counted");
}

}  // namespace cansyncd::campaign
