#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
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

  /// Between two telegrams: a request may come at any time.
  void moment();

  /// The loop has ended: what it has not begun is answered here.
  void take_back();

 private:
  static constexpr unsigned kClients = 4;

  bool hangs() const noexcept;
  bool over() const noexcept { return stage_.recovery.phase() != Recovery::Phase::faults; }
  bool push(const Request& request, const Job* job, const std::string& text);
  void answered(const Terminal& terminal);
  void settle(const Job& job, const Terminal& terminal);
  void settle_parameter(const Job& job, const Terminal& terminal);
  void settle_transfer(const Job& job, const Terminal& terminal);
  sim::Drive* drive_of(cansync::SlaveNumber slave);

  // clients
  void ask(std::uint64_t tick);
  void ask_parameter();
  void ask_transfer();
  void ask_control_word();
  void ask_broadcast();
  void ask_setting();
  void ask_mode();
  void cancel_one();
  void depart();
  void burst();
  cansync::SlaveNumber any_slave();
  Job new_job(Job::Kind kind);
  void command(const Job& job, const Request& request, const std::string& text);

  // the writer of reference values
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
  std::array<bool, cansync::kChannels> withdrawing_ = {};  ///< there was no room for it yet
  std::set<cansync::JobId> mode_jobs_;
  std::set<cansync::JobId> probes_;
  std::size_t next_probe_ = 0;
  bool probes_well_ = true;
  bool cursors_reset_ = false;
  std::uint64_t hung_ = 0;         ///< intervals
  std::uint64_t reset_again_ = 0;  ///< not before this tick
};

}  // namespace cansyncd::campaign
