// Transfers that a master left open: the next one cancels first.
#include <algorithm>
#include <span>

#include "cansync/slave/slave.h"
#include "master_rig.h"

namespace cansync::test {
namespace {

constexpr std::uint32_t kBase = 0x1000;

/// A slave of the real slave side with some memory from start address 0x1000, and every command it answered.
struct MemorySlave final : SlaveApplication {
  explicit MemorySlave(unsigned number) : slave({.number = test::slave(number)}, *this) {
    for (const ControlCommand command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                                         ControlCommand::start_synchronous}) {
      EXPECT_TRUE(slave.control(command));
    }
  }

  Slave slave;
  std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(4096);
  std::uint32_t base = 0;
  unsigned given_up = 0;
  bool dead = false;
  std::vector<Telegram> asked;

  std::optional<Telegram> receive(const Telegram& telegram) {
    if (dead) return std::nullopt;
    const auto answer = slave.receive(telegram, std::chrono::microseconds(100));
    if (answer) asked.push_back(telegram);
    return answer ? std::optional(std::get<Telegram>(decode(answer->frame))) : std::nullopt;
  }

  ParameterAnswer read_parameter(ParameterNumber, Element, SubSlave) noexcept override {
    return {.value = 0x8007};
  }
  ParameterAnswer write_parameter(ParameterNumber, Element, SubSlave, bool, std::uint32_t) noexcept override {
    return {};
  }
  BlockAnswer begin_block(const TransferInitialise& initialise) noexcept override {
    base = initialise.address - kBase;
    return {};
  }
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override {
    std::copy_n(bytes.begin() + base + offset, out.size(), out.begin());
    return {};
  }
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override {
    std::copy(data.begin(), data.end(), bytes.begin() + base + offset);
    return {};
  }
  void end_block(bool complete) noexcept override { given_up += complete ? 0u : 1u; }
  void control_word(std::uint16_t) noexcept override {}
  void action(std::uint8_t, std::uint8_t, std::uint16_t) noexcept override {}
};

bool is_transfer(const Telegram& telegram) {
  return std::holds_alternative<TransferInitialise>(telegram) ||
         std::holds_alternative<DownloadBlock>(telegram) || std::holds_alternative<UploadBlock>(telegram);
}

std::vector<std::uint8_t> pattern(std::size_t size) {
  std::vector<std::uint8_t> out(size);
  for (std::size_t i = 0; i < size; ++i) out[i] = static_cast<std::uint8_t>(i * 7 + 3);
  return out;
}

struct OpenTransfer : testing::Test {
  MasterSettings settings = settings_for(3);
  MemorySlave memory{1};
  std::unique_ptr<MasterRig> rig;
  JobId id = 0;

