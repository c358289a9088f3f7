#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cansync/sim/drive_faults.h"
#include "cansync/sim/master_node.h"
#include "cansync/slave/slave_service.h"
#include "cansync/slave/slave_supervision.h"
#include "sim/line.h"
#include "slot_judge.h"

namespace sim::test {

using cansync::BitRate;
using cansync::Channel;
using cansync::ParameterDefinition;
using cansync::SlaveNumber;

inline constexpr std::uint16_t kStatusWord = 301;

/// How a slave under test is built.
struct SlaveUnderTest {
  cansync::SlaveSideSettings slave;
  cansync::SlaveServiceSettings service;
  cansync::SlaveSupervisionSettings supervision;
  can::Time delay{};  ///< from the end of a frame until the answer is ready
};

/// A slave on a line: core, supervision and service, and an application that answers as a test says. What the
/// service tells ends up in queues, as it would on its way to another process.
class SlaveNode final : public Node, private cansync::SlaveServiceListener {
 public:
  explicit SlaveNode(const SlaveUnderTest& settings)
      : delay(settings.delay),
        supervision(settings.supervision),
        service(settings.service, *this),
        slave(settings.slave, service) {
    using cansync::ControlCommand;
    for (const auto command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                               ControlCommand::start_synchronous, ControlCommand::enable_active}) {
      slave.control(command);
    }
  }

  /// The application's turn, once in each interval, after its edge.
  std::function<void(SlaveNode&)> application;
  bool sends_late = false;      ///< a mutant that does not keep its slots
  bool releases_older = false;  ///< a mutant that gives what was to be released an interval before
  bool release = true;          ///< the application releases its actual values in each interval
  cansync::Values actual = {0x1000, 0x2000, 0, 0, 0x3000, 0x4000, 0, 0};

  std::optional<cansync::AskedParameter> parameter;  ///< waits for the application
  std::optional<cansync::AskedBlock> block;
  std::optional<std::uint64_t> complete;
  std::optional<cansync::AskedStep> step;
  std::map<cansync::BlockEnd, unsigned> ends;
  std::map<std::uint64_t, unsigned> told;  ///< how often the end of each access was told
  unsigned jobs_dropped = 0;
  unsigned jobs_answered = 0;
  std::vector<std::uint16_t> control_words;
  std::vector<cansync::SlaveFault> faults;
  std::uint32_t most_misses = 0;
  bool extrapolated = false;

  can::Time delay;
  cansync::SlaveSupervision supervision;
  cansync::SlaveService service;
  cansync::Slave slave;

  NodeNumber node_number() const noexcept override { return slave.settings().number.value(); }
  bool accepts(const can::Frame&) const noexcept override { return true; }
  void on_sync(can::Time now) noexcept override {
    const std::uint32_t passed = supervision.edge(now, slave.sync_activated());
    const bool fresh = slave.reference_fresh(Channel::one);
    supervision.references(passed, fresh);
    most_misses = std::max(most_misses, supervision.misses());
    extrapolated = extrapolated || supervision.extrapolating();
    note_faults();
    slave.on_sync(std::max(passed, 1u));
    service.area().at(now);
    if (application) application(*this);
    if (!release) return;
    const cansync::Values& given = releases_older ? before_ : actual;
    slave.release_actual(Channel::one, given);
    slave.release_actual(Channel::two, given);
    before_ = actual;
  }
  std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override {
    supervision.check(end);
    note_faults();
    service.table().set_value(kStatusWord, supervision.status_word(0x0007));
    const can::Time edge = supervision.last_edge();
    const auto answer = slave.receive(frame, end - edge);
    if (!answer) return std::nullopt;
    const can::Time ready = std::max(end, edge + answer->window.earliest) + delay;
    if (!slave.may_start(*answer, ready - edge) && !sends_late) return std::nullopt;
    return Transmission{answer->frame, ready};
  }
  std::optional<Transmission> on_sent(const can::Frame& frame, can::Time) noexcept override {
    slave.sent(frame);
    return std::nullopt;
  }

 private:
  void note_faults() noexcept {
    const cansync::SlaveFault fault = supervision.take_fault();
    if (fault != cansync::SlaveFault::none) faults.push_back(fault);
  }
  void asked(const cansync::AskedParameter& job) noexcept override { parameter = job; }
  void dropped(std::uint64_t id) noexcept override {
    ++told[id];
    ++jobs_dropped;
    parameter.reset();
  }
  void answered(std::uint64_t id) noexcept override {
    ++told[id];
    ++jobs_answered;
  }
  void block_begun(const cansync::AskedBlock& begun) noexcept override { block = begun; }
  void block_complete(std::uint64_t id) noexcept override { complete = id; }
  void step_asked(std::uint64_t, const cansync::AskedStep& asked) noexcept override { step = asked; }
  void block_ended(std::uint64_t, cansync::BlockEnd end) noexcept override {
    ++ends[end];
    block.reset();
    complete.reset();
    step.reset();
  }
  void control_word(std::uint16_t word) noexcept override { control_words.push_back(word); }
  void action(std::uint8_t, std::uint8_t, std::uint16_t) noexcept override {}
  void sync_activated() noexcept override {}

