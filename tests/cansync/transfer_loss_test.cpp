#include <algorithm>
#include <random>

#include "master_rig.h"

namespace cansync::test {
namespace {

using Direction = TransferRequest::Direction;

constexpr std::uint32_t kAddress = 0x1000;

/// A slave written from the manual alone (M 3.2.1.3, 3.2.2.6), which does not remember its last answer: a
/// telegram that it has taken and gets again is out of order.
struct ForgetfulSlave {
  std::vector<std::uint8_t> memory = std::vector<std::uint8_t>(0x3000, 0xEE);
  std::optional<TransferInitialise> open;
  std::uint16_t length = 0;
  std::uint16_t expected = 0;
  bool refuses_a_second_initialise = false;  ///< 0x0108 while a block is open, instead of beginning anew
  bool names_the_counter = true;             ///< false: 0x0100 repeats the offset that was sent
  bool remembers = false;                    ///< answers a telegram that it has just taken as before
  /// Lengths it fixes for the blocks of an upload, one after the other; 0 and when used up: as asked.
  std::deque<std::uint16_t> fixed_lengths;
  /// Comes first for a last telegram in order; an error ends the block.
  std::function<std::optional<TransferError>()> at_last = [] { return std::nullopt; };
  std::vector<Telegram> asked;

  static TransferReply error(SlaveNumber number, std::uint16_t counter, TransferError code) {
    TransferReply reply{number, *BlockOffset::from(counter), false, true, 2, {}};
    store_word(reply.payload.data(), static_cast<std::uint16_t>(code));
    return reply;
  }

  std::optional<Telegram> operator()(const Telegram& telegram) {
    asked.push_back(telegram);
    if (remembers && taken == telegram) return answer;
    answer = answer_to(telegram);
    const auto* reply = answer ? std::get_if<TransferReply>(&*answer) : nullptr;
    taken.reset();
    if (reply != nullptr && !reply->error) taken = telegram;
    return answer;
  }

 private:
  std::optional<Telegram> taken;
  std::optional<Telegram> answer;

  std::optional<Telegram> answer_to(const Telegram& telegram) {
    if (const auto* initialise = std::get_if<TransferInitialise>(&telegram)) return begin(*initialise);
    if (const auto* block = std::get_if<UploadBlock>(&telegram)) {
      return step(block->slave, Direction::upload, block->offset.value(), block->last,
                  [&](TransferReply& reply, std::size_t at, std::size_t bytes) {
                    reply.payload_size = 6;
                    std::copy_n(memory.begin() + static_cast<std::ptrdiff_t>(at), bytes,
                                reply.payload.begin());
                  });
    }
    if (const auto* block = std::get_if<DownloadBlock>(&telegram)) {
      return step(block->slave, Direction::download, block->offset.value(), block->last,
                  [&](TransferReply&, std::size_t at, std::size_t bytes) {
                    std::copy_n(block->data.begin(), bytes, memory.begin() + static_cast<std::ptrdiff_t>(at));
                  });
    }
    return MasterRig::status_only(telegram);
  }

  std::optional<Telegram> begin(const TransferInitialise& initialise) {
    if (Telegram(initialise) == Telegram(cancel_transfer(initialise.slave))) {
      open.reset();
      return TransferReply{initialise.slave, {}, false, false, 0, {}};
    }
    if (open && refuses_a_second_initialise) {
      return error(initialise.slave, 0, TransferError::mode_not_allowed);
    }
    open = initialise;
    expected = 0;
    std::uint16_t fixed = 0;
    if (initialise.direction == Direction::upload && !fixed_lengths.empty()) {
      fixed = fixed_lengths.front();
      fixed_lengths.pop_front();
    }
    length = fixed != 0 ? fixed : initialise.length.value();
    return TransferReply{initialise.slave, *BlockOffset::from(fixed), false, false, 0, {}};
  }

