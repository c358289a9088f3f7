// The fault campaign of the slave's role: a real master against the slave's core, with faults, jobs,
// transfers and an application that dies and comes back, all by chance. CANSYNC_SLAVE_SEEDS says how many
// courses there are; the same seed gives the same course. Mutants of the slave break the invariants, and have
// to be found.
#include <gtest/gtest.h>

#include <cstdlib>
#include <deque>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "slave_line_rig.h"

namespace sim::test {
namespace {

using cansync::BlockEnd;
using cansync::Outcome;
using cansync::ParameterFormat;

enum class Mutant : std::uint8_t {
  none,
  releases_twice,          ///< the values of the interval before again
  releases_older,          ///< not the newest values but those of the interval before
  sends_late,              ///< whatever the slot
  applies_every_question,  ///< a write is applied again while the master waits for its answer
  hides_the_death,         ///< the service does not learn that its application is gone
};

/// Looks at the bus itself: the judge's rules, and which released value each RDC1 carries.
class Witness final : public TraceSink {
 public:
  explicit Witness(SlotJudge& judge) : judge_(judge) {}
  void sync(can::Time at) noexcept override { judge_.sync(at); }
  void frame(const TracedFrame& traced) noexcept override {
    judge_.frame(traced);
    if (traced.frame.id != 0x305) return;
    ++count;
    const auto& data = traced.frame.data;
    const std::uint32_t value = data[0] | (std::uint32_t{data[1]} << 8) | (std::uint32_t{data[2]} << 16);
    if (value != node->actual[0])
      wrong.push_back("value " + std::to_string(value) + " is older than its release");
    if (!seen_.insert(value).second) wrong.push_back("value " + std::to_string(value) + " was sent twice");
  }

  const SlaveNode* node = nullptr;
  std::vector<std::string> wrong;
  unsigned count = 0;

 private:
  SlotJudge& judge_;
  std::set<std::uint32_t> seen_;
};

/// What a campaign has come to, so that it cannot be green by doing nothing.
struct Totals {
  unsigned sent = 0, late = 0, answered = 0, dropped = 0, blocks_done = 0, blocks_ended = 0, faults_hit = 0;
};

class Course {
 public:
  Course(std::uint64_t seed, Mutant mutant)
      : mutant_(mutant), dice_(seed), line_(static_cast<BitRate>(seed % 4)), witness_(line_.judge) {
    line_.master_settings.master.startup.enable = cansync::EnableRule::any;
    line_.under_test.supervision.lock_time = line_.times.interval * 5;
    line_.under_test.service.area.area = chance(50);
    line_.under_test.service.area.monitoring = line_.times.interval * 60;
    line_.under_test.delay = line_.times.bit_time() * static_cast<int>(below(chance(20) ? 260 : 120));
    with_parameters(line_);
    line_.line_settings.seed = seed;
    line_.line_settings.trace = &witness_;
    for (unsigned n = below(6); n > 0; --n) add_fault();
    line_.build();
    witness_.node = &line_.slave();
    line_.slave().sends_late = mutant == Mutant::sends_late;
    line_.slave().releases_older = mutant == Mutant::releases_older;
    line_.slave().application = [this](SlaveNode& node) { application(node); };
    turn_application(true);
  }

  /// Runs the course; what was wrong.
  std::vector<std::string> run(Totals& totals) {
    for (unsigned interval = 0; interval < 250; ++interval) {
      if (chance(15)) submit_parameter();
      if (chance(5)) submit_transfer();
      if (chance(3)) turn_application(!present_);
      line_.run();
    }
    finish();
    totals.sent += static_cast<unsigned>(line_.one().sent);
    totals.late += static_cast<unsigned>(line_.one().late);
    totals.answered += line_.slave().jobs_answered;
    totals.dropped += line_.slave().jobs_dropped;
    totals.blocks_done += line_.slave().ends[BlockEnd::done];
    for (const auto& [end, times] : line_.slave().ends) totals.blocks_ended += times;
    for (std::size_t i = 0; i < line_.line().faults().size(); ++i)
      totals.faults_hit += static_cast<unsigned>(line_.line().faults().hits(i));
    return witness_.wrong;
  }

 private:
  unsigned below(unsigned limit) { return static_cast<unsigned>(dice_() % limit); }
  bool chance(unsigned percent) { return below(100) < percent; }
  void say(const std::string& what) { witness_.wrong.push_back(what); }

  void add_fault() {
    // An answer that was on the bus and that the master did not see is asked for again, and counts as another
    // write (bit 6 is cleared); `silent` keeps answers off the bus.
    constexpr std::uint32_t kChannels[] = {0x010, 0x100, 0x180, 0x300, 0x500, 0x500};
    constexpr FaultKind kKinds[] = {FaultKind::lost, FaultKind::lost, FaultKind::missing_sync,
                                    FaultKind::silent};
    Fault fault;
    fault.kind = kKinds[below(4)];
    fault.from = 20 + below(150);
    fault.to = fault.from + below(fault.kind == FaultKind::silent ? 30 : 80);
    fault.probability = 0.05 + 0.01 * below(60);
    if (fault.kind == FaultKind::lost) {
      fault.identifier = kChannels[below(6)];
      fault.mask = cansync::identifier::channel_bits;
    } else {
      fault.node = NodeNumber{5};
    }
    line_.line_settings.faults.push_back(fault);
  }

