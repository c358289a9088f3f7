// The fault campaign of clusters: a real master, one or two gateways and slaves on two or three lines, with
// faults, jobs, transfers and cancels by chance. CANSYNC_CLUSTER_SEEDS says how many courses there are; the
// same seed gives the same course. Mutants break the invariants, and have to be found.
#include <gtest/gtest.h>

#include <cstdlib>
#include <deque>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "cluster_rig.h"

namespace sim::test {
namespace {

using cansync::LeadSource;
using cansync::Outcome;

enum class ClusterMutant : std::uint8_t {
  none,
  forgets_answers,    ///< a write that comes again is written again
  keeps_old_answers,  ///< a value waits for its asker for ever
  holds_values,       ///< the lead axis fills a gap with the value before
  never_stops,        ///< the lower SYNC goes on without the upper one
  repeats_below,      ///< the lower master sends a write again that was not answered
  crosses_routes,     ///< two participants changed places in the table
  speaks_unasked,     ///< an answer to nothing
};

struct ClusterTotals {
  unsigned done = 0, ended_badly = 0, transfers = 0, given = 0, missing = 0, losses = 0, faults_hit = 0;
};

constexpr std::uint16_t kCounting = 600;  ///< reads how many edges the slave has seen

struct CampaignJob {
  bool write = false;
  bool count = false;
  std::uint16_t number = 0;
  std::uint16_t parameter = 0;
  std::uint32_t value = 0;
  std::size_t edges = 0;  ///< of the slave, when it was asked
};

class ClusterCourse {
 public:
  ClusterCourse(std::uint64_t seed, ClusterMutant mutant)
      : dice_(seed), mutant_(mutant), net_(static_cast<BitRate>(seed % 4), 8, seed % 3 == 0 ? 3 : 0) {
    net_.master.master.startup.enable = cansync::EnableRule::any;
    for (ClusterNodeSettings* gateway : {&net_.a, &net_.b}) {
      gateway->cluster.lower.startup.enable = cansync::EnableRule::any;
      gateway->lock_time = net_.times.interval * 5;
      gateway->holdover = net_.times.interval * kHoldover;
      gateway->greatest_step = net_.times.interval / 1000;
      gateway->cluster.gateway.asker_gone = net_.times.interval * kAskerGone;
      gateway->cluster.gateway.monitoring = net_.times.interval * 40;
      gateway->cluster.gateway.transfer_gone = net_.times.interval * 300;
      gateway->cluster.lead[0] = {LeadSource::Kind::reference, 0, {}, true};
      gateway->cluster.lead[4] = {LeadSource::Kind::reference, 0, {}, true};
      gateway->cluster.lead[5] = {LeadSource::Kind::reference, 4, {}, true};
    }
    busy_slaves_ = chance(60);
    for (LineSettings* line : {&net_.top, &net_.middle_line, &net_.lowest_line}) line->seed = seed;
    for (unsigned n = below(6); n > 0; --n) add_fault();
    slow_percent_ = chance(50) ? 10 + below(20) : 0;
    if (!busy_slaves_ && net_.lowest_count == 0 && chance(50)) beneath_.push_back(lost_answers());
    mutate_settings();
    net_.build();
    for (auto* level : {&net_.middle, &net_.lowest}) {
      for (LeafSlave* slave : *level) {
        if (slave != nullptr && busy_slaves_) slave->busy = [this] { return chance(30) ? below(12) : 0; };
      }
    }
    net_.gateway_a->on_interval = [this](ClusterNode& node) { watch(node); };
  }