  template <class Move>
  std::optional<Telegram> step(SlaveNumber number, Direction direction, std::uint16_t offset, bool last,
                               Move move) {
    if (!open || open->direction != direction) return error(number, offset, TransferError::mode_not_allowed);
    if (offset != expected) {
      return error(number, names_the_counter ? expected : offset, TransferError::other_block_expected);
    }
    const bool is_last = expected + 6 >= length;
    if (is_last != last) {
      return error(number, offset, is_last ? TransferError::end_expected : TransferError::end_not_expected);
    }
    if (last) {
      if (const auto refused = at_last()) {
        open.reset();
        return error(number, offset, *refused);
      }
    }
    TransferReply reply{number, *BlockOffset::from(offset), false, false, 0, {}};
    move(reply, open->address + offset, std::min<std::size_t>(6, length - offset));
    expected = static_cast<std::uint16_t>(expected + 6);
    if (last) open.reset();
    return reply;
  }
};

struct LostAnswers : testing::Test {
  MasterSettings settings = settings_for(4);
  ForgetfulSlave drive;
  std::unique_ptr<MasterRig> rig;
  JobId id = 0;
  /// What happens to the n-th transfer telegram (from 1) and its answer.
  enum class Fate : std::uint8_t { arrives, request_lost, answer_lost };
  std::function<Fate(std::size_t)> fate = [](std::size_t) { return Fate::arrives; };

  void start() {
    settings.startup.status_period = Duration(0);
    rig = std::make_unique<MasterRig>(settings);
    rig->activate();
    rig->answer = [this, n = std::size_t{0}](const Telegram& t) mutable -> std::optional<Telegram> {
      if (const auto status = MasterRig::status_only(t)) return status;
      const Fate how = fate(++n);
      if (how == Fate::request_lost) return std::nullopt;
      const auto answer = drive(t);
      return how == Fate::answer_lost ? std::nullopt : answer;
    };
  }

  TransferResult run(Direction direction, std::span<std::uint8_t> data, std::uint16_t block_size = 0) {
    if (!rig) start();
    drive.asked.clear();
    ++id;
    EXPECT_EQ(rig->master.submit(TransferRequest{.id = id,
                                                 .direction = direction,
                                                 .slave = slave(2),
                                                 .address = kAddress,
                                                 .block_size = block_size,
                                                 .data = data}),
              Refusal::none);
    rig->run_until([this] { return rig->told.transfers.contains(id); }, 2'000'000);
    return rig->told.transfers[id];
  }

