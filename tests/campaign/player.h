#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "coverage.h"
#include "daemon/cansync/exchange.h"
#include "dice.h"
#include "ledger.h"
#include "memory_truth.h"
#include "parameter_truth.h"
#include "plan.h"
#include "recovery.h"
#include "sim/line.h"
#include "tamper.h"
#include "witness.h"
#include "word_truth.h"
#include "writers.h"

namespace cansyncd::campaign {

/// What the player works with; all of it outlives the player.
struct Stage {
  const Plan& plan;
  Exchange& exchange;
  sim::Line& line;
  Witness& witness;
  Ledger& ledger;
  ParameterTruth& parameters;
  MemoryTruth& memories;
  WordTruth& words;
  Recovery& recovery;
  Coverage& coverage;
  Tamper* tamper;  ///< null: none
  std::function<void(const std::string&)>
      tell;  ///< told every request and reply; empty: nobody wants to know
};

/// Plays gateway, clients and operator of a schedule.
class Player {
 public:
  explicit Player(const Stage& stage);

  /// Reads answers and reports. A gateway that hangs does not.
  void read(bool whatever_happens = false);

  /// What clients and operator do between the interval that has just ended and the next one.
  void act(std::uint64_t tick, const MasterSnapshot& now);

  /// The realtime thread has told which reference mapping is in force.
  void learn_mapping(std::uint64_t number) noexcept { mapping_number_ = number; }

  /// Between two telegrams: a request may come at any time.
  void moment();

  /// The gateway neither reads nor writes.
  bool hangs() const noexcept;

  /// The loop has ended: what it has not begun is answered here.
  void take_back();

 private:
  static constexpr unsigned kClients = 4;

  bool over() const noexcept { return stage_.recovery.phase() != Recovery::Phase::faults; }
  bool push(const Request& request, const Job* job, const std::string& text);
  void answered(const Terminal& terminal);
  void settle(const Job& job, const Terminal& terminal);
  void settle_words(const Job& job, const Terminal& terminal);
  void settle_parameter(const Job& job, const Terminal& terminal);
  void settle_transfer(const Job& job, const Terminal& terminal);
  sim::Drive* drive_of(cansync::SlaveNumber slave);

  // clients
  void ask(std::uint64_t tick);
  void ask_parameter();
  void ask_transfer();
  bool taken_soon() const noexcept;
  void ask_control_word();
  void ask_stop_word();
  void hand_on_held_back();
  void ask_broadcast();
  void ask_setting();
  void ask_mode();
  void cancel_one();
  void depart();
  void burst();
  cansync::SlaveNumber any_slave();
  Job new_job(Job::Kind kind);
  void command(const Job& job, const Request& request, const std::string& text);

  // the writers of reference values
  void live_writers(const MasterSnapshot& now);
  void write_references(const MasterSnapshot& now, bool steady);
  void withdraw();

  // the operator
  void operate(std::uint64_t tick, const MasterSnapshot& now);
  void mend(std::uint64_t tick, const MasterSnapshot& now);
  void probe(std::uint64_t tick);
  void ask_for_mode(Mode mode, bool force);

  Stage stage_;
  Dice dice_;
  std::vector<Terminal> popped_;
  unsigned writer_ = 0;                                    ///< client that writes reference values
  std::uint64_t writer_back_ = 0;                          ///< it is gone until this interval
  std::uint64_t mapping_number_ = 1;                       ///< as last told
  cansync::State state_ = cansync::State::start_up;        ///< likewise
  std::array<bool, cansync::kChannels> withdrawing_ = {};  ///< there was no room for it yet
  std::unique_ptr<Writers> writers_;                       ///< null: there is one, and no gate
  std::vector<std::pair<std::uint64_t, cansync::ControlWordRequest>> held_back_;  ///< by a tamper, until when
  std::set<cansync::JobId> mode_jobs_;
  std::set<cansync::JobId> probes_;
  std::size_t next_probe_ = 0;
  bool probes_well_ = true;
  bool cursors_reset_ = false;
  unsigned limits_lifted_ = 0;     ///< telegrams of which the limits were lifted
  std::uint64_t hung_ = 0;         ///< intervals
  std::uint64_t reset_again_ = 0;  ///< not before this tick
};

}  // namespace cansyncd::campaign
