// Courses through a cluster of three levels, with answers and telegrams lost, late and doubled by chance on each
// bus: what the master at the top says of each job is compared with what the slaves have taken.
// CANSYNC_CLUSTER_SEEDS says how many courses there are, CANSYNC_CLUSTER_SEED which is the first; the same seed gives
// the same course. Mutants say what is
// not so, and have to be found.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "cluster_rig.h"

namespace sim::test {
namespace {

using cansync::Outcome;
using cansync::ParameterError;

enum class TruthMutant : std::uint8_t {
  none,
  invents_done,     ///< no answer is called done
  calls_cancelled,  ///< no answer is called cancelled
  calls_not_there,  ///< "not known" of a gateway is called "not available now", which says that nothing was written
  refuses_done,      ///< what was done is called an error of the slave
  reads_old_values,  ///< a value is read that was there before
  forgets_answers,   ///< a write that comes again is written again
  crosses_routes,    ///< two participants changed places in the table
  invents_blocks,    ///< a block without an answer is called done
};

struct TruthTotals {
  unsigned done = 0, nothing = 0, not_known = 0, reads = 0, blocks = 0, late = 0, lost = 0, doubled = 0;
};

/// What is said of a write.
enum class Says : std::uint8_t { has, has_not, not_known };

/// The table of this test, beside that of the program. A gateway answers 0xFFFF for what it does not know.
Says says(Outcome outcome, ParameterError error) {
  switch (outcome) {
    case Outcome::done:
      return Says::has;
    case Outcome::slave_error:
      return error == ParameterError::unspecified ? Says::not_known : Says::has_not;
    case Outcome::cancelled:
    case Outcome::master_stopped:
    case Outcome::slave_lost:
    case Outcome::word_expected:
    case Outcome::doubleword_expected:
    case Outcome::value_too_wide:
      return Says::has_not;
    default:
      return Says::not_known;
  }
}

class TruthCourse {
 public:
  TruthCourse(std::uint64_t seed, TruthMutant mutant)
      : dice_(seed * 977 + 3), mutant_(mutant), net_(static_cast<BitRate>(seed % 4), 8, 3) {
    const can::Time interval = net_.times.interval;
    net_.master.master.startup.enable = cansync::EnableRule::any;
    for (ClusterNodeSettings* gateway : {&net_.a, &net_.b}) {
      gateway->cluster.lower.startup.enable = cansync::EnableRule::any;
      gateway->lock_time = interval * 5;
      gateway->holdover = interval * 30;
      gateway->greatest_step = interval / 1000;
      gateway->cluster.gateway.asker_gone = interval * 100;
      gateway->cluster.gateway.transfer_gone = interval * 300;
      gateway->cluster.gateway.remembers_writes = mutant != TruthMutant::forgets_answers;
    }
    // Shorter on each level, or nobody learns why a job failed.
    net_.a.cluster.gateway.monitoring = interval * 60;
    net_.b.cluster.gateway.monitoring = interval * 30;
    if (mutant == TruthMutant::crosses_routes)
      std::swap(net_.b.cluster.gateway.routes[0].slave, net_.b.cluster.gateway.routes[1].slave);
    for (LineSettings* line : {&net_.top, &net_.middle_line, &net_.lowest_line}) line->seed = seed;
    // An answer that was on the bus and did not come is asked for again, and its write is another one once there
    // was a busy answer. In calm courses none is lost but those of slaves that are never busy.
    calm_ = chance(40);
    busy_percent_ = calm_ ? 0 : below(40);
    slow_percent_ = chance(60) ? 5 + below(25) : 0;
    net_.build();
    for (auto* level : {&net_.middle, &net_.lowest}) {
      for (LeafSlave* slave : *level) {
        if (slave == nullptr) continue;
        slave->record = false;
        slave->busy = [this] { return chance(busy_percent_) ? below(10) : 0; };
      }
    }
  }
  // Late telegrams are not in their slots.
  ~TruthCourse() { net_.judge.wrong.clear(); }
  TruthCourse(const TruthCourse&) = delete;
  TruthCourse& operator=(const TruthCourse&) = delete;