  auto in_drive() const { return drive.memory.begin() + kAddress; }
};

std::vector<std::uint8_t> pattern(std::size_t size, unsigned seed = 0) {
  std::vector<std::uint8_t> data(size);
  for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(i * 7 + i / 256 + seed * 31);
  return data;
}

// Initialise is telegram 1, offset 0 is 2, offset 12 is 4.
TEST_F(LostAnswers, ADownloadGoesOnWhereTheSlaveSaysItStands) {
  fate = [](std::size_t n) { return n == 4 || n == 6 ? Fate::answer_lost : Fate::arrives; };
  std::vector<std::uint8_t> data = pattern(60);
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.bytes, 60u);
  EXPECT_EQ(result.repeated_blocks, 0u);
  EXPECT_EQ(result.repeated_telegrams, 2u);
  EXPECT_EQ(result.intervals, 1u + 10u + 2u);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

/// Both acknowledge offset 0. The slave is busy with the data, and has not taken it.
TEST_F(LostAnswers, ALateAnswerToARepeatedInitialiseIsNotThatToTheData) {
  start();
  unsigned initialises = 0;
  unsigned busy = 3;
  std::optional<Telegram> late;
  rig->answer = [&](const Telegram& t) -> std::optional<Telegram> {
    if (const auto status = MasterRig::status_only(t)) return status;
    if (std::holds_alternative<TransferInitialise>(t)) {
      const auto answer = drive(t);
      if (initialises++ != 0) return answer;
      late = answer;
      return std::nullopt;
    }
    if (busy == 0) return drive(t);
    --busy;
    return TransferReply{slave(2), {}, true, false, 0, {}};
  };
  std::vector<std::uint8_t> data = pattern(4);
  ASSERT_EQ(
      rig->master.submit(TransferRequest{
          .id = 1, .direction = Direction::download, .slave = slave(2), .address = kAddress, .data = data}),
      Refusal::none);
  rig->run_until([&] { return initialises == 2; }, 20);
  rig->run(2);
  rig->master.receive(encode(*late), std::chrono::microseconds(500));
  EXPECT_FALSE(rig->told.transfers.contains(1)) << "the slave has nothing";
  rig->run_until([this] { return rig->told.transfers.contains(1); }, 50);
  EXPECT_EQ(rig->told.transfers.at(1).outcome, Outcome::done);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

/// It acknowledges offset 0, as the answer to the initialise behind it does.
TEST_F(LostAnswers, ALateAnswerToACancelIsNotThatToTheNextInitialise) {
  start();
  std::optional<Telegram> late;
  std::optional<IntervalNumber> last_cancel;
  std::optional<IntervalNumber> initialise;
  bool deaf = false;
  rig->answer = [&](const Telegram& t) -> std::optional<Telegram> {
    if (const auto status = MasterRig::status_only(t)) return status;
    if (t == Telegram(cancel_transfer(slave(2)))) {
      last_cancel = rig->next_interval;
      late = drive(t);
      return std::nullopt;
    }
    if (deaf && std::holds_alternative<TransferInitialise>(t)) {
      initialise = rig->next_interval;
      return std::nullopt;
    }
    if (deaf) return std::nullopt;
    if (std::holds_alternative<TransferInitialise>(t)) return drive(t);
    return TransferReply{slave(2), {}, true, false, 0, {}};
  };
  std::vector<std::uint8_t> data = pattern(4);
  const TransferRequest request{
      .id = 1, .direction = Direction::download, .slave = slave(2), .address = kAddress, .data = data};
  ASSERT_EQ(rig->master.submit(request), Refusal::none);
  rig->run(4);
  (void)rig->master.cancel(1);
  deaf = true;
  TransferRequest next = request;
  next.id = 2;
  ASSERT_EQ(rig->master.submit(next), Refusal::none);
  rig->run_until([&] { return initialise.has_value(); }, 50);
  ASSERT_TRUE(last_cancel && late);
  EXPECT_GT(*initialise, *last_cancel + 3) << "its answer may be late by an interval, and one more";
}

TEST_F(LostAnswers, AnUploadThatLostSixBytesBeginsItsBlockAnewAtOnce) {
  fate = [](std::size_t n) { return n == 4 ? Fate::answer_lost : Fate::arrives; };
  drive.memory = pattern(drive.memory.size());
  std::vector<std::uint8_t> data(60);
  const TransferResult result = run(Direction::upload, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.repeated_blocks, 1u);
  EXPECT_EQ(result.repeated_telegrams, 1u);         // the one without an answer
  EXPECT_EQ(result.intervals, 4u + 1u + 1u + 11u);  // up to there, its repeat, cancel, the block
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

TEST_F(LostAnswers, ManyLostAnswersOfABlockUseUpNoRetries) {
  settings.command_channel.block_retries = 0;
  for (const Direction direction : {Direction::upload, Direction::download}) {
    rig.reset();
    fate = [](std::size_t n) { return n < 40 && n % 6 == 5 ? Fate::answer_lost : Fate::arrives; };
    drive.memory = pattern(drive.memory.size(), 1);
    std::vector<std::uint8_t> data = pattern(60, 2);
    const TransferResult result = run(direction, data);
    EXPECT_EQ(result.outcome, Outcome::done);
    EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
  }
}

TEST_F(LostAnswers, AnInitialiseThatTheSlaveHasTakenIsBegunAnew) {
  drive.refuses_a_second_initialise = true;
  settings.command_channel.block_retries = 0;
  fate = [](std::size_t n) { return n == 1 ? Fate::answer_lost : Fate::arrives; };
  std::vector<std::uint8_t> data = pattern(12);
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

// Both cancel telegrams get lost: the slave has the block open still when it is begun anew.
TEST_F(LostAnswers, ABlockThatTheSlaveHasStillOpenIsCancelledOnceMore) {
  drive.refuses_a_second_initialise = true;
  settings.command_channel.block_retries = 0;
  fate = [](std::size_t n) {
    if (n == 3) return Fate::answer_lost;
    return n == 5 || n == 6 ? Fate::request_lost : Fate::arrives;
  };
  std::vector<std::uint8_t> data(60);
  drive.memory = pattern(drive.memory.size());
  const TransferResult result = run(Direction::upload, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

// The block is closed: whether the slave took the last telegram or refused it cannot be known (next test).
TEST_F(LostAnswers, ABlockIsWrittenOnceMoreWhenTheAnswerToItsLastTelegramWasLost) {
  settings.command_channel.block_retries = 0;
  fate = [](std::size_t n) { return n == 3 ? Fate::answer_lost : Fate::arrives; };
  std::vector<std::uint8_t> data = pattern(12);
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.repeated_blocks, 1u);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

TEST_F(LostAnswers, ADownloadRefusedAtItsEndIsNeverDoneBecauseTheRefusalWasLost) {
  drive.at_last = [] { return TransferError::not_possible; };
  fate = [](std::size_t n) { return n == 3 ? Fate::answer_lost : Fate::arrives; };
  std::vector<std::uint8_t> data = pattern(12);
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::slave_error);
  EXPECT_EQ(result.error, TransferError::not_possible);
}

// A slave that repeats the offset that was sent says nothing about where it stands.
TEST_F(LostAnswers, ACounterThatIsNotTheNextOffsetIsNoReasonToGoOn) {
  drive.names_the_counter = false;
  fate = [](std::size_t n) { return n == 4 ? Fate::answer_lost : Fate::arrives; };
  std::vector<std::uint8_t> data = pattern(60);
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.repeated_blocks, 1u);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

// Nothing was lost: the slave skips six bytes that it never got.
TEST_F(LostAnswers, TheNextOffsetIsNotTakenFromASlaveThatAnsweredEverything) {
  std::vector<std::uint8_t> data = pattern(60);
  start();
  rig->answer = [this, skipped = false](const Telegram& t) mutable -> std::optional<Telegram> {
    const auto* block = std::get_if<DownloadBlock>(&t);
    if (block != nullptr && block->offset.value() == 12 && !skipped) {
      skipped = true;
      drive.expected = 18;
    }
    return drive(t);
  };
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.repeated_blocks, 1u);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

TEST_F(LostAnswers, WithoutEndEndTheBlockWhenItsTimeIsOver) {
  settings.command_channel.transfer_monitoring = std::chrono::milliseconds(500);
  settings.command_channel.block_retries = 1;
  fate = [](std::size_t n) { return n % 4 == 3 ? Fate::answer_lost : Fate::arrives; };
  std::vector<std::uint8_t> data(60);
  start();
  const IntervalNumber from = rig->next_interval;
  const TransferResult result = run(Direction::upload, data);
  EXPECT_EQ(result.outcome, Outcome::timeout);
  EXPECT_NEAR(static_cast<double>(rig->next_interval - from), 1000, 10);  // twice 500
}

// M 3.2.1.3, note 1: what the slave fixed belongs to the block it fixed it for.
TEST_F(LostAnswers, ALengthFixedForABlockDoesNotOutliveIt) {
  settings.command_channel.transfer_monitoring = std::chrono::milliseconds(200);
  settings.startup.lost_after = 255;
  drive.memory = pattern(drive.memory.size());
  drive.fixed_lengths = {102};
  start();
  rig->answer = [this](const Telegram& t) -> std::optional<Telegram> {
    if (const auto status = MasterRig::status_only(t)) return status;
    // After the length was fixed, nothing more until the block's time is over.
    const auto* block = std::get_if<UploadBlock>(&t);
    if (block != nullptr && drive.length == 102) return std::nullopt;
    return drive(t);
  };
  std::vector<std::uint8_t> data(600);
  const TransferResult result = run(Direction::upload, data, 300);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.bytes, 600u);
  EXPECT_EQ(result.repeated_blocks, 1u);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), in_drive()));
}

/// How transfers of one kind ended.
struct Ends {
  unsigned transfers = 0;
  unsigned done = 0;
  unsigned slave_lost = 0;  ///< three telegrams in a row without an answer; of a download before its data
  unsigned no_answer = 0;   ///< of a download: likewise, or its time was over, behind a part of its data
  unsigned timeout = 0;
};

struct TenPercent : LostAnswers {
  std::map<std::string, Ends> ends;

