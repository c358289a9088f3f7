// Asking drives on a line without SYNC: what is found is what the drives are, and nothing but questions goes
// out.
#include "cli/scan/inquiry.h"

#include <gtest/gtest.h>

#include <random>

#include "cansync/channel/transfer_job.h"
#include "cli/scan/spy_line.h"
#include "profile/reader.h"

namespace cansync::cli {
namespace {

using support::SpyLine;

constexpr const char* kProfile = R"([profile]
name = "winder-drive"
recognised_by = ["100=4400", "2000=77"]
[[parameter]]
number = 100
name = "device-type"
format = "word"
access = "read-only"
identity = "type"
[[parameter]]
number = 310
name = "position"
format = "doubleword"
access = "read-only"
actual_value = 0
[[parameter]]
number = 501
name = "status"
format = "word"
access = "read-only"
tells = "status-word"
[[parameter]]
number = 2000
name = "model"
format = "word"
access = "read-only"
identity = "type"
[[parameter]]
number = 2001
name = "mapping"
format = "doubleword"
access = "read-only"
tells = "actual-mapping-1"
)";

ProfilePointer profile_of(const std::string& text, const std::string& name) {
  auto reading = profile::parse(text, name + ".toml");
  EXPECT_TRUE(reading.profile) << config::problems_text(reading.problems);
  return std::make_shared<const profile::Profile>(*reading.profile);
}

sim::DriveSettings drive_of(unsigned number, BitRate rate) {
  sim::DriveSettings settings;
  settings.slave.number = *SlaveNumber::from(number);
  settings.slave.bit_rate = rate;
  settings.memory.size = 64 * 1024;
  return settings;
}

void add_word(sim::DriveSettings& settings, std::uint16_t number, std::uint32_t value, bool doubleword) {
  sim::ParameterDefinition definition;
  definition.number = number;
  definition.doubleword = doubleword;
  definition.access = sim::ParameterDefinition::Access::read_only;
  definition.initial = value;
  settings.parameters.push_back(definition);
}

/// Every frame is a read of a parameter, or begins or closes an upload; at most one in an interval.
void expect_questions_alone(const SpyLine& line, BitRate rate) {
  for (std::size_t i = 0; i < line.sent.size(); ++i) {
    const can::Frame& frame = line.sent[i].frame;
    const auto decoded = decode(frame);
    const auto& telegram = std::get<Telegram>(decoded);
    const auto* read = std::get_if<ParameterCommand>(&telegram);
    const auto* begin = std::get_if<TransferInitialise>(&telegram);
    ASSERT_TRUE((read != nullptr && read->kind == ParameterCommand::Kind::read) ||
                (begin != nullptr && begin->direction == TransferInitialise::Direction::upload))
        << i;
    if (i > 0) {
      ASSERT_GE(line.sent[i].at - line.sent[i - 1].at, slot_times(rate).interval) << i;
    }
  }
}

class InquiryTest : public ::testing::Test {
 protected:
  InquiryResult ask(SpyLine& line, BitRate rate, bool parameters = false) {
    QuestionLine questions(line, rate, stop_);
    InquirySettings settings;
    settings.profiles = {profile_of(kProfile, "winder-drive")};
    settings.parameters = parameters;
    return inquire(questions, settings, [](const std::string&, unsigned, unsigned) {});
  }

