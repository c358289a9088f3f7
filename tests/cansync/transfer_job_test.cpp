#include <algorithm>
#include <numeric>

#include "master_rig.h"

namespace cansync::test {
namespace {

using Direction = TransferRequest::Direction;

std::vector<std::uint8_t> pattern(std::size_t size) {
  std::vector<std::uint8_t> data(size);
  for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(i * 7 + i / 256);
  return data;
}

/// An answer the test scripts: nothing = the memory answers; an empty inner value = silence.
using Scripted = std::optional<std::optional<Telegram>>;
const Scripted kSilence{std::in_place};

/// The slave's half of a transfer, as plain as the telegram tables: memory, an open block, strict offsets.
struct Memory {
  std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(70'000);
  std::uint32_t address = 0;
  std::uint16_t length = 0;
  std::uint16_t expected = 0;
  std::uint16_t fixed_length = 0;  ///< length the slave says after an upload's initialise
  std::vector<Telegram> asked;
  /// Comes before the memory; returns an answer of its own, or nothing to let the memory answer.
  std::function<Scripted(const Telegram&)> before = [](const Telegram&) { return std::nullopt; };

  static TransferReply acknowledge(SlaveNumber number, BlockOffset offset) {
    return {number, offset, false, false, 0, {}};
  }
  static TransferReply error(SlaveNumber number, BlockOffset offset, TransferError code) {
    TransferReply reply{number, offset, false, true, 2, {}};
    store_word(reply.payload.data(), static_cast<std::uint16_t>(code));
    return reply;
  }

  std::optional<Telegram> operator()(const Telegram& telegram) {
    asked.push_back(telegram);
    if (const auto scripted = before(telegram)) return *scripted;
    if (const auto* initialise = std::get_if<TransferInitialise>(&telegram)) {
      address = initialise->address;
      expected = 0;
      length = fixed_length != 0 ? fixed_length : initialise->length.value();
      return acknowledge(initialise->slave, *BlockOffset::from(fixed_length));
    }
    if (const auto* block = std::get_if<UploadBlock>(&telegram)) {
      if (block->offset.value() != expected) {
        return error(block->slave, block->offset, TransferError::other_block_expected);
      }
      expected = static_cast<std::uint16_t>(expected + 6);
      TransferReply reply{block->slave, block->offset, false, false, 6, {}};
      for (unsigned i = 0; i < 6; ++i) reply.payload[i] = bytes[address + block->offset.value() + i];
      return reply;
    }
    const auto* block = std::get_if<DownloadBlock>(&telegram);
    if (block == nullptr) return MasterRig::status_only(telegram);
    for (unsigned i = 0; i < 6 && block->offset.value() + i < length; ++i) {
      bytes[address + block->offset.value() + i] = block->data[i];
    }
    return acknowledge(block->slave, block->offset);
  }
};

struct Transfers : testing::Test {
  MasterSettings settings = settings_for(4);
  std::shared_ptr<Memory> memory = std::make_shared<Memory>();
  std::unique_ptr<MasterRig> rig;