  std::vector<std::string> run(ClusterTotals& totals) {
    if (!net_.run_until([this] { return net_.all_active(); }, 3000)) say("it did not start");
    move_faults();
    for (ClusterNode* gateway : {net_.gateway_a, net_.gateway_b})
      if (gateway != nullptr)
        gateway->slow = [this] { return chance(slow_percent_) ? net_.times.interval : can::Time{}; };
    for (unsigned interval = 0; interval < kCourse; ++interval) {
      if (chance(20)) submit_parameter();
      if (chance(3)) submit_transfer();
      if (chance(3)) submit_below();
      if (chance(1)) linger();
      net_.run();
    }
    finish();
    judge_values();
    judge_references();
    judge_edges();
    for (const std::string& what : net_.judge.wrong) say(what);
    net_.judge.wrong.clear();
    for (const auto& [id, result] : net_.ends.parameters)
      ++(result.outcome == Outcome::done ? totals.done : totals.ended_badly);
    for (const auto& [id, result] : net_.ends.transfers)
      if (result.outcome == Outcome::done) ++totals.transfers;
    totals.given += static_cast<unsigned>(net_.cluster().lead().counters(Channel::two).given);
    totals.missing += static_cast<unsigned>(net_.cluster().lead().counters(Channel::two).missing);
    totals.losses += static_cast<unsigned>(net_.cluster().sync_losses());
    for (Line* line : {net_.top_bus.get(), net_.middle_bus.get()})
      for (std::size_t i = 0; i < line->faults().size(); ++i)
        totals.faults_hit += static_cast<unsigned>(line->faults().hits(i));
    return wrong_;
  }

 private:
  static constexpr unsigned kCourse = 300;
  static constexpr unsigned kHoldover = 30;
  static constexpr unsigned kAskerGone = 80;

  unsigned below(unsigned limit) { return static_cast<unsigned>(dice_() % limit); }
  bool chance(unsigned percent) { return below(100) < percent; }
  void say(const std::string& what) {
    if (wrong_.size() < 10) wrong_.push_back(what);
  }

  /// The question comes again, and must not be another job.
  Fault lost_answers() {
    Fault fault;
    fault.kind = FaultKind::lost;
    fault.identifier = 0x580;
    fault.mask = cansync::identifier::channel_bits;
    fault.probability = 0.1 + 0.01 * below(20);
    fault.to = 10'000;
    return fault;
  }
  /// Intervals are counted from the end of the start.
  void add_fault() {
    Fault fault;
    fault.from = 20 + below(200);
    fault.probability = 0.05 + 0.01 * below(50);
    // An answer of a gateway that was on the bus and did not come is asked for again, and its write is another
    // one (bit 6 is cleared). Those that are never on the bus are `slow`.
    constexpr std::uint32_t kAbove[] = {0x010, 0x100, 0x180, 0x300, 0x500};
    constexpr std::uint32_t kBelow[] = {0x010, 0x100, 0x180, 0x300, 0x500, 0x580};
    const unsigned kind = below(10);
    if (kind < 5) {
      fault.kind = FaultKind::lost;
      fault.identifier = kAbove[below(5)];
      fault.mask = cansync::identifier::channel_bits;
      fault.to = fault.from + below(120);
      above_.push_back(fault);
    } else if (kind < 7) {
      fault.kind = kind == 5 ? FaultKind::missing_sync : FaultKind::silent;
      fault.node = NodeNumber{kGatewayA};
      fault.probability = 1;
      fault.to = fault.from + below(fault.kind == FaultKind::silent ? 25 : 80);
      above_.push_back(fault);
    } else {
      // An answer of the last slave that was on the bus and did not come is asked for again, and its write
      // is another one once the slave has said that it is busy (bit 6 is cleared).
      fault.kind = FaultKind::lost;
      fault.identifier = kBelow[below(busy_slaves_ || net_.lowest_count != 0 ? 5 : 6)];
      fault.mask = cansync::identifier::channel_bits;
      fault.to = fault.from + below(120);
      beneath_.push_back(fault);
    }
  }
  void move_faults() {
    const auto add = [](Line& line, Fault fault) {
      fault.from += line.intervals();
      fault.to += line.intervals();
      line.faults().add(fault);
    };
    for (const Fault& fault : above_) add(*net_.top_bus, fault);
    for (const Fault& fault : beneath_) add(*net_.middle_bus, fault);
  }
  void mutate_settings() {
    for (ClusterNodeSettings* gateway : {&net_.a, &net_.b}) {
      auto& settings = gateway->cluster.gateway;
      if (mutant_ == ClusterMutant::forgets_answers) settings.remembers_writes = false;
      if (mutant_ == ClusterMutant::keeps_old_answers) settings.asker_gone = net_.times.interval * 100'000;
      if (mutant_ == ClusterMutant::never_stops) gateway->holdover = net_.times.interval * 100'000;
      if (mutant_ == ClusterMutant::repeats_below)
        gateway->cluster.lower.command_channel.repeat_unanswered_writes = true;
    }
    if (mutant_ == ClusterMutant::crosses_routes)
      std::swap(net_.a.cluster.gateway.routes[0].slave, net_.a.cluster.gateway.routes[1].slave);
    if (mutant_ == ClusterMutant::speaks_unasked) {
      Fault fault;
      fault.kind = FaultKind::inject;
      fault.from = fault.to = 150 + below(200);
      fault.delay = net_.times.reference_two;
      fault.frame.id = 0x580 + kGatewayA;
      fault.frame.dlc = 2;
      net_.top.faults.push_back(fault);
    }
  }