  cansync::Values before_ = {};
};

/// Notes how the master's jobs end; each must end once.
struct JobEnds final : cansync::MasterListener {
  void actual_values(SlaveNumber slave, const cansync::ActualValues& values) noexcept override {
    ++actual[slave.value()];
    newest = values;
  }
  void slave_status(SlaveNumber, const cansync::SlaveStatus&) noexcept override {}
  void state_changed(cansync::State, cansync::State, cansync::ControlCommand) noexcept override {}
  void parameter_done(cansync::JobId id, const cansync::ParameterResult& result) noexcept override {
    EXPECT_TRUE(parameters.emplace(id, result).second) << "job " << id << " ended twice";
  }
  void transfer_progress(cansync::JobId, std::uint32_t) noexcept override {}
  void transfer_done(cansync::JobId id, const cansync::TransferResult& result) noexcept override {
    EXPECT_TRUE(transfers.emplace(id, result).second) << "job " << id << " ended twice";
  }
  void command_done(cansync::JobId, cansync::Outcome) noexcept override {}
  void event(const cansync::MasterEvent&) noexcept override {}

  std::map<unsigned, unsigned> actual;
  cansync::ActualValues newest;
  std::map<cansync::JobId, cansync::ParameterResult> parameters;
  std::map<cansync::JobId, cansync::TransferResult> transfers;
};

/// A real master and a slave under test on a line in virtual time, judged by the manual's slots.
class SlaveLine {
 public:
  explicit SlaveLine(BitRate rate, unsigned number = 5)
      : times(slot_times(rate)), judge(times.bits_per_second) {
    master_settings.master.bit_rate = rate;
    master_settings.master.send_margin = cansync::default_send_margin(rate);
    const SlaveNumber slave = *SlaveNumber::from(number);
    master_settings.master.slaves[number].configured = true;
    master_settings.master.slaves[number].block_limit = 4092;
    master_settings.master.process.maximum_slave = slave;
    for (auto& cursor : master_settings.master.process.polling)
      cursor = {cansync::Cursor::Kind::fixed, slave};
    master_settings.references[0] = {ReferenceCurve::Kind::ramp, 100, 3};
    master_settings.references[4] = {ReferenceCurve::Kind::constant, 77};
    under_test.slave.number = slave;
    under_test.slave.bit_rate = rate;
    under_test.slave.block_limit = 4095;
    under_test.supervision.interval = times.interval;
    under_test.supervision.lock_time = times.interval * 20;
    under_test.delay = times.bit_time() * 20;
    ParameterDefinition status;
    status.number = kStatusWord;
    status.access = ParameterDefinition::Access::read_only;
    under_test.service.parameters = {status};
    line_settings.bits_per_second = times.bits_per_second;
    line_settings.protocol = &drive_faults();
    line_settings.trace = &judge;
    line_settings.user_number = 30;
  }
  ~SlaveLine() {
    for (const std::string& what : judge.wrong) ADD_FAILURE() << what;
    if (slave_ == nullptr) return;
    for (const auto& [id, times_told] : slave_->told) EXPECT_EQ(times_told, 1u) << "access " << id;
  }
  SlaveLine(const SlaveLine&) = delete;
  SlaveLine& operator=(const SlaveLine&) = delete;

  /// Makes line and nodes of the settings and runs until active operation.
  void start() {
    build();
    ASSERT_TRUE(
        run_until([this] { return is_active(master().state()) && slave_->supervision.synchronized(); }));
    run(5);
  }
  void build() {
    std::vector<std::unique_ptr<Node>> nodes;
    auto master = std::make_unique<MasterNode>(master_settings, &ends);
    auto slave = std::make_unique<SlaveNode>(under_test);
    master_ = master.get();
    slave_ = slave.get();
    nodes.push_back(std::move(master));
    nodes.push_back(std::move(slave));
    line_ = std::make_unique<Line>(line_settings, std::move(nodes));
  }
  void run(unsigned intervals = 1) {
    // To just before an edge, so that whole intervals have passed.
    const can::Time until = line_->now() + times.interval * static_cast<int>(intervals);
    can::ReceivedFrame received;
    while (line_->now() < until) {
      line_->wait_until(until);
      while (line_->receive(received)) {
      }
    }
  }
  template <class Done>
  bool run_until(Done done, unsigned most = 20'000) {
    for (unsigned i = 0; i < most; ++i) {
      if (done()) return true;
      run();
    }
    return done();
  }