  void start() {
    settings.startup.status_period = Duration(0);
    rig = std::make_unique<MasterRig>(settings);
    rig->activate();
    rig->answer = [m = memory](const Telegram& t) { return (*m)(t); };
  }
  TransferResult run(Direction direction, std::span<std::uint8_t> data, std::uint16_t block_size = 0,
                     std::uint32_t address = 0x1000) {
    if (!rig) start();
    rig->told.transfers.clear();
    EXPECT_EQ(rig->master.submit(TransferRequest{.id = 1,
                                                 .direction = direction,
                                                 .slave = slave(2),
                                                 .address = address,
                                                 .block_size = block_size,
                                                 .data = data}),
              Refusal::none);
    rig->run_until([this] { return rig->told.transfers.contains(1); }, 200'000);
    return rig->told.transfers[1];
  }
};

TEST_F(Transfers, EveryBlockLengthTakesExactlyOneIntervalForItsStartAndOneForSixBytes) {
  settings.slaves[2].block_limit = 4092;
  std::vector<std::uint8_t> data = pattern(4092);
  for (std::uint32_t n = 1; n <= 4092; n += n < 320 ? 1 : 41) {
    const TransferResult result = run(Direction::download, std::span(data).first(n), 4092);
    ASSERT_EQ(result.outcome, Outcome::done);
    ASSERT_EQ(result.intervals, 1 + (n + 5) / 6) << n << " bytes";
    ASSERT_EQ(result.bytes, n);
  }
}

TEST_F(Transfers, SeveralBlocksTakeNoIntervalMoreThanTheirTelegrams) {
  std::vector<std::uint8_t> data = pattern(65'536);
  const std::uint32_t blocks = 65'536 / 300;
  const std::uint32_t rest = 65'536 % 300;
  const std::uint32_t expected = blocks * (1 + 50) + 1 + (rest + 5) / 6;
  const TransferResult down = run(Direction::download, data);
  EXPECT_EQ(down.outcome, Outcome::done);
  EXPECT_EQ(down.intervals, expected);
  std::vector<std::uint8_t> back(data.size());
  const TransferResult up = run(Direction::upload, back);
  EXPECT_EQ(up.intervals, expected);
  EXPECT_EQ(back, data);
  EXPECT_EQ(rig->told.progress.at(1), 65'536u);
}

TEST_F(Transfers, TelegramsAreThoseOfTheManual) {
  std::vector<std::uint8_t> data = {1, 2, 3, 4, 5, 6, 7, 8};
  run(Direction::download, data, 0, 0x01020304 & 0xFFFF);
  ASSERT_EQ(memory->asked.size(), 3u);
  EXPECT_EQ(encode(memory->asked[0]),
            (can::Frame{.id = 0x502, .dlc = 8, .data = {0xD0, 8, 0x04, 0x03, 0, 0, 0, 0}}));
  EXPECT_EQ(encode(memory->asked[1]),
            (can::Frame{.id = 0x502, .dlc = 8, .data = {0xE0, 0, 1, 2, 3, 4, 5, 6}}));
  EXPECT_EQ(encode(memory->asked[2]),
            (can::Frame{.id = 0x502, .dlc = 8, .data = {0xF0, 6, 7, 8, 0, 0, 0, 0}}));
  memory->asked.clear();
  run(Direction::upload, data);
  EXPECT_EQ(encode(memory->asked[0]),
            (can::Frame{.id = 0x502, .dlc = 8, .data = {0x90, 8, 0x00, 0x10, 0, 0, 0, 0}}));
  EXPECT_EQ(encode(memory->asked[1]), (can::Frame{.id = 0x502, .dlc = 2, .data = {0xA0, 0}}));
  EXPECT_EQ(encode(memory->asked[2]), (can::Frame{.id = 0x502, .dlc = 2, .data = {0xB0, 6}}));
}

TEST_F(Transfers, UploadTakesNoMoreThanTheLastBlockNeeds) {
  memory->bytes.assign(70'000, 0xEE);
  std::vector<std::uint8_t> data(16, 0x11);
  EXPECT_EQ(run(Direction::upload, std::span(data).first(7)).outcome, Outcome::done);
  EXPECT_EQ(std::count(data.begin(), data.end(), 0xEE), 7);
}

TEST_F(Transfers, TheSlaveMayFixAShorterLength) {
  memory->fixed_length = 20;
  memory->bytes.assign(70'000, 0xEE);
  std::vector<std::uint8_t> data(1000);
  const TransferResult result = run(Direction::upload, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.bytes, 20u);
  EXPECT_EQ(result.intervals, 1u + 4u);
}

TEST_F(Transfers, ALengthFixedByTheSlaveThatDoesNotFitIsAnErrorAndIsCancelled) {
  memory->fixed_length = 20;
  std::vector<std::uint8_t> data(10);
  const TransferResult result = run(Direction::upload, data);
  EXPECT_EQ(result.outcome, Outcome::slave_error);
  EXPECT_EQ(result.error, TransferError::block_too_long);
  EXPECT_EQ(memory->asked.back(), Telegram(cancel_transfer(slave(2))));
}

TEST_F(Transfers, BusyRepeatsTheSameTelegram) {
  std::vector<std::uint8_t> data = pattern(12);
  memory->before = [n = 0](const Telegram& telegram) mutable -> Scripted {
    if (++n % 3 == 0) return std::nullopt;
    const auto* block = std::get_if<DownloadBlock>(&telegram);
    return TransferReply{slave(2), block != nullptr ? block->offset : BlockOffset{}, true, false, 0, {}};
  };
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.intervals, 9u);
  EXPECT_EQ(result.repeated_telegrams, 0u);
}

TEST_F(Transfers, ALostTelegramOrAnswerIsRepeated) {
  std::vector<std::uint8_t> data = pattern(30);
  memory->before = [n = 0](const Telegram&) mutable -> Scripted { return ++n == 3 ? kSilence : Scripted(); };
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.repeated_telegrams, 1u);
  EXPECT_EQ(result.intervals, 1u + 5u + 1u);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), memory->bytes.begin() + 0x1000));
}

TEST_F(Transfers, AnErrorOfOrderIsRepeatedOnceThenTheBlockIsBegunAgain) {
  std::vector<std::uint8_t> data = pattern(30);
  memory->before = [errors = 0](const Telegram& telegram) mutable -> Scripted {
    const auto* block = std::get_if<DownloadBlock>(&telegram);
    if (block == nullptr || block->offset.value() != 12 || errors == 2) return std::nullopt;
    ++errors;
    return Memory::error(slave(2), block->offset, TransferError::other_block_expected);
  };
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.repeated_telegrams, 1u);
  EXPECT_EQ(result.repeated_blocks, 1u);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), memory->bytes.begin() + 0x1000));
}

