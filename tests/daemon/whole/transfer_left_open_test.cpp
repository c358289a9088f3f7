// A drive whose transfer was left open by a master that is gone, and the next master started anew, in virtual
// time.
#include <gtest/gtest.h>

#include <algorithm>
#include <variant>
#include <vector>

#include "cansync/telegram/telegram.h"
#include "support/virtual_line.h"

namespace cansyncd::test {
namespace {

using namespace cansync;
using support::drives_for;
using support::line_settings;
using support::VirtualLine;
using Direction = TransferRequest::Direction;

constexpr std::uint32_t kAddress = 0x1000;

SlaveNumber slave(unsigned n) {
  return *SlaveNumber::from(n);
}

/// What a master sends that dies after a few telegrams of a download. Returns whether the drive took them.
bool leave_open(sim::Node& drive) {
  const auto takes = [&drive](const Telegram& telegram) {
    const auto answer = drive.on_frame(encode(telegram), can::Time{0});
    if (!answer) return false;
    const Decoded decoded = decode(answer->frame);
    const auto* any = std::get_if<Telegram>(&decoded);
    const auto* reply = any != nullptr ? std::get_if<TransferReply>(any) : nullptr;
    return reply != nullptr && !reply->error;
  };
  const SlaveNumber number = slave(drive.node_number());
  DownloadBlock block;
  block.slave = number;
  block.data.fill(0xEE);
  return takes(TransferInitialise{number, Direction::download, *BlockOffset::from(300), kAddress, {}}) &&
         takes(block);
}

TEST(TransferLeftOpen, TheNextMasterCancelsFirstAndThenTransfersExactly) {
  const MasterSettings settings = line_settings(BitRate::mbit1, 3);
  auto nodes = drives_for(settings);
  ASSERT_TRUE(leave_open(*nodes[1]));
  VirtualLine line(settings, std::move(nodes));

  std::vector<std::uint8_t> data(2000);
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(i * 31 + 5);
  std::vector<std::uint8_t> read(data.size());
  std::vector<can::Frame> transfers;  // telegrams to the drive, in their order
  line.on_frame = [&](const sim::TracedFrame& traced, can::Time) {
    const bool transfer = traced.frame.id == identifier::command + 1 && (traced.frame.data[0] & 0x80) != 0;
    if (transfer) transfers.push_back(traced.frame);
  };
  std::vector<Outcome> outcomes;
  const auto begin = [&](JobId id, Direction direction, std::vector<std::uint8_t>& bytes) {
    ASSERT_TRUE(line.exchange().requests.try_push(TransferRequest{
        .id = id, .direction = direction, .slave = slave(1), .address = kAddress, .data = bytes}));
  };
  line.on_edge = [&](std::uint64_t edge) {
    // As early as transfers are taken at all.
    if (edge == 2) begin(1, Direction::download, data);
    Terminal terminal;
    while (line.exchange().terminals.try_pop(terminal)) {
      const auto* done = std::get_if<TransferDone>(&terminal);
      ASSERT_NE(done, nullptr);
      outcomes.push_back(done->result.outcome);
      if (done->id == 1) begin(2, Direction::upload, read);
    }
  };
  line.run(1500);

  EXPECT_EQ(outcomes, (std::vector{Outcome::done, Outcome::done}));
  ASSERT_FALSE(transfers.empty());
  EXPECT_EQ(transfers.front(), encode(cancel_transfer(slave(1))));
  EXPECT_EQ(std::count(transfers.begin(), transfers.end(), encode(cancel_transfer(slave(1)))), 1);
  EXPECT_TRUE(std::equal(data.begin(), data.end(), line.drive(1).memory().contents().begin() + 0xF00));
  EXPECT_EQ(read, data);
}

TEST(TransferLeftOpen, EveryDriveIsToldOnceAlsoWhenNobodyTransfers) {
  const MasterSettings settings = line_settings(BitRate::mbit1, 3);
  VirtualLine line(settings, drives_for(settings));
  unsigned cancels = 0;
  line.on_frame = [&](const sim::TracedFrame& traced, can::Time) {
    for (unsigned i = 0; i < 3; ++i) cancels += traced.frame == encode(cancel_transfer(slave(i))) ? 1 : 0;
  };
  line.run(300);
  EXPECT_EQ(cancels, 3u);
}

}  // namespace
}  // namespace cansyncd::test