  /// A master that knows nothing of any other.
  void new_master(bool cancels = true) {
    settings.command_channel.cancel_at_start = cancels;
    settings.startup.status_period = std::chrono::milliseconds(50);
    rig = std::make_unique<MasterRig>(settings);
    rig->answer = [this](const Telegram& t) -> std::optional<Telegram> {
      if (auto answer = memory.receive(t)) return answer;
      return memory.dead ? std::nullopt : MasterRig::status_only(t);
    };
    memory.asked.clear();
  }
  void begin(TransferRequest::Direction direction, std::vector<std::uint8_t>& data) {
    EXPECT_EQ(rig->master.submit(TransferRequest{
                  .id = ++id, .direction = direction, .slave = slave(1), .address = kBase, .data = data}),
              Refusal::none);
  }
  TransferResult run(TransferRequest::Direction direction, std::vector<std::uint8_t>& data) {
    begin(direction, data);
    rig->run_until([this] { return rig->told.transfers.contains(id); }, 2000);
    return rig->told.transfers[id];
  }
  void leave_open() {
    new_master();
    rig->activate();
    std::vector<std::uint8_t> data = pattern(600);
    begin(TransferRequest::Direction::download, data);
    rig->run(30);
    ASSERT_TRUE(memory.slave.transfer_open());
    rig.reset();  // killed: no further telegram
  }
  const Telegram* first_transfer() const {
    const auto first = std::find_if(memory.asked.begin(), memory.asked.end(), is_transfer);
    return first == memory.asked.end() ? nullptr : &*first;
  }
};

TEST_F(OpenTransfer, ANewMasterCancelsWhatAKilledOneLeftOpenBeforeAnythingElse) {
  leave_open();
  new_master();
  rig->set_up();
  std::vector<std::uint8_t> data = pattern(900);
  EXPECT_EQ(run(TransferRequest::Direction::download, data).outcome, Outcome::done);
  ASSERT_NE(first_transfer(), nullptr);
  EXPECT_EQ(*first_transfer(), Telegram(cancel_transfer(slave(1))));
  EXPECT_EQ(memory.given_up, 1u) << "the slave has dropped what was open";
  EXPECT_TRUE(std::equal(data.begin(), data.end(), memory.bytes.begin()));
  std::vector<std::uint8_t> read(900);
  EXPECT_EQ(run(TransferRequest::Direction::upload, read).outcome, Outcome::done);
  EXPECT_EQ(read, data);
  EXPECT_EQ(std::count(memory.asked.begin(), memory.asked.end(), Telegram(cancel_transfer(slave(1)))), 1);
}

TEST_F(OpenTransfer, EachSlaveIsToldOnceRightAfterTheFirstStatusWordsWithoutAnyTransfer) {
  new_master();
  rig->set_up();
  std::vector<Telegram> commands;
  for (int i = 0; i < 60; ++i) {
    rig->step();
    if (rig->command() != nullptr) commands.push_back(*rig->command());
  }
  // Activation, three status words, then the slaves in their order. Slaves 0 and 2 do not answer it.
  ASSERT_GE(commands.size(), 9u);
  const std::vector<Telegram> cancels(commands.begin() + 4, commands.begin() + 9);
  EXPECT_EQ(cancels, (std::vector<Telegram>{cancel_transfer(slave(0)), cancel_transfer(slave(0)),
                                            cancel_transfer(slave(1)), cancel_transfer(slave(2)),
                                            cancel_transfer(slave(2))}));
  EXPECT_EQ(std::count_if(commands.begin(), commands.end(), is_transfer), 5);
  for (unsigned i = 0; i < 3; ++i) {
    EXPECT_TRUE(rig->master.slave(slave(i)).responds) << i << ": a cancel without an answer loses no slave";
  }
}

TEST_F(OpenTransfer, ASlaveThatWasAwayIsToldBeforeItsNextTransfer) {
  new_master();
  rig->activate();
  rig->run(20);
  std::vector<std::uint8_t> data = pattern(600);
  begin(TransferRequest::Direction::download, data);
  rig->run(30);
  memory.dead = true;
  rig->run_until([this] { return rig->told.transfers.contains(id); }, 20);
  EXPECT_EQ(rig->told.transfers[id].outcome, Outcome::no_answer);
  EXPECT_TRUE(memory.slave.transfer_open());
  memory.dead = false;
  memory.asked.clear();
  rig->run_until([this] { return rig->master.slave(slave(1)).responds; }, 200);
  EXPECT_EQ(run(TransferRequest::Direction::download, data).outcome, Outcome::done);
  ASSERT_NE(first_transfer(), nullptr);
  EXPECT_EQ(*first_transfer(), Telegram(cancel_transfer(slave(1))));
  EXPECT_TRUE(std::equal(data.begin(), data.end(), memory.bytes.begin()));
}

TEST_F(OpenTransfer, ARunningTransferOutlivesALostBusUncancelled) {
  new_master();
  rig->activate();
  rig->run(20);
  memory.asked.clear();
  std::vector<std::uint8_t> data = pattern(600);
  begin(TransferRequest::Direction::download, data);
  rig->run(30);
  rig->master.bus_lost();
  rig->run_until([this] { return rig->told.transfers.contains(id); }, 500);
  EXPECT_EQ(rig->told.transfers[id].outcome, Outcome::done);
  EXPECT_EQ(rig->told.transfers[id].repeated_blocks, 0u);
  EXPECT_EQ(std::count(memory.asked.begin(), memory.asked.end(), Telegram(cancel_transfer(slave(1)))), 0);
}

TEST_F(OpenTransfer, ASlaveThatIsBusyForEverDoesNotKeepTheOthersWaiting) {
  new_master();
  unsigned asked = 0;
  rig->answer = [&asked](const Telegram& t) -> std::optional<Telegram> {
    if (t != Telegram(cancel_transfer(slave(1)))) return MasterRig::status_only(t);
    ++asked;
    TransferReply busy;
    busy.slave = slave(1);
    busy.busy = true;
    return busy;
  };
  rig->set_up();
  rig->run(100);
  EXPECT_EQ(asked, 2u);
}

TEST_F(OpenTransfer, SwitchedOffNothingIsCancelled) {
  leave_open();
  new_master(false);
  rig->set_up();
  rig->run(50);
  EXPECT_EQ(first_transfer(), nullptr);
  EXPECT_TRUE(memory.slave.transfer_open());
}

}  // namespace
}  // namespace cansync::test