  cansync::Master& master() { return master_->master(); }
  MasterNode& master_node() { return *master_; }
  SlaveNode& slave() { return *slave_; }
  Line& line() { return *line_; }
  const cansync::ActualCounters& one() { return slave_->slave.counters(Channel::one); }
  const cansync::ActualCounters& two() { return slave_->slave.counters(Channel::two); }

  cansync::ParameterRequest request(unsigned number) {
    cansync::ParameterRequest result;
    result.id = ++ids_;
    result.slave = under_test.slave.number;
    result.number = *cansync::ParameterNumber::from(number);
    return result;
  }
  /// Runs until the job has ended.
  cansync::ParameterResult end_of(const cansync::ParameterRequest& request) {
    EXPECT_EQ(master().submit(request), cansync::Refusal::none);
    EXPECT_TRUE(run_until([&] { return ends.parameters.contains(request.id); }));
    return ends.parameters[request.id];
  }
  cansync::TransferRequest transfer(bool download, std::span<std::uint8_t> data) {
    cansync::TransferRequest result;
    result.id = ++ids_;
    result.direction = download ? cansync::TransferRequest::Direction::download
                                : cansync::TransferRequest::Direction::upload;
    result.slave = under_test.slave.number;
    result.address = 0x100;
    result.block_size = 4092;
    result.data = data;
    return result;
  }
  cansync::TransferResult end_of(const cansync::TransferRequest& request, unsigned most = 60'000) {
    EXPECT_EQ(master().submit(request), cansync::Refusal::none);
    EXPECT_TRUE(run_until([&] { return ends.transfers.contains(request.id); }, most));
    return ends.transfers[request.id];
  }

  const cansync::SlotTimes& times;
  MasterNodeSettings master_settings;
  SlaveUnderTest under_test;
  LineSettings line_settings;
  SlotJudge judge;
  JobEnds ends;

 private:
  cansync::JobId ids_ = 0;
  MasterNode* master_ = nullptr;
  SlaveNode* slave_ = nullptr;
  std::unique_ptr<Line> line_;
};

/// Every test runs at all four bit rates.
class SlaveAcceptance : public ::testing::TestWithParam<BitRate> {};

/// A fault of the line that begins `after` intervals from now, for so many.
inline Fault fault_soon(SlaveLine& line, FaultKind kind, std::uint64_t after, std::uint64_t intervals) {
  Fault fault;
  fault.kind = kind;
  fault.from = line.line().intervals() + after;
  fault.to = fault.from + intervals - 1;
  return fault;
}

/// The slave's own and an application's parameters.
inline void with_parameters(SlaveLine& line) {
  using Access = ParameterDefinition::Access;
  auto& parameters = line.under_test.service.parameters;
  parameters.push_back({400, false, Access::read_write, 7, -5, 100, true, false});
  parameters.push_back({401, true, Access::read_only, 0xCAFEF00D, 0, 0, false, false});
  parameters.push_back({402, false, Access::not_available, 0, 0, 0, false, false});
  parameters.push_back({500, true, Access::read_write, 0, 0, 0, false, true});
  parameters.push_back({4095, false, Access::read_write, 9, 0, 0, false, true});
}

inline std::vector<std::uint8_t> bytes_of(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{3});
  return bytes;
}

/// An application that moves blocks to and from `memory`; it takes `intervals` for each answer.
inline std::function<void(SlaveNode&)> moves_blocks(std::vector<std::uint8_t>& memory,
                                                    unsigned intervals = 0) {
  return [&memory, intervals, waited = 0u](SlaveNode& node) mutable {
    cansync::BlockArea& area = node.service.area();
    if (!node.block) return;
    if (waited++ < intervals) return;
    waited = 0;
    const std::uint64_t id = node.block->id;
    const bool upload = node.block->direction == cansync::AskedBlock::Direction::upload;
    if (area.allow(id, upload && node.block->area ? std::span<const std::uint8_t>(memory)
                                                  : std::span<const std::uint8_t>()))
      return;
    if (node.complete) {
      memory.assign(area.data().begin(), area.data().end());
      EXPECT_TRUE(area.take(id));
      node.complete.reset();
    } else if (node.step) {
      const cansync::AskedStep step = *std::exchange(node.step, std::nullopt);
      if (upload) {
        EXPECT_TRUE(area.step(id, std::span(memory).subspan(step.offset, step.bytes)));
      } else {
        memory.resize(std::max<std::size_t>(memory.size(), step.offset + step.bytes));
        std::copy_n(step.data.begin(), step.bytes, memory.begin() + step.offset);
        EXPECT_TRUE(area.step(id));
      }
    }
  };
}

}  // namespace sim::test