  /// Once in each interval, right after its beginning.
  void watch(ClusterNode& node) {
    const bool gone = node.lock().holdover() > net_.times.interval * (kHoldover + 5);
    if (gone && node.cluster().sync_output()) say("SYNC goes on below without the one above");
    if (mutant_ != ClusterMutant::holds_values) return;
    cansync::ReferenceUpdate update;
    update.channel = Channel::two;
    update.value = {node.cluster().upper().references()[0], node.cluster().upper().references()[4], 0, 0};
    update.valid_mask = 3;
    update.from_interval = node.interval();
    static_cast<void>(node.cluster().lower().submit(update));
  }

  std::uint16_t somebody() {
    if (net_.lowest_count != 0 && chance(60))
      return static_cast<std::uint16_t>(kLowest + below(net_.lowest_count));
    const unsigned slave = below(3);
    return static_cast<std::uint16_t>(kMiddle + slave);
  }
  void submit_parameter() {
    CampaignJob job;
    job.number = somebody();
    job.write = chance(50);
    job.count = !job.write && chance(70);
    job.value = 0x20000 + ++values_;
    job.parameter = static_cast<std::uint16_t>(job.write ? 401 + 2 * below(5) : 20 + below(9));
    if (job.count) job.parameter = kCounting;
    job.edges = net_.of(job.number).edges.size();
    auto request =
        job.write ? net_.write(job.number, job.parameter, job.value) : net_.read(job.number, job.parameter);
    request.monitoring_time = net_.times.interval * 60;
    if (net_.upper_master().submit(request) != cansync::Refusal::none) return;
    jobs_[request.id] = job;
    newest_ = request.id;
    if (chance(15)) static_cast<void>(net_.upper_master().cancel(jobs_.begin()->first + below(values_)));
    if (chance(15)) static_cast<void>(net_.upper_master().cancel(newest_));
  }
  void submit_count(std::uint16_t number) {
    CampaignJob job;
    job.count = true;
    job.number = number;
    job.parameter = kCounting;
    job.edges = net_.of(number).edges.size();
    const auto request = net_.read(number, kCounting);
    if (net_.upper_master().submit(request) != cansync::Refusal::none) return;
    jobs_[request.id] = job;
    newest_ = request.id;
  }
  /// Nobody waits for a value any more, and nobody asks for anything; then it is asked for again.
  void linger() {
    net_.run_until([this] { return net_.upper_master().open_parameter_jobs() == 0; }, 200);
    const std::uint16_t number = somebody();
    submit_count(number);
    net_.run(2 + below(4));
    static_cast<void>(net_.upper_master().cancel(newest_));
    net_.run(kAskerGone + 40);
    submit_count(number);
    net_.run(5);
  }
  void submit_below() {
    CampaignJob job;
    job.write = true;
    job.number = static_cast<std::uint16_t>(kMiddle + below(3));
    job.parameter = 401;
    job.value = 0x20000 + ++values_;
    auto request = net_.write(0, job.parameter, job.value);
    request.slave = *SlaveNumber::from(job.number - kMiddle);
    request.sub_slave = {};
    if (net_.cluster().lower().submit(request) == cansync::Refusal::none) below_jobs_[request.id] = job;
  }
  void submit_transfer() {
    data_.push_back(bytes_of(1 + below(200)));
    const std::uint32_t address = 0x1000 + 0x400 * static_cast<std::uint32_t>(data_.size());
    const std::uint16_t number = somebody();
    auto request = net_.transfer(number, true, data_.back(), address);
    request.monitoring_time = net_.times.interval * 200;
    if (net_.upper_master().submit(request) != cansync::Refusal::none) return;
    transfers_[request.id] = {number, address, data_.size() - 1};
    if (chance(20)) static_cast<void>(net_.upper_master().cancel(request.id));
  }

