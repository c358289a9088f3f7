// Fairness on a whole line in virtual time: how long one client waits while another asks without end.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/cansync/requests/lanes.h"
#include "support/virtual_line.h"

namespace cansyncd {
namespace {

using cansync::JobId;
using support::drives_for;
using support::line_settings;
using support::VirtualLine;

constexpr ClientIdentity kGreedy = {1};
constexpr ClientIdentity kModest = {2};
constexpr unsigned kPerClient = 64;  ///< as the gateway allows

cansync::SlaveNumber slave(unsigned n) {
  return *cansync::SlaveNumber::from(n);
}

Request read_of(unsigned target) {
  cansync::ParameterRequest request;
  request.slave = slave(target);
  request.number = *cansync::ParameterNumber::from(301);
  return request;
}

Request control_word_of(unsigned target) {
  return cansync::ControlWordRequest{0, slave(target), 0x000F};
}

/// A line of four drives whose requests come through the lanes, as the gateway hands them on. The greedy
/// client always has as many requests open as it may.
class FairLine {
 public:
  FairLine(const Request& greedy, Lane lane)
      : settings_(line_settings(cansync::BitRate::mbit1, 4)),
        lanes_(lane_limits(settings_.command_channel)),
        line_(settings_, drives_for(settings_)),
        greedy_(greedy),
        greedy_lane_(lane) {
    line_.on_edge = [this](std::uint64_t edge) { step(edge); };
  }

  /// From interval 1000 on the modest client asks every 97 intervals, one request at a time.
  void run(const Request& modest, Lane lane, std::uint64_t intervals) {
    modest_ = modest;
    modest_lane_ = lane;
    line_.run(intervals);
  }

  std::uint64_t of_greedy = 0;  ///< requests of the greedy client that were done
  std::uint64_t of_modest = 0;
  std::uint64_t longest = 0;  ///< intervals the modest client waited for one
  std::uint64_t failed = 0;

 private:
  void step(std::uint64_t edge) {
    Terminal terminal;
    while (line_.exchange().terminals.try_pop(terminal)) ended(terminal, edge);
    if (edge < 900) return;  // the line starts up
    while (greedy_open_ < kPerClient) {
      add(kGreedy, greedy_, greedy_lane_);
      ++greedy_open_;
    }
    if (edge >= 1000 && edge % 97 == 0 && !asked_) {
      add(kModest, modest_, modest_lane_);
      asked_ = edge;
    }
    (void)lanes_.hand_over(
        [this](JobId id) { return line_.exchange().requests.try_push(open_.at(id).second); });
  }

  void add(const ClientIdentity& client, Request request, Lane lane) {
    const JobId id = next_++;
    std::visit(
        [id](auto& typed) {
          if constexpr (requires { typed.id; }) typed.id = id;
        },
        request);
    open_[id] = {client, request};
    lanes_.add(id, client, lane);
  }

  void ended(const Terminal& terminal, std::uint64_t edge) {
    const JobId id = std::visit([](const auto& done) { return done.id; }, terminal);
    const auto job = open_.find(id);
    ASSERT_NE(job, open_.end()) << "answered twice";
    const bool done = std::visit(
        [](const auto& result) {
          if constexpr (requires { result.result; }) return result.result.outcome == cansync::Outcome::done;
          if constexpr (requires { result.outcome; }) return result.outcome == cansync::Outcome::done;
          return false;
        },
        terminal);
    if (!done) ++failed;
    if (job->second.first == kGreedy) {
      --greedy_open_;
      ++of_greedy;
    } else {
      longest = std::max(longest, edge - *asked_);
      asked_.reset();
      ++of_modest;
    }
    open_.erase(job);
    lanes_.remove(id);
  }

  cansync::MasterSettings settings_;
  FairLanes lanes_;
  VirtualLine line_;
  Request greedy_;
  Lane greedy_lane_;
  Request modest_;
  Lane modest_lane_;
  std::map<JobId, std::pair<ClientIdentity, Request>> open_;
  unsigned greedy_open_ = 0;
  std::optional<std::uint64_t> asked_;
  JobId next_ = 1;
};

/// Turns of the slave until the request of one client among two is done (docs/reliability.md): four that the
/// slave has, one of the other client, its own.
constexpr std::uint64_t kTurns = 4 + 1 + 1;
/// A request that comes at one edge is handed on in that interval, and its answer is seen at a later edge.
constexpr std::uint64_t kOnTheWay = 2;

TEST(FairLine, TenThousandReadsOfOneClientLeaveAnotherItsShareOfTheSlave) {
  FairLine line(read_of(1), {LaneKind::parameter, 1});
  line.run(read_of(1), {LaneKind::parameter, 1}, 22'000);
  EXPECT_GE(line.of_greedy, 10'000u);
  EXPECT_GE(line.of_modest, 200u);
  EXPECT_EQ(line.failed, 0u);
  // Nothing else uses the command channel but a status word of each slave a second: an interval in eight at
  // most.
  EXPECT_LE(line.longest, kTurns * 8 / 7 + 1 + kOnTheWay);
}

TEST(FairLine, AnotherSlaveIsNotConcerned) {
  FairLine line(read_of(1), {LaneKind::parameter, 1});
  line.run(read_of(2), {LaneKind::parameter, 2}, 5'000);
  EXPECT_GE(line.of_modest, 30u);
  // The slaves take turns.
  EXPECT_LE(line.longest, 2 + 1 + kOnTheWay);
}

TEST(FairLine, ControlWordsOfOneClientLeaveAnotherItsShare) {
  FairLine line(control_word_of(1), {LaneKind::control_word, 1});
  line.run(control_word_of(1), {LaneKind::control_word, 1}, 5'000);
  EXPECT_GE(line.of_greedy, 2'000u);
  EXPECT_GE(line.of_modest, 30u);
  EXPECT_LE(line.longest, kTurns * 8 / 7 + 1 + kOnTheWay);
}

TEST(FairLine, ALongTransferLeavesAnotherClientItsParameters) {
  std::vector<std::uint8_t> memory(100'000);
  cansync::TransferRequest upload;
  upload.slave = slave(1);
  upload.address = 0x1000;
  upload.data = memory;
  FairLine line(upload, {LaneKind::transfer, 1});
  line.run(read_of(1), {LaneKind::parameter, 1}, 20'000);
  EXPECT_GE(line.of_modest, 150u);
  // Parameters go before transfers, but for the transfers' share of one interval in eight.
  EXPECT_LE(line.longest, 2 + kOnTheWay);
}

TEST(FairLine, TransfersOfOneClientLeaveAnotherItsShareOfTheSlave) {
  std::vector<std::uint8_t> greedy(3'000);
  std::vector<std::uint8_t> modest(300);
  cansync::TransferRequest upload;
  upload.slave = slave(1);
  upload.address = 0x1000;
  upload.data = greedy;
  cansync::TransferRequest other = upload;
  other.data = modest;
  FairLine line(upload, {LaneKind::transfer, 1});
  line.run(other, {LaneKind::transfer, 1}, 40'000);
  EXPECT_EQ(line.failed, 0u);
  EXPECT_GE(line.of_greedy, 20u);
  EXPECT_GE(line.of_modest, 20u);
  // One that runs, one of the other client, its own: each of the long ones takes about 600 intervals.
  const std::uint64_t long_one = 39'000 / line.of_greedy;
  EXPECT_LE(line.longest, 2 * long_one + long_one);
}

}  // namespace
}  // namespace cansyncd