TEST_F(Transfers, AnErrorThatStaysEndsTheJobWithItsPlaceAndACancelTelegram) {
  std::vector<std::uint8_t> data = pattern(600);
  memory->before = [](const Telegram& telegram) -> Scripted {
    const auto* block = std::get_if<DownloadBlock>(&telegram);
    if (block == nullptr || block->offset.value() != 12) return std::nullopt;
    return Memory::error(slave(2), block->offset, TransferError::mode_not_allowed);
  };
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::slave_error);
  EXPECT_EQ(result.error, TransferError::mode_not_allowed);
  EXPECT_EQ(result.error_offset, 12u);
  EXPECT_EQ(result.bytes, 0u);
  EXPECT_EQ(memory->asked.back(), Telegram(cancel_transfer(slave(2))));
}

TEST_F(Transfers, AnErrorAboutTheJobItselfIsNotRepeated) {
  for (const auto error :
       {TransferError::longer_than_300_bytes, TransferError::cancelled_by_slave, TransferError::not_possible,
        TransferError::address_not_allowed, TransferError::block_too_long}) {
    rig.reset();
    memory->asked.clear();
    std::vector<std::uint8_t> data = pattern(6);
    memory->before = [error](const Telegram& telegram) -> Scripted {
      if (telegram == Telegram(cancel_transfer(slave(2)))) return std::nullopt;
      return Memory::error(slave(2), {}, error);
    };
    const TransferResult result = run(Direction::upload, data);
    EXPECT_EQ(result.outcome, Outcome::slave_error);
    EXPECT_EQ(result.error, error);
    EXPECT_EQ(memory->asked.size(), 2u);  // initialise, cancel
  }
}

TEST_F(Transfers, ASilentSlaveTimesOutAfterItsRetriesAndIsSentACancel) {
  settings.command_channel.transfer_monitoring = std::chrono::milliseconds(50);
  settings.startup.lost_after = 255;
  std::vector<std::uint8_t> data = pattern(60);
  memory->before = [](const Telegram&) { return kSilence; };
  start();
  const IntervalNumber from = rig->next_interval;
  const TransferResult result = run(Direction::download, data);
  EXPECT_EQ(result.outcome, Outcome::timeout);
  EXPECT_EQ(result.repeated_blocks, 1u);
  EXPECT_NEAR(static_cast<double>(rig->next_interval - from), 104, 4);  // twice 50, and the cancels
  EXPECT_EQ(memory->asked.back(), Telegram(cancel_transfer(slave(2))));
}

TEST_F(Transfers, CancelTellsTheSlaveAndEndsOnce) {
  std::vector<std::uint8_t> data = pattern(3000);
  start();
  for (JobId id = 1; id <= 2; ++id) {
    ASSERT_EQ(
        rig->master.submit(TransferRequest{
            .id = id, .direction = Direction::download, .slave = slave(2), .address = 0x1000, .data = data}),
        Refusal::none);
  }
  rig->run(20);
  EXPECT_EQ(rig->master.cancel(2), Refusal::none);
  EXPECT_EQ(rig->told.transfers.at(2).outcome, Outcome::cancelled);
  EXPECT_EQ(rig->master.cancel(1), Refusal::none);
  rig->run(3);
  EXPECT_EQ(rig->told.transfers.at(1).outcome, Outcome::no_answer) << "a part of it is in the slave";
  EXPECT_GT(rig->told.transfers.at(1).bytes, 0u);
  EXPECT_EQ(memory->asked.back(), Telegram(cancel_transfer(slave(2))));
  const std::size_t asked = memory->asked.size();
  rig->run(20);
  EXPECT_EQ(memory->asked.size(), asked);
}