  void finish() {
    const auto all_ended = [this] {
      return net_.ends.parameters.size() >= jobs_.size() && net_.ends.transfers.size() >= transfers_.size();
    };
    if (!net_.run_until(all_ended, 6000)) say("a job never ended");
    const auto idle = [this] {
      return net_.cluster().gateway().running() == 0 &&
             (net_.gateway_b == nullptr || net_.gateway_b->cluster().gateway().running() == 0);
    };
    if (!net_.run_until(idle, 2000)) say("a gateway still has a job that nobody waits for");
    net_.run_until([this] { return net_.ends_a.parameters.size() >= below_jobs_.size(); }, 6000);
    for (const auto& [id, job] : below_jobs_)
      if (!net_.ends_a.parameters.contains(id)) say("a job of the lower bus never ended");
    for (const auto& [id, result] : net_.ends_a.parameters)
      if (!below_jobs_.contains(id)) say("a job of the gateway shows at the lower bus");
  }

  void judge_values() {
    std::map<std::uint32_t, std::uint16_t> where;
    for (unsigned n = 0; n < 8 + net_.lowest_count; ++n) {
      if (net_.lowest_count != 0 && n == kGatewayB) continue;
      const auto number = static_cast<std::uint16_t>(n < 8 ? kMiddle + n : kLowest + n - 8);
      for (const auto& [parameter, value] : net_.of(number).applied)
        if (!where.emplace(value, number).second)
          say("value " + std::to_string(value) + " was written twice");
    }
    const auto judge = [&](const CampaignJob& job, const cansync::ParameterResult& result) {
      const auto there = where.find(job.value);
      if (job.write && there != where.end() && there->second != job.number)
        say("value " + std::to_string(job.value) + " is elsewhere");
      if (result.outcome != Outcome::done) return;
      if (job.write && there == where.end()) say("value " + std::to_string(job.value) + " is nowhere");
      if (job.write) return;
      if (!job.count) {
        if (result.value != LeafSlave::initial(job.number, job.parameter)) say("a wrong value was read");
      } else if (result.value + kAskerGone + 20 < job.edges) {
        say("a value that is " + std::to_string(job.edges - result.value) +
            " intervals older than its question");
      }
    };
    for (const auto& [id, job] : jobs_) judge(job, net_.ends.parameters[id]);
    for (const auto& [id, job] : below_jobs_) judge(job, net_.ends_a.parameters[id]);
    for (const auto& [id, transfer] : transfers_) {
      if (net_.ends.transfers[id].outcome != Outcome::done) continue;
      const auto& memory = net_.of(transfer.number).memory;
      const auto found = memory.find(transfer.address);
      if (found == memory.end() || found->second != data_[transfer.data]) say("a block is not what was sent");
    }
  }