  /// One transfer of random length in blocks of up to `longest_block` bytes, whose telegrams and answers get
  /// lost; what it read and wrote is compared byte for byte.
  void transfer(unsigned seed, Direction direction, bool requests_too, unsigned longest_block) {
    std::mt19937 random(seed);
    const auto number = [&](unsigned from, unsigned to) { return from + random() % (to - from + 1); };
    rig.reset();
    drive = {};
    drive.refuses_a_second_initialise = number(0, 1) == 1;
    // Without that number a download is begun anew as an upload is.
    drive.names_the_counter = longest_block > 300 || number(0, 3) != 0;
    drive.remembers = number(0, 3) == 0;
    settings.slaves[2].block_limit = 4092;
    fate = [&](std::size_t) {
      if (requests_too && random() % 10 == 0) return Fate::request_lost;
      return random() % 10 == 0 ? Fate::answer_lost : Fate::arrives;
    };
    const auto block = static_cast<std::uint16_t>(number(1, longest_block));
    const std::vector<std::uint8_t> right = pattern(number(1, 1000), seed);
    std::vector<std::uint8_t> data = right;
    if (direction == Direction::upload) {
      std::copy(right.begin(), right.end(), drive.memory.begin() + kAddress);
      std::fill(data.begin(), data.end(), std::uint8_t{0});
    }
    const std::vector<std::uint8_t> before = drive.memory;
    const TransferResult result = run(direction, data, block);
    for (std::size_t i = 0; i < drive.memory.size(); ++i) {
      const bool ours = i >= kAddress && i < kAddress + right.size();
      ASSERT_TRUE(drive.memory[i] == before[i] || (ours && drive.memory[i] == right[i - kAddress]))
          << "seed " << seed << ": byte " << i << " was written wrongly";
    }
    Ends& count = ends[std::string(direction == Direction::upload ? "upload" : "download") +
                       (requests_too ? ", telegrams and answers lost" : ", answers lost")];
    ++count.transfers;
    if (result.outcome == Outcome::slave_lost) ++count.slave_lost;
    if (result.outcome == Outcome::timeout) ++count.timeout;
    if (result.outcome == Outcome::no_answer) ++count.no_answer;
    const bool has_nothing = result.outcome == Outcome::slave_lost || result.outcome == Outcome::timeout;
    if (direction == Direction::download && has_nothing) {
      ASSERT_EQ(drive.memory, before) << "seed " << seed << ": the slave has a part of it";
    }
    if (result.outcome != Outcome::done) return;
    ++count.done;
    ASSERT_EQ(result.bytes, right.size()) << "seed " << seed;
    ASSERT_EQ(data, right) << "seed " << seed;
    ASSERT_TRUE(std::equal(right.begin(), right.end(), in_drive())) << "seed " << seed;
  }

