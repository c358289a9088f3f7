#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "cansync/sim/drive.h"
#include "coverage.h"
#include "daemon/cansync/exchange.h"
#include "memory_truth.h"
#include "plan.h"
#include "sent_truth.h"
#include "tamper.h"
#include "words.h"

namespace cansyncd::campaign {

/// Compares everything that is said of a request with what the simulated drives have taken and what was on the
/// bus: reply code, reason and exit status, entry of the journal and event. The meaning of each word stands in
/// a table of its own here.
class WordTruth final : public sim::DriveWatcher {
 public:
  /// All must outlive the object. `tamper`: null for none.
  WordTruth(const Plan& plan, Exchange& exchange, SentTruth& sent, Coverage& coverage, Tamper* tamper);

  /// Follows a drive; once more after it was switched off and on.
  void powered_on(sim::Drive& drive);

  void pushed(cansync::JobId id, const Request& request);
  /// The request has ended. `memory`: of a transfer. `doubtful`: an answer may have been that to an earlier
  /// request, because the protocol cannot tell them apart.
  void ended(const Terminal& terminal, const std::optional<MemoryTruth::Facts>& memory, bool doubtful,
             cansync::State state, can::Time now);
  /// Every request has ended.
  void all_ended(can::Time now);

  /// What was wrong first, of each kind; empty: nothing.
  const std::string& wrong_word() const noexcept { return wrong_word_; }
  const std::string& wrong_entry() const noexcept { return wrong_entry_; }
  const std::string& wrong_before() const noexcept { return wrong_before_; }

  /// What is said of a request, or known of it.
  enum class Has : std::uint8_t {
    yes,        ///< the drive has had it since it was asked for; a command: it was on the bus
    no,         ///< nothing of it was sent
    refused,    ///< the drive has refused it
    not_known,  ///< it was sent
    anything,   ///< nothing is said
  };

 private:
  struct Asked {
    Request request;
    std::uint64_t sent_before = 0;          ///< telegrams with the same write
    std::uint64_t taken_before = 0;         ///< likewise, by the drive
    std::optional<std::uint32_t> replaced;  ///< value that the drive had until it took this
    std::set<std::uint32_t> held;           ///< values that the drive had since this was asked for
    bool shares = false;                    ///< another one that was open wrote the same
  };
  struct Known {
    bool sent = false;  ///< handed to the bus
    bool has = false;
    bool untouched = true;  ///< nothing of it is there
    bool certain = true;    ///< it is known at all
    bool doubtful = false;
  };
  /// A parameter of a drive.
  struct Cell {
    std::uint32_t value = 0;
    bool forgotten = false;  ///< the drive was switched off since the daemon had it
  };
  using Place = std::pair<unsigned, unsigned>;  // slave, number

  void parameter_written(cansync::SlaveNumber drive, cansync::ParameterNumber number,
                         std::uint32_t value) noexcept override;
  static std::optional<SentTruth::Write> write_of(const Request& request);
  /// Of many writes and actions, those of which no request is open: a soak asks without end.
  void forget_ended();
  Known known(const Asked& asked, const Terminal& terminal, const std::optional<MemoryTruth::Facts>& memory,
              bool doubtful);
  Known known_of_action(const cansync::ActionCommand& action, const Terminal& terminal);
  void judge_words(cansync::JobId id, const Asked& asked, const Said& said, const Known& known);
  void judge_entry(cansync::JobId id, const Asked& asked, const Said& said, const Terminal& terminal);
  void judge_before(cansync::JobId id, const Asked& asked, const Said& said, const Terminal& terminal,
                    bool doubtful);
  void learn(const Asked& asked, const Terminal& terminal);

  const Plan& plan_;
  SentTruth& sent_;
  Coverage& coverage_;
  Tamper* tamper_;
  Words words_;
  std::map<cansync::JobId, Asked> open_;
  std::map<SentTruth::Write, std::uint64_t> taken_;
  std::map<Place, Cell> cells_;
  struct Actions {
    std::uint64_t asked = 0;    ///< requests with this action
    std::uint64_t denied = 0;   ///< of which it is said that nothing was sent
    std::uint64_t done = 0;     ///< that are done
    std::uint64_t unknown = 0;  ///< of which it is said that they were handed over
  };
  std::map<SentTruth::Action, Actions> actions_;
  std::uint64_t refused_unrecorded_ = 0;
  std::string wrong_word_;
  std::string wrong_entry_;
  std::string wrong_before_;
};

}  // namespace cansyncd::campaign