/// Every answer is busy, also that to the cancel telegram.
TEST_F(Transfers, ASlaveThatIsBusyForEverKeepsNoTransferFromEnding) {
  settings.command_channel.cancel_at_start = true;
  settings.command_channel.transfer_monitoring = std::chrono::milliseconds(50);
  std::vector<std::uint8_t> data = pattern(60);
  start();
  // Those of the start are over.
  rig->run(10);
  bool busy = true;
  memory->before = [&](const Telegram& telegram) -> Scripted {
    if (!busy || MasterRig::status_only(telegram)) return std::nullopt;
    return Scripted{TransferReply{slave(2), *BlockOffset::from(0), true, false, 0, {}}};
  };
  const IntervalNumber from = rig->next_interval;
  const TransferResult timed_out = run(Direction::download, data);
  EXPECT_EQ(timed_out.outcome, Outcome::timeout);
  // Twice 50, and twice a second for the cancel telegram.
  EXPECT_NEAR(static_cast<double>(rig->next_interval - from), 2100, 10);

  settings.command_channel.transfer_monitoring = std::chrono::hours(1);
  rig.reset();
  busy = false;
  start();
  rig->run(10);
  busy = true;
  ASSERT_EQ(rig->master.submit(TransferRequest{.id = 1, .slave = slave(2), .address = 0x1000, .data = data}),
            Refusal::none);
  rig->run(20);
  ASSERT_EQ(rig->master.cancel(1), Refusal::none);
  rig->run(500);
  EXPECT_FALSE(rig->told.transfers.contains(1));
  // Again and again does not make it last longer.
  ASSERT_EQ(rig->master.cancel(1), Refusal::none);
  rig->run_until([this] { return rig->told.transfers.contains(1); }, 510);
  ASSERT_TRUE(rig->told.transfers.contains(1));
  EXPECT_EQ(rig->told.transfers.at(1).outcome, Outcome::cancelled);
  // The slave may have the block open: it is told again before the next transfer begins.
  busy = false;
  memory->asked.clear();
  EXPECT_EQ(run(Direction::download, data).outcome, Outcome::done);
  EXPECT_NE(std::find(memory->asked.begin(), memory->asked.end(), Telegram(cancel_transfer(slave(2)))),
            memory->asked.end());
}

/// The cancel telegram is never let out.
TEST_F(Transfers, ACancelledTransferEndsAlsoWhileNoSlaveHasATurn) {
  settings.command_channel.cancel_at_start = true;
  std::vector<std::uint8_t> data = pattern(600);
  start();
  ASSERT_EQ(rig->master.submit(TransferRequest{.id = 1, .slave = slave(2), .address = 0x1000, .data = data}),
            Refusal::none);
  rig->run(20);
  const Cursor nobody{Cursor::Kind::nobody, {}};
  ASSERT_EQ(rig->master.set_command_cursors({}, {}, nobody), Refusal::none);
  ASSERT_EQ(rig->master.cancel(1), Refusal::none);
  rig->run(1010);
  ASSERT_TRUE(rig->told.transfers.contains(1));
  EXPECT_EQ(rig->told.transfers.at(1).outcome, Outcome::cancelled);
  // It was told all the same, as a slave whose state is not known.
  EXPECT_EQ(memory->asked.back(), Telegram(cancel_transfer(slave(2))));
}

TEST_F(Transfers, AddressStepCountsDoublewordsWhenSet) {
  settings.command_channel.address_step = 4;
  std::vector<std::uint8_t> data = pattern(600);
  run(Direction::download, data);
  std::vector<std::uint32_t> starts;
  for (const Telegram& telegram : memory->asked) {
    if (const auto* initialise = std::get_if<TransferInitialise>(&telegram))
      starts.push_back(initialise->address);
  }
  EXPECT_EQ(starts, (std::vector<std::uint32_t>{0x1000, 0x1000 + 75}));
}

TEST_F(Transfers, RefusalsSendNothing) {
  start();
  std::vector<std::uint8_t> data = pattern(64);
  const auto submit = [&](std::uint32_t address, std::size_t size, std::uint16_t block, unsigned number) {
    return rig->master.submit(TransferRequest{.id = 1,
                                              .direction = Direction::upload,
                                              .slave = slave(number),
                                              .address = address,
                                              .block_size = block,
                                              .data = std::span(data).first(size)});
  };
  EXPECT_EQ(submit(0x1000, 0, 0, 1), Refusal::length_zero);
  EXPECT_EQ(submit(0xFF, 10, 0, 1), Refusal::address_reserved);
  EXPECT_EQ(submit(0xFFFFFFFF, 2, 0, 1), Refusal::address_overflow);
  EXPECT_EQ(submit(0x1000, 10, 301, 1), Refusal::block_size);
  EXPECT_EQ(submit(0x1000, 10, 0, 5), Refusal::slave_not_configured);
  rig->run(5);
  EXPECT_TRUE(memory->asked.empty());
}

TEST_F(Transfers, ReservedAddressesAreAllowedWhenSet) {
  settings.command_channel.allow_reserved_addresses = true;
  std::vector<std::uint8_t> data = pattern(6);
  EXPECT_EQ(run(Direction::download, data, 0, 0x10).outcome, Outcome::done);
}

}  // namespace
}  // namespace cansync::test