  std::vector<std::string> run(TruthTotals& totals) {
    if (!net_.run_until([this] { return net_.all_active(); }, 3000)) say("it did not start");
    for (Line* line : {net_.top_bus.get(), net_.middle_bus.get(), net_.lowest_bus.get()}) {
      for (unsigned n = 1 + below(4); n > 0; --n) add_fault(*line);
    }
    for (ClusterNode* gateway : {net_.gateway_a, net_.gateway_b})
      gateway->slow = [this] { return chance(slow_percent_) ? net_.times.interval : can::Time{}; };
    for (unsigned interval = 0; interval < kCourse; ++interval) {
      if (chance(25)) submit_write();
      if (chance(10)) submit_read();
      if (chance(2)) submit_download();
      if (chance(4)) cancel_one();
      net_.run();
      judge_ended();
    }
    const auto all_ended = [this] {
      return net_.ends.parameters.size() >= writes_.size() + reads_.size() &&
             net_.ends.transfers.size() >= blocks_.size();
    };
    if (!net_.run_until(all_ended, 6000)) say("a job never ended");
    judge_ended();
    net_.run(kAfterwards);  // what is late comes, too
    judge(totals);
    count_faults(totals);
    return wrong_;
  }

 private:
  static constexpr unsigned kCourse = 250;
  static constexpr unsigned kAfterwards = 150;
  /// An answer that is later than this is none of the course.
  static constexpr unsigned kLatest = 12;

  struct Write {
    std::uint16_t number = 0;
    std::uint16_t parameter = 0;
    std::uint32_t value = 0;
    bool read = false;        ///< there is a read of it
    std::uint64_t ended = 0;  ///< intervals of the line before
    Says says = Says::not_known;
  };
  struct Read {
    std::size_t write = 0;  ///< which it reads
    bool before = false;    ///< the value may be the one before the write
    bool after = false;     ///< the value may be that of the write
  };
  struct Block {
    std::uint16_t number = 0;
    std::uint32_t address = 0;
    std::size_t data = 0;
  };

  unsigned below(unsigned limit) { return static_cast<unsigned>(dice_() % limit); }
  bool chance(unsigned percent) { return below(100) < percent; }
  void say(const std::string& what) {
    if (wrong_.size() < 10) wrong_.push_back(what);
  }

  void add_fault(Line& line) {
    using namespace cansync;
    const bool lowest = &line == net_.lowest_bus.get();
    Fault fault;
    fault.from = line.intervals() + below(kCourse);
    fault.to = fault.from + below(120);
    fault.probability = 0.05 + 0.01 * below(50);
    fault.identifier = identifier::response;
    fault.mask = identifier::channel_bits;
    const unsigned kind = below(calm_ && !lowest ? 2 : 6);
    if (kind == 0) {
      fault.kind = FaultKind::lost;  // of telegrams and process data
      constexpr std::uint32_t kOthers[] = {identifier::command, identifier::reference_one,
                                           identifier::actual_one};
      fault.identifier = kOthers[below(3)];
    } else if (kind == 1) {
      fault.kind = FaultKind::duplicated;
    } else if (kind == 2 || kind == 3) {
      fault.kind = FaultKind::lost;
    } else if (kind == 4) {
      fault.kind = FaultKind::late;
      fault.delay = net_.times.interval * (1 + below(2));  // docs/cansync-protocol.md: up to two
    } else {
      fault.kind = FaultKind::silent;
      const unsigned gateway = &line == net_.top_bus.get() ? kGatewayA : kGatewayB;
      fault.node = static_cast<NodeNumber>(lowest ? below(3) : gateway);
      fault.to = fault.from + below(40);
      fault.probability = 1;
      fault.identifier = fault.mask = 0;
    }
    line.faults().add(fault);
    faults_.push_back({&line, line.faults().size() - 1, fault.kind});
  }

  std::uint16_t somebody() {
    return static_cast<std::uint16_t>(chance(75) ? kLowest + below(3) : kMiddle + below(3));
  }
  /// Each parameter is written once in a course, so that an answer that is late or doubled is no other's.
  void submit_write() {
    Write write;
    write.number = somebody();
    write.parameter = static_cast<std::uint16_t>(701 + 2 * writes_.size());
    write.value = 0x20000 + static_cast<std::uint32_t>(writes_.size());
    auto request = net_.write(write.number, write.parameter, write.value);
    request.monitoring_time = net_.times.interval * 90;
    if (net_.upper_master().submit(request) != cansync::Refusal::none) return;
    write_ids_[request.id] = writes_.size();
    writes_.push_back(write);
    newest_ = request.id;
  }
  /// Of a write that has ended so long ago that no answer of it is under way.
  void submit_read() {
    const std::uint64_t now = net_.top_bus->intervals();
    const auto ready = std::ranges::find_if(writes_, [&](const Write& write) {
      return !write.read && write.ended != 0 && write.ended + kLatest < now;
    });
    if (ready == writes_.end()) return;
    ready->read = true;
    const auto request = net_.read(ready->number, ready->parameter);
    if (net_.upper_master().submit(request) != cansync::Refusal::none) return;
    const auto which = static_cast<std::size_t>(ready - writes_.begin());
    reads_[request.id] = {which, ready->says != Says::has, ready->says != Says::has_not};
    newest_ = request.id;
  }
  void submit_download() {
    Block block;
    block.number = somebody();
    block.data = data_.size();
    block.address = 0x1000 + 0x400 * static_cast<std::uint32_t>(block.data);
    data_.push_back(bytes_of(1 + below(150)));
    auto request = net_.transfer(block.number, true, data_.back(), block.address);
    request.monitoring_time = net_.times.interval * 250;
    if (net_.upper_master().submit(request) != cansync::Refusal::none) return;
    blocks_[request.id] = block;
    newest_ = request.id;
  }
  void cancel_one() {
    static_cast<void>(net_.upper_master().cancel(chance(60) ? newest_ : 1 + dice_() % newest_));
  }

