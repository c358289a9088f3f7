// Products that say something else than what is so.
#include <utility>
#include <variant>

#include "mutants.h"
#include "words.h"

namespace cansyncd::campaign {
namespace {

constexpr const char* kWords = "every_word_is_what_the_drives_have";
constexpr const char* kEntry = "every_change_has_one_entry_that_names_it";
constexpr const char* kBefore = "the_value_before_was_there";

bool of_write(const Said& said) {
  return !said.entries.empty() && said.entries.front().field("CANSYNC_ACTION") == "parameter_write";
}

void set_field(JournalEntry& entry, std::string_view name, const char* value) {
  for (JournalField& field : entry.fields) {
    if (field.name == name) field.value = value;
  }
}

/// Says it otherwise of every request that ends with reply code `kCode`.
template <gateway_ReplyCode kCode, void (*change)(Said&)>
class SaysOfCode final : public Tamper {
 public:
  void said(Said& said) override {
    if (said.code == kCode) change(said);
  }
};

void journal_says_cancelled(Said& said) {
  for (JournalEntry& entry : said.entries) set_field(entry, "CANSYNC_RESULT", "cancelled");
}

void journal_says_no_answer(Said& said) {
  for (JournalEntry& entry : said.entries) set_field(entry, "CANSYNC_RESULT", "no answer");
}

void journal_says_what_means_nothing(Said& said) {
  for (JournalEntry& entry : said.entries) set_field(entry, "CANSYNC_RESULT", "done perhaps");
}

void event_says_cancelled(Said& said) {
  for (EventText& event : said.events) event.request->result = "cancelled";
}

void event_says_done(Said& said) {
  for (EventText& event : said.events) event.code = EventCode("request_done");
}

void entry_says_done(Said& said) {
  for (JournalEntry& entry : said.entries) entry.event = "request_done";
}

void reply_is_cancelled(Said& said) {
  said.code = gateway_REPLY_CANCELLED;
}

void reply_is_refused(Said& said) {
  said.code = gateway_REPLY_REFUSED;
}

void reply_is_slave_lost(Said& said) {
  said.code = gateway_REPLY_SLAVE_LOST;
}

void reply_is_no_answer(Said& said) {
  said.code = gateway_REPLY_NO_ANSWER;
}

void reason_says_not_sent(Said& said) {
  said.reason = "the value was not sent";
}

void ends_as_cancelled(Said& said) {
  said.exit_status = 7;
}

void ends_as_done(Said& said) {
  said.exit_status = 0;
}

void has_no_entry(Said& said) {
  said.entries.clear();
}

void has_no_event(Said& said) {
  said.events.clear();
}

/// What only reads has an entry, too.
class EntryOfRead final : public Tamper {
 public:
  void said(Said& said) override {
    if (said.entries.empty() && said.code == gateway_REPLY_DONE)
      said.entries.push_back({"request_done", {{"CANSYNC_RESULT", "done"}}});
  }
};

class EntryOfAnotherParameter final : public Tamper {
 public:
  void said(Said& said) override {
    if (of_write(said)) set_field(said.entries.front(), "PARAMETER", "7");
  }
};

class UncountedRefusals final : public Tamper {
 public:
  void said(Said& said) override {
    if (said.code != gateway_REPLY_REFUSED) return;
    said.entries.clear();
    said.events.clear();
  }
};

class EventOfAnotherValue final : public Tamper {
 public:
  void said(Said& said) override {
    if (!said.events.empty()) said.events.front().request->new_value += "0";
  }
};

/// A control word or broadcast ends otherwise than it did.
template <cansync::Outcome kFrom, cansync::Outcome kTo>
class WrongEndOfCommand final : public Tamper {
 public:
  void terminals(std::vector<Terminal>& popped) override {
    for (Terminal& terminal : popped) {
      auto* const done = std::get_if<CommandDone>(&terminal);
      if (done != nullptr && done->outcome == kFrom) done->outcome = kTo;
    }
  }
};

/// A write that was not sent is one of which nothing is known.
class TimidCancel final : public Tamper {
 public:
  void terminals(std::vector<Terminal>& popped) override {
    for (Terminal& terminal : popped) {
      auto* const done = std::get_if<ParameterDone>(&terminal);
      if (done != nullptr && done->result.outcome == cansync::Outcome::cancelled)
        done->result.outcome = cansync::Outcome::no_answer;
    }
  }
};

/// The audit trail does not keep what was written, and names the value before that.
class ForgetsWrites final : public Tamper {
 public:
  bool remembers(const Request& request) override {
    const auto* parameter = std::get_if<cansync::ParameterRequest>(&request);
    return parameter == nullptr || !parameter->write;
  }
};

template <class T>
std::unique_ptr<Tamper> make(const Plan& /*plan*/) {
  return std::make_unique<T>();
}

template <gateway_ReplyCode kCode, void (*change)(Said&)>
constexpr auto says = &make<SaysOfCode<kCode, change>>;

template <cansync::Outcome kFrom, cansync::Outcome kTo>
constexpr auto ends = &make<WrongEndOfCommand<kFrom, kTo>>;

using cansync::Outcome;

constexpr Mutant kMutants[] = {
    {"journal calls no answer cancelled", kWords, says<gateway_REPLY_NO_ANSWER, &journal_says_cancelled>},
    {"journal calls cancelled no answer", kWords, says<gateway_REPLY_CANCELLED, &journal_says_no_answer>},
    {"journal says what means nothing", kWords, says<gateway_REPLY_DONE, &journal_says_what_means_nothing>},
    {"event calls no answer cancelled", kWords, says<gateway_REPLY_NO_ANSWER, &event_says_cancelled>},
    {"event of a slave error is that of done", kWords, says<gateway_REPLY_SLAVE_ERROR, &event_says_done>},
    {"entry of a slave error is that of done", kWords, says<gateway_REPLY_SLAVE_ERROR, &entry_says_done>},
    {"reply calls no answer cancelled", kWords, says<gateway_REPLY_NO_ANSWER, &reply_is_cancelled>},
    {"reply calls no answer refused", kWords, says<gateway_REPLY_NO_ANSWER, &reply_is_refused>},
    {"reply calls done slave lost", kWords, says<gateway_REPLY_DONE, &reply_is_slave_lost>},
    {"reply calls refused no answer", kWords, says<gateway_REPLY_REFUSED, &reply_is_no_answer>},
    {"reason calls no answer not sent", kWords, says<gateway_REPLY_NO_ANSWER, &reason_says_not_sent>},
    {"exit status calls no answer cancelled", kWords, says<gateway_REPLY_NO_ANSWER, &ends_as_cancelled>},
    {"exit status calls a slave error done", kWords, says<gateway_REPLY_SLAVE_ERROR, &ends_as_done>},
    {"a write that was not sent may be there", kWords, &make<TimidCancel>},
    {"a word that was sent is called cancelled", kWords, ends<Outcome::done, Outcome::cancelled>},
    {"a word that was sent is called replaced", kWords, ends<Outcome::done, Outcome::replaced>},
    {"a word that was replaced is called done", kWords, ends<Outcome::replaced, Outcome::done>},
    {"a word that was not sent may be there", kWords, ends<Outcome::cancelled, Outcome::no_answer>},
    {"no entry of a write that failed", kEntry, says<gateway_REPLY_SLAVE_ERROR, &has_no_entry>},
    {"no event of a change", kEntry, says<gateway_REPLY_DONE, &has_no_event>},
    {"entry of what only reads", kEntry, &make<EntryOfRead>},
    {"entry of another parameter", kEntry, &make<EntryOfAnotherParameter>},
    {"refusals that nobody counts", kEntry, &make<UncountedRefusals>},
    {"event of another value", kEntry, &make<EventOfAnotherValue>},
    {"old value before", kBefore, &make<ForgetsWrites>},
};

}  // namespace

std::span<const Mutant> word_mutants() noexcept {
  return kMutants;
}

}  // namespace cansyncd::campaign
