// Three levels with 1 + 32 + 32 slaves: thousands of parameter jobs with busy, loss and cancel, each of which
// ends once, with the right value, and is applied once.
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "cluster_rig.h"

namespace sim::test {
namespace {

using cansync::Outcome;

Fault lost_frames(std::uint32_t identifier, std::uint32_t mask, double probability) {
  Fault fault;
  fault.kind = FaultKind::lost;
  fault.identifier = identifier;
  fault.mask = mask;
  fault.probability = probability;
  fault.from = 800;
  return fault;
}

struct GivenJob {
  bool write = false;
  std::uint16_t number = 0;  ///< CANsync number
  std::uint16_t parameter = 0;
  std::uint32_t value = 0;
};

TEST(ClusterJobs, K10K13TwoThousandJobsAcrossTwoLevelsEndOnceWithTheRightValue) {
  constexpr unsigned kJobs = 2000;
  Levels net(BitRate::mbit1, 32, 32);
  // Commands; answers of the gateways are too late for their slot now and then. An answer that was on the bus
  // ends what is kept of it: the same write is another one then.
  constexpr std::uint32_t kChannel = cansync::identifier::channel_bits;
  for (LineSettings* line : {&net.top, &net.middle_line, &net.lowest_line})
    line->faults = {lost_frames(0x500, kChannel, 0.02)};
  for (auto* startup :
       {&net.master.master.startup, &net.a.cluster.lower.startup, &net.b.cluster.lower.startup})
    startup->lost_after = 10;
  // Process data on every level.
  for (auto* cluster : {&net.a.cluster, &net.b.cluster}) {
    for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}})
      cluster->lead[value] = {cansync::LeadSource::Kind::reference, value, {}, true};
  }
  std::mt19937_64 dice(15);
  const auto below = [&dice](unsigned limit) { return static_cast<unsigned>(dice() % limit); };
  net.build();
  for (auto* level : {&net.middle, &net.lowest}) {
    for (LeafSlave* slave : *level) {
      if (slave == nullptr) continue;
      slave->record = false;
      slave->busy = [&below] { return below(4) == 0 ? below(12) : 0; };
    }
  }
  ASSERT_TRUE(net.run_until([&] { return net.all_active(); }, 4000));
  std::mt19937_64 slowness(16);
  for (ClusterNode* gateway : {net.gateway_a, net.gateway_b})
    gateway->slow = [&] { return slowness() % 25 == 0 ? net.times.interval : can::Time{}; };

  std::map<cansync::JobId, GivenJob> given;
  while (given.size() < kJobs || net.ends.parameters.size() < given.size()) {
    ASSERT_LT(net.top_bus->intervals(), 400'000u) << net.ends.parameters.size() << " have ended";
    if (given.size() < kJobs && net.upper_master().open_parameter_jobs() < 8) {
      GivenJob job;
      job.write = below(2) == 0;
      const bool lowest = below(2) == 0;
      unsigned slave = below(32);
      if (!lowest && slave == kGatewayB) slave = 0;
      job.number = static_cast<std::uint16_t>((lowest ? kLowest : kMiddle) + slave);
      job.parameter = static_cast<std::uint16_t>(job.write ? 401 + 2 * below(40) : 20 + below(200));
      job.value = static_cast<std::uint32_t>(given.size()) + 0x10000;
      const auto request =
          job.write ? net.write(job.number, job.parameter, job.value) : net.read(job.number, job.parameter);
      if (net.upper_master().submit(request) == cansync::Refusal::none) {
        given[request.id] = job;
        if (below(12) == 0) {
          net.run(below(20));
          static_cast<void>(net.upper_master().cancel(request.id));
        }
      }
    }
    net.run();
  }

  std::map<std::uint32_t, std::pair<std::uint16_t, std::uint16_t>> written;  // where each value is
  for (unsigned n = 0; n < 32; ++n) {
    for (const unsigned base : {unsigned{kMiddle}, unsigned{kLowest}}) {
      if (base == kMiddle && n == kGatewayB) continue;
      for (const auto& [parameter, value] : net.of(base + n).applied) {
        const auto there = std::pair(static_cast<std::uint16_t>(base + n), parameter);
        EXPECT_TRUE(written.emplace(value, there).second) << "value " << value << " was written twice";
      }
    }
  }
  std::map<Outcome, unsigned> outcomes;
  ASSERT_EQ(given.size(), kJobs);
  for (const auto& [id, job] : given) {
    const auto& result = net.ends.parameters.at(id);
    ++outcomes[result.outcome];
    const auto there = written.find(job.value);
    if (job.write && there != written.end()) {
      EXPECT_EQ(there->second, std::pair(job.number, job.parameter)) << "written elsewhere";
    }
    if (result.outcome != Outcome::done) continue;
    if (job.write) {
      EXPECT_NE(there, written.end()) << "said to be written, and is not";
    } else {
      EXPECT_EQ(result.value, LeafSlave::initial(job.number, job.parameter)) << job.number;
      EXPECT_EQ(result.doubleword, job.parameter % 2 != 0);
    }
  }
  EXPECT_GT(outcomes[Outcome::done], 1500u);
  EXPECT_GT(outcomes[Outcome::cancelled], 50u);
  EXPECT_GT(outcomes[Outcome::no_answer] + outcomes[Outcome::slave_error], 10u);
  EXPECT_GT(net.cluster().gateway().counters().repeated, 10u);
  EXPECT_GT(net.lowest_bus->counters().frames, 3 * net.top_bus->intervals()) << "process data";
  EXPECT_TRUE(net.run_until(
      [&] { return net.cluster().gateway().running() + net.gateway_b->cluster().gateway().running() == 0; },
      20'000));
}

}  // namespace
}  // namespace sim::test