  /// What the master says, in the words of a mutant.
  cansync::ParameterResult said(const cansync::ParameterResult& result, bool write) const {
    cansync::ParameterResult said = result;
    const bool unknown = result.outcome == Outcome::no_answer || result.outcome == Outcome::taken;
    if (mutant_ == TruthMutant::invents_done && unknown) said.outcome = Outcome::done;
    if (mutant_ == TruthMutant::calls_cancelled && unknown) said.outcome = Outcome::cancelled;
    if (mutant_ == TruthMutant::calls_not_there && result.error == ParameterError::unspecified)
      said.error = ParameterError::not_available_now;
    if (mutant_ == TruthMutant::refuses_done && write && result.outcome == Outcome::done) {
      said.outcome = Outcome::slave_error;
      said.error = ParameterError::not_changeable;
    }
    return said;
  }
  void judge_ended() {
    for (const auto& [id, index] : write_ids_) {
      Write& write = writes_[index];
      if (write.ended != 0 || !net_.ends.parameters.contains(id)) continue;
      const cansync::ParameterResult result = said(net_.ends.parameters[id], true);
      write.ended = net_.top_bus->intervals();
      write.says = says(result.outcome, result.error);
      const std::size_t applied = applied_of(write);
      if (write.says == Says::has && applied == 0) say(text(write) + " is done, and not there");
      if (write.says == Says::has_not && applied != 0)
        say(text(write) + " is not there by its reply, and is");
    }
  }
  static std::string text(const Write& write) {
    return "parameter " + std::to_string(write.parameter) + " of " + std::to_string(write.number);
  }
  std::size_t applied_of(const Write& write) {
    const auto& applied = net_.of(write.number).applied;
    return static_cast<std::size_t>(std::ranges::count(applied, std::pair(write.parameter, write.value)));
  }

  void judge(TruthTotals& totals) {
    std::size_t in_place = 0;
    for (const Write& write : writes_) {
      const std::size_t applied = applied_of(write);
      in_place += applied;
      if (write.says == Says::has_not && applied != 0)
        say(text(write) + " is not there by its reply, and came");
      if (calm_ && applied > 1) say(text(write) + " was written twice");
      ++(write.says == Says::has       ? totals.done
         : write.says == Says::has_not ? totals.nothing
                                       : totals.not_known);
    }
    std::size_t applied = 0;
    for (const auto* level : {&net_.middle, &net_.lowest})
      for (const LeafSlave* slave : *level)
        if (slave != nullptr) applied += slave->applied.size();
    if (applied != in_place) say("a value is elsewhere");
    for (const auto& [id, read] : reads_) judge_read(read, said(net_.ends.parameters[id], false), totals);
    for (const auto& [id, block] : blocks_) judge_block(block, net_.ends.transfers[id].outcome, totals);
  }
  void judge_read(const Read& read, const cansync::ParameterResult& result, TruthTotals& totals) {
    if (result.outcome != Outcome::done) return;
    ++totals.reads;
    const Write& write = writes_[read.write];
    const std::uint32_t before = LeafSlave::initial(write.number, write.parameter);
    const std::uint32_t value = mutant_ == TruthMutant::reads_old_values ? before : result.value;
    const bool right = (read.before && value == before) || (read.after && value == write.value);
    if (!right) say(text(write) + " was read as " + std::to_string(value));
  }
  void judge_block(const Block& block, Outcome outcome, TruthTotals& totals) {
    const auto& memory = net_.of(block.number).memory;
    const auto found = memory.find(block.address);
    if (mutant_ == TruthMutant::invents_blocks && outcome == Outcome::no_answer) outcome = Outcome::done;
    const bool nothing = outcome == Outcome::cancelled || outcome == Outcome::master_stopped ||
                         outcome == Outcome::slave_lost || outcome == Outcome::timeout;
    if (nothing && found != memory.end()) say("a block is there of which nothing was sent");
    if (outcome != Outcome::done) return;
    ++totals.blocks;
    if (found == memory.end() || found->second != data_[block.data]) say("a block is done, and not there");
  }
  void count_faults(TruthTotals& totals) {
    for (const auto& [line, index, kind] : faults_) {
      const auto hits = static_cast<unsigned>(line->faults().hits(index));
      if (kind == FaultKind::lost) totals.lost += hits;
      if (kind == FaultKind::late) totals.late += hits;
      if (kind == FaultKind::duplicated) totals.doubled += hits;
    }
  }