  void run_all(unsigned longest_block) {
    for (unsigned seed = 1; seed <= 400; ++seed) {
      transfer(seed, seed % 2 == 0 ? Direction::upload : Direction::download, seed % 4 >= 2, longest_block);
      if (HasFatalFailure()) return;
    }
    for (const auto& [what, count] : ends) {
      RecordProperty(what, std::to_string(count.done) + " of " + std::to_string(count.transfers) + " done");
      EXPECT_EQ(count.done + count.slave_lost + count.no_answer + count.timeout, count.transfers) << what;
    }
  }
};

TEST_F(TenPercent, EveryTransferInBlocksOfUpTo300BytesEndsDone) {
  settings.startup.lost_after = 255;
  run_all(300);
  for (const auto& [what, count] : ends) EXPECT_EQ(count.done, count.transfers) << what;
}

// A long block of an upload hardly comes whole: it ends as timeout.
TEST_F(TenPercent, EveryTransferInLongBlocksEndsRightOrWithAnError) {
  settings.startup.lost_after = 255;
  settings.command_channel.transfer_monitoring = std::chrono::seconds(2);
  run_all(4092);
  for (const auto& [what, count] : ends) {
    EXPECT_EQ(count.slave_lost, 0u) << what;
    if (what.starts_with("download")) {
      EXPECT_EQ(count.done, count.transfers) << what;
    }
  }
}

TEST_F(TenPercent, ASlaveThatCountsAsLostMeanwhileEndsItWithAnError) {
  run_all(300);
  for (const auto& [what, count] : ends) {
    EXPECT_EQ(count.timeout, 0u) << what;
    EXPECT_GE(count.done, 20u) << what;
  }
}

}  // namespace
}  // namespace cansync::test