  std::atomic<bool> stop_ = false;
};

TEST_F(InquiryTest, FindsTheSlavesOfRandomLines) {
  std::mt19937 chance(7);
  for (int round = 0; round < 20; ++round) {
    SCOPED_TRACE(round);
    const BitRate rate = kSlotTimes[chance() % kSlotTimes.size()].bit_rate;
    const auto mask = static_cast<std::uint32_t>(chance() & chance());
    std::array<std::uint16_t, kSlaves> limit{};
    SpyLine line(rate);
    for (unsigned n = 0; n < kSlaves; ++n) {
      if (((mask >> n) & 1u) == 0) continue;
      sim::DriveSettings settings = drive_of(n, rate);
      limit[n] = static_cast<std::uint16_t>(6 + chance() % (kLongestBlock - 5));
      settings.slave.block_limit = limit[n];
      line.add(settings);
    }
    const InquiryResult result = ask(line, rate);
    std::uint32_t found = 0;
    for (const FoundSlave& slave : result.slaves) {
      const unsigned n = slave.number.value();
      found |= 1u << n;
      EXPECT_TRUE(slave.status_word) << n;
      EXPECT_EQ(slave.profile, nullptr);
      ASSERT_TRUE(slave.block_limit) << n << " limit " << limit[n];
      EXPECT_EQ(*slave.block_limit, limit[n] - limit[n] % 6) << n;
    }
    EXPECT_EQ(found, mask);
    expect_questions_alone(line, rate);
    EXPECT_TRUE(line.open.empty());
  }
}

TEST_F(InquiryTest, RecognisesADriveAndTakesWhatItTells) {
  SpyLine line(BitRate::kbit250);
  sim::DriveSettings settings = drive_of(9, BitRate::kbit250);
  settings.status_parameter = 501;
  add_word(settings, 2000, 77, false);
  add_word(settings, 2001, 0x00000D01, true);  // value 0 low, value 3 low
  line.add(settings);
  line.add(drive_of(10, BitRate::kbit250));
  const InquiryResult result = ask(line, BitRate::kbit250);
  ASSERT_EQ(result.slaves.size(), 2u);
  const FoundSlave& winder = result.slaves[0];
  ASSERT_TRUE(winder.profile);
  EXPECT_EQ(winder.profile->name, "winder-drive");
  EXPECT_EQ(winder.status_parameter, 501);
  ASSERT_TRUE(winder.actual[0]);
  EXPECT_EQ(winder.actual[0]->word[1], (WordMapping{true, false, 3}));
  EXPECT_FALSE(winder.actual[1]);
  EXPECT_FALSE(result.slaves[1].profile) << "the model is missing";
  expect_questions_alone(line, BitRate::kbit250);
}

TEST_F(InquiryTest, ReadsEveryParameterNumber) {
  SpyLine line(BitRate::mbit1);
  line.add(drive_of(4, BitRate::mbit1));
  const InquiryResult result = ask(line, BitRate::mbit1, true);
  ASSERT_EQ(result.slaves.size(), 1u);
  std::vector<std::uint16_t> found;
  for (const FoundParameter& parameter : result.slaves[0].parameters) found.push_back(parameter.number);
  std::vector<std::uint16_t> expected;
  for (const auto& definition : sim::standard_parameters()) expected.push_back(definition.number);
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(found, expected);
  expect_questions_alone(line, BitRate::mbit1);
}

TEST_F(InquiryTest, LeavesNothingOpenWhenItIsStopped) {
  // The number of questions of a whole inquiry, then one for each place where it may be stopped.
  SpyLine whole(BitRate::mbit1);
  whole.add(drive_of(0, BitRate::mbit1));
  ask(whole, BitRate::mbit1);
  for (std::size_t at = 1; at < whole.sent.size(); ++at) {
    stop_ = false;
    SpyLine line(BitRate::mbit1);
    line.add(drive_of(0, BitRate::mbit1));
    line.on_sent = [&] { stop_ = stop_ || line.sent.size() == at; };
    EXPECT_TRUE(ask(line, BitRate::mbit1).stopped);
    EXPECT_TRUE(line.open.empty()) << at;
    EXPECT_LE(line.sent.size(), at + 1);
  }
}

TEST_F(InquiryTest, KeepsWhatWasFoundAndClosesWhatIsOpenWhenAMasterAppears) {
  SpyLine whole(BitRate::mbit1);
  whole.add(drive_of(0, BitRate::mbit1));
  ask(whole, BitRate::mbit1);
  can::Frame reference;
  reference.id = 0x17F;
  for (std::size_t at = 2; at < whole.sent.size(); ++at) {
    SpyLine line(BitRate::mbit1);
    line.add(drive_of(0, BitRate::mbit1));
    line.on_sent = [&] {
      if (line.sent.size() == at) line.inject(reference);
    };
    const InquiryResult result = ask(line, BitRate::mbit1);
    EXPECT_TRUE(result.stopped) << at;
    EXPECT_NE(result.failure.find("a master sends"), std::string::npos) << result.failure;
    ASSERT_EQ(result.slaves.size(), 1u) << at;
    EXPECT_FALSE(result.slaves[0].parameters.empty());
    EXPECT_TRUE(line.open.empty()) << at;
    EXPECT_LE(line.sent.size(), at + 1) << "nothing but the end of an upload goes out beside a master";
  }
}

TEST_F(InquiryTest, KeepsWhatWasFoundWhenTheLineFails) {
  SpyLine line(BitRate::mbit1);
  line.add(drive_of(0, BitRate::mbit1));
  line.on_sent = [&] {
    if (line.sent.size() == 40) line.result = can::SocketResult::interface_down;
  };
  const InquiryResult result = ask(line, BitRate::mbit1);
  EXPECT_TRUE(result.stopped);
  EXPECT_NE(result.failure.find("the interface is down"), std::string::npos) << result.failure;
  EXPECT_EQ(result.slaves.size(), 1u);
}

TEST_F(InquiryTest, SaysThatNobodyAcknowledges) {
  SpyLine line(BitRate::mbit1);
  line.result = can::SocketResult::queue_full;
  try {
    ask(line, BitRate::mbit1);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("nobody acknowledges"), std::string::npos);
  }
}

}  // namespace
}  // namespace cansync::cli