  struct GivenFault {
    Line* line;
    std::size_t index;
    FaultKind kind;
  };

  std::mt19937_64 dice_;
  TruthMutant mutant_;
  Levels net_;
  bool calm_ = false;
  unsigned busy_percent_ = 0;
  unsigned slow_percent_ = 0;
  std::vector<GivenFault> faults_;
  std::vector<Write> writes_;
  std::map<cansync::JobId, std::size_t> write_ids_;
  std::map<cansync::JobId, Read> reads_;
  std::map<cansync::JobId, Block> blocks_;
  std::deque<std::vector<std::uint8_t>> data_;
  cansync::JobId newest_ = 1;
  std::vector<std::string> wrong_;
};

unsigned truth_number(const char* name, unsigned otherwise) {
  const char* given = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): one thread
  return given == nullptr ? otherwise : static_cast<unsigned>(std::strtoul(given, nullptr, 10));
}

TEST(ClusterTruth, K13WhatIsSaidAtTheTopIsWhatTheSlavesHave) {
  TruthTotals totals;
  const unsigned seeds = truth_number("CANSYNC_CLUSTER_SEEDS", 300);
  const unsigned first = truth_number("CANSYNC_CLUSTER_SEED", 1);
  for (unsigned seed = first; seed < first + seeds; ++seed) {
    for (const std::string& what : TruthCourse(seed, TruthMutant::none).run(totals))
      ADD_FAILURE() << "seed " << seed << ": " << what;
  }
  RecordProperty("done", static_cast<int>(totals.done));
  RecordProperty("nothing", static_cast<int>(totals.nothing));
  RecordProperty("not known", static_cast<int>(totals.not_known));
  if (seeds < 60) return;  // too few to say how much they tried
  EXPECT_GT(totals.done, 5 * seeds);
  EXPECT_GT(totals.nothing, seeds / 2);
  EXPECT_GT(totals.not_known, seeds);
  EXPECT_GT(totals.reads, seeds);
  EXPECT_GT(totals.blocks, seeds / 4);
  EXPECT_GT(totals.lost, 5 * seeds);
  EXPECT_GT(totals.late, seeds / 2);
  EXPECT_GT(totals.doubled, 2 * seeds);
}

TEST(ClusterTruth, K13FindsEveryMutant) {
  struct Expected {
    TruthMutant mutant;
    const char* what;
  };
  constexpr Expected kMutants[] = {
      {TruthMutant::invents_done, "is done, and not there"},
      {TruthMutant::calls_cancelled, "is not there by its reply"},
      {TruthMutant::calls_not_there, "is not there by its reply"},
      {TruthMutant::refuses_done, "is not there by its reply"},
      {TruthMutant::reads_old_values, "was read as"},
      {TruthMutant::forgets_answers, "was written twice"},
      {TruthMutant::crosses_routes, "is done, and not there"},
      {TruthMutant::crosses_routes, "a value is elsewhere"},
      {TruthMutant::invents_blocks, "a block is done, and not there"},
  };
  for (const auto& [mutant, what] : kMutants) {
    TruthTotals totals;
    bool found = false;
    for (unsigned seed = 1; seed <= 60 && !found; ++seed) {
      const auto wrong = TruthCourse(seed, mutant).run(totals);
      found = std::ranges::any_of(
          wrong, [words = what](const std::string& each) { return each.find(words) != std::string::npos; });
    }
    EXPECT_TRUE(found) << "mutant " << static_cast<unsigned>(mutant) << ": " << what;
  }
}

}  // namespace
}  // namespace sim::test
