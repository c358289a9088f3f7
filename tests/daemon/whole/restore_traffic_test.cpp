// What `cansync restore` asks of a line that runs, in virtual time: reference values go on in every interval.
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>
#include <variant>

#include "cansync/sim/drive_parameters.h"
#include "support/virtual_line.h"

namespace cansyncd::test {
namespace {

using namespace cansync;
using support::drives_for;
using support::line_settings;
using support::VirtualLine;

constexpr unsigned kParameters = sim::parameter::plain_count;
constexpr unsigned kRestores = 20;
constexpr std::uint64_t kSetUp = 400;  // edges

/// One restore after the other of 20 parameters of slave 1: each is written, then read back, then the next.
class Restores {
 public:
  explicit Restores(Exchange& exchange) : exchange_(exchange) {}

  /// Takes the answers so far, and asks for what comes next.
  void go_on() {
    Terminal terminal;
    while (exchange_.terminals.try_pop(terminal)) {
      const auto* done = std::get_if<ParameterDone>(&terminal);
      if (done == nullptr) continue;
      ASSERT_EQ(done->result.outcome, Outcome::done);
      ASSERT_EQ(done->result.value, value());
      waiting_ = false;
      ++answered_;
    }
    if (waiting_ || ended()) return;
    ParameterRequest request;
    request.id = answered_ + 1;
    request.write = answered_ % 2 == 0;
    request.slave = *SlaveNumber::from(1);
    request.number = *ParameterNumber::from(sim::parameter::first_plain_word + parameter());
    request.format = ParameterFormat::word;
    request.value = request.write ? value() : 0;
    ASSERT_TRUE(exchange_.requests.try_push(request));
    waiting_ = true;
  }

  bool ended() const { return answered_ == 2 * kParameters * kRestores; }

 private:
  unsigned parameter() const { return answered_ / 2 % kParameters; }
  std::uint32_t value() const { return 100 + answered_ / 2; }

  Exchange& exchange_;
  unsigned answered_ = 0;
  bool waiting_ = false;
};

class RestoreTraffic : public testing::TestWithParam<BitRate> {};

TEST_P(RestoreTraffic, LeavesOutNoReferenceTelegram) {
  const MasterSettings settings = line_settings(GetParam(), 4);
  VirtualLine line(settings, drives_for(settings));
  Restores restores(line.exchange());
  std::map<std::uint32_t, unsigned> in_interval;  // frames by channel
  std::uint64_t intervals = 0;                    // from the first request to the last answer
  line.on_frame = [&](const sim::TracedFrame& traced, can::Time) { ++in_interval[traced.frame.id & 0x780]; };
  line.on_edge = [&](std::uint64_t edge) {
    line.give_references(static_cast<std::uint32_t>(edge * 100));
    const auto before = std::exchange(in_interval, {});
    if (edge < kSetUp || restores.ended()) return;
    if (edge > kSetUp) {
      ++intervals;
      for (const std::uint32_t channel : {identifier::reference_one, identifier::reference_two,
                                          identifier::actual_one, identifier::actual_two})
        EXPECT_EQ(before.contains(channel) ? before.at(channel) : 0, 1u) << std::hex << channel;
    }
    restores.go_on();
    if (restores.ended()) line.stop();
  };
  line.run(kSetUp + 20'000);

  EXPECT_TRUE(restores.ended());
  EXPECT_GE(intervals, 2u * kParameters * kRestores) << "an access takes an interval or more";
  EXPECT_EQ(line.snapshot().counters.left_out, 0u);
}

INSTANTIATE_TEST_SUITE_P(AllRates, RestoreTraffic,
                         testing::Values(BitRate::kbit125, BitRate::kbit250, BitRate::kbit500,
                                         BitRate::mbit1),
                         [](const auto& rate) {
                           return std::to_string(slot_times(rate.param).bits_per_second / 1000) + "k";
                         });

}  // namespace
}  // namespace cansyncd::test