  void submit_parameter() {
    constexpr unsigned kNumbers[] = {400, 401, 402, 500, 500, 4095, 999};
    auto request = line_.request(kNumbers[below(7)]);
    if (request.number.value() == 500 && chance(60)) {
      request.write = true;
      request.format = ParameterFormat::doubleword;
      request.value = ++written_;
    }
    request.monitoring_time = line_.times.interval * 40;
    if (line_.master().submit(request) == cansync::Refusal::none) parameters_.push_back(request.id);
    if (!parameters_.empty() && chance(10)) line_.master().cancel(parameters_.back());
  }
  void submit_transfer() {
    data_.push_back(bytes_of(1 + below(400)));
    auto request = line_.transfer(true, data_.back());
    request.monitoring_time = line_.times.interval * 100;
    if (line_.master().submit(request) == cansync::Refusal::none) transfers_.push_back(request.id);
    if (!transfers_.empty() && chance(20)) line_.master().cancel(transfers_.back());
  }
  void turn_application(bool present) {
    present_ = present;
    if (present || mutant_ != Mutant::hides_the_death) line_.slave().service.set_application(present);
  }

  /// Once in each interval, behind the slave: releases a value, and answers now or later.
  void application(SlaveNode& node) {
    if (mutant_ != Mutant::releases_twice || chance(80)) node.actual[0] = ++released_;
    if (!present_) return;
    if (node.parameter) answer(node);
    if (node.block && chance(70)) move_(node);
  }
  void answer(SlaveNode& node) {
    const bool now = chance(50);
    if (!now && mutant_ != Mutant::applies_every_question) return;
    const cansync::AskedParameter job = *node.parameter;
    if (job.write) values_[job.id] = job.value;
    if (job.write && !applied_.insert(job.value).second)
      say("the value " + std::to_string(job.value) + " twice");
    if (!now) return;
    node.parameter.reset();
    if (!node.service.jobs().answer(job.id,
                                    {false, cansync::ParameterError::none, job.number.value() == 500, 7}))
      say("access " + std::to_string(job.id) + " took no answer, and nobody dropped it");
  }

  void finish() {
    turn_application(false);
    if (const auto& open = line_.slave().service.jobs().open(); open && open->id != 0)
      if (line_.slave().parameter)
        say("a dead application leaves access " + std::to_string(open->id) + " open");
    if (line_.slave().service.area().open().id != 0) say("a dead application leaves a block open");
    static_cast<void>(line_.slave().slave.control(cansync::ControlCommand::cold_restart));
    line_.master().control(cansync::ControlCommand::cold_restart);
    if (line_.slave().service.jobs().open()) say("an access outlives synchronous operation");
    for (const auto id : parameters_)
      if (!line_.ends.parameters.contains(id)) say("parameter job " + std::to_string(id) + " never ended");
    for (const auto id : transfers_)
      if (!line_.ends.transfers.contains(id)) say("transfer " + std::to_string(id) + " never ended");
    for (const auto& [id, times] : line_.slave().told)
      if (times != 1) say("access " + std::to_string(id) + " ended " + std::to_string(times) + " times");
    for (const std::string& what : line_.judge.wrong) say(what);
    line_.judge.wrong.clear();
    line_.slave().told.clear();
  }

  Mutant mutant_;
  std::mt19937_64 dice_;
  SlaveLine line_;
  Witness witness_;
  std::vector<cansync::JobId> parameters_;
  std::vector<cansync::JobId> transfers_;
  std::deque<std::vector<std::uint8_t>> data_;
  std::vector<std::uint8_t> memory_;
  std::function<void(SlaveNode&)> move_ = moves_blocks(memory_);
  std::set<std::uint32_t> applied_;
  std::map<std::uint64_t, std::uint32_t> values_;  ///< of writes, by access
  std::uint32_t released_ = 0;
  std::uint32_t written_ = 0;
  bool present_ = true;
};

unsigned seeds() {
  const char* given = std::getenv("CANSYNC_SLAVE_SEEDS");  // NOLINT(concurrency-mt-unsafe): one thread
  return given == nullptr ? 200u : static_cast<unsigned>(std::strtoul(given, nullptr, 10));
}

TEST(SlaveCampaign, S16S20S23NothingTwiceNothingLateNothingLeftOpen) {
  Totals totals;
  for (unsigned seed = 1; seed <= seeds(); ++seed) {
    for (const std::string& what : Course(seed, Mutant::none).run(totals))
      ADD_FAILURE() << "seed " << seed << ": " << what;
  }
  EXPECT_GT(totals.sent, 100 * seeds());
  EXPECT_GT(totals.late, seeds());
  EXPECT_GT(totals.answered, 3 * seeds());
  EXPECT_GT(totals.dropped, seeds() / 10);
  EXPECT_GT(totals.blocks_done, seeds() / 10);
  EXPECT_GT(totals.blocks_ended - totals.blocks_done, seeds() / 2);
  EXPECT_GT(totals.faults_hit, 10 * seeds());
  RecordProperty("sent", static_cast<int>(totals.sent));
}

TEST(SlaveCampaign, S16S20FindsEveryMutant) {
  for (const Mutant mutant : {Mutant::releases_twice, Mutant::releases_older, Mutant::sends_late,
                              Mutant::applies_every_question, Mutant::hides_the_death}) {
    Totals totals;
    unsigned found = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) found += Course(seed, mutant).run(totals).empty() ? 0 : 1;
    EXPECT_GT(found, 3u) << "mutant " << static_cast<unsigned>(mutant);
  }
}

}  // namespace
}  // namespace sim::test