  /// Each reference value below is that of its own interval above, with the fixed delay, and none is older.
  void judge_references() {
    constexpr std::uint32_t kOffsets[] = {1000, 500'000};
    for (const auto& reference : net_.middle[0]->references) {
      const auto at = reference.at + net_.times.interval / 2;
      const auto interval = static_cast<std::uint32_t>(at / net_.times.interval);
      const auto expect = [&](unsigned channel, unsigned value, std::uint32_t offset) {
        if (!reference.fresh[channel]) return;
        const std::uint32_t delay = net_.cluster().lead().delay(value);
        if (reference.values[value] != offset + interval - delay)
          say("reference value " + std::to_string(value) + " in interval " + std::to_string(interval) +
              " is that of another one");
      };
      expect(0, 0, kOffsets[0]);
      expect(1, 4, kOffsets[0]);
      expect(1, 5, kOffsets[1]);
    }
  }

  void judge_edges() {
    const auto& edges = net_.middle[0]->edges;
    unsigned gaps = 0;
    for (std::size_t i = 1; i < edges.size(); ++i) {
      const can::Time distance = edges[i] - edges[i - 1];
      const auto intervals = (distance + net_.times.interval / 2) / net_.times.interval;
      const can::Time off = distance - net_.times.interval * intervals;
      if (std::abs(off.count()) > intervals * net_.a.greatest_step.count()) say("SYNC jumps below");
      if (intervals != 1) ++gaps;
    }
    if (gaps > net_.cluster().sync_losses()) say("SYNC stays away below");
  }

  struct CampaignTransfer {
    std::uint16_t number = 0;
    std::uint32_t address = 0;
    std::size_t data = 0;
  };

  std::mt19937_64 dice_;
  ClusterMutant mutant_;
  Levels net_;
  bool busy_slaves_ = true;
  unsigned slow_percent_ = 0;  ///< answers of gateways that are ready after their slot
  std::vector<Fault> above_, beneath_;
  std::map<cansync::JobId, CampaignJob> jobs_, below_jobs_;
  std::map<cansync::JobId, CampaignTransfer> transfers_;
  std::deque<std::vector<std::uint8_t>> data_;
  cansync::JobId newest_ = 0;
  std::uint32_t values_ = 0;
  std::vector<std::string> wrong_;
};

unsigned cluster_seeds() {
  const char* given = std::getenv("CANSYNC_CLUSTER_SEEDS");  // NOLINT(concurrency-mt-unsafe): one thread
  return given == nullptr ? 100u : static_cast<unsigned>(std::strtoul(given, nullptr, 10));
}

TEST(ClusterCampaign, K5K9K13NothingTwiceNothingOldNothingLeftOpen) {
  ClusterTotals totals;
  for (unsigned seed = 1; seed <= cluster_seeds(); ++seed) {
    for (const std::string& what : ClusterCourse(seed, ClusterMutant::none).run(totals))
      ADD_FAILURE() << "seed " << seed << ": " << what;
  }
  const unsigned seeds = cluster_seeds();
  if (seeds < 60) return;  // too few to say how much they tried
  EXPECT_GT(totals.done, 10 * seeds);
  EXPECT_GT(totals.ended_badly, 2 * seeds);
  EXPECT_GT(totals.transfers, seeds / 2);
  EXPECT_GT(totals.given, 300 * seeds);
  EXPECT_GT(totals.missing, 5 * seeds);
  EXPECT_GT(totals.losses, seeds / 10);
  EXPECT_GT(totals.faults_hit, 10 * seeds);
}

TEST(ClusterCampaign, K5K9K13FindsEveryMutant) {
  for (unsigned mutant = 1; mutant <= static_cast<unsigned>(ClusterMutant::speaks_unasked); ++mutant) {
    ClusterTotals totals;
    unsigned found = 0;
    for (unsigned seed = 1; seed <= 60 && found < 2; ++seed)
      found += ClusterCourse(seed, static_cast<ClusterMutant>(mutant)).run(totals).empty() ? 0 : 1;
    EXPECT_GT(found, 1u) << "mutant " << mutant;
  }
}

}  // namespace
}  // namespace sim::test
