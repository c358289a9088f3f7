#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "cansync/sim/cluster_node.h"
#include "leaf_slave.h"
#include "slave_line_rig.h"

namespace sim::test {

inline constexpr std::uint16_t kGatewayA = 5;  ///< slave number on the top line
inline constexpr std::uint16_t kGatewayB = 7;  ///< slave number on the middle line
inline constexpr std::uint16_t kMiddle = 100;  ///< CANsync number of slave 0 on the middle line
inline constexpr std::uint16_t kLowest = 200;  ///< and on the lowest

/// The gateway's own parameters and blocks concern nobody here.
struct NobodyTold final : cansync::SlaveServiceListener {
  void asked(const cansync::AskedParameter&) noexcept override {}
  void dropped(std::uint64_t) noexcept override {}
  void answered(std::uint64_t) noexcept override {}
  void block_begun(const cansync::AskedBlock&) noexcept override {}
  void block_complete(std::uint64_t) noexcept override {}
  void step_asked(std::uint64_t, const cansync::AskedStep&) noexcept override {}
  void block_ended(std::uint64_t, cansync::BlockEnd) noexcept override {}
  void control_word(std::uint16_t word) noexcept override { words.push_back(word); }
  void action(std::uint8_t, std::uint8_t, std::uint16_t) noexcept override {}
  void sync_activated() noexcept override {}
  std::vector<std::uint16_t> words;
};

/// A real master, gateways and slaves on lines of two or three levels, in virtual time.
class Levels {
 public:
  explicit Levels(BitRate rate = BitRate::mbit1, unsigned in_middle = 3, unsigned in_lowest = 0)
      : times(slot_times(rate)),
        judge(times.bits_per_second),
        middle_count(in_middle),
        lowest_count(in_lowest) {
    master.master = master_settings(rate, 0);
    master.master.slaves[kGatewayA].configured = true;
    master.master.process.maximum_slave = *SlaveNumber::from(kGatewayA);
    for (auto& cursor : master.master.process.polling)
      cursor = {cansync::Cursor::Kind::fixed, *SlaveNumber::from(kGatewayA)};
    master.references[0] = {ReferenceCurve::Kind::ramp, 1000, 1};
    master.references[4] = {ReferenceCurve::Kind::ramp, 500'000, 1};
    a = gateway_settings(rate, kGatewayA, in_middle);
    b = gateway_settings(rate, kGatewayB, in_lowest);
    a.cluster.gateway.own_number = {1};
    b.cluster.gateway.own_number = {kMiddle + kGatewayB};
    for (unsigned n = 0; n < in_middle; ++n) a.cluster.gateway.routes.push_back(route(kMiddle + n, n, 0));
    for (unsigned n = 0; n < in_lowest; ++n) {
      a.cluster.gateway.routes.push_back(route(kLowest + n, kGatewayB, kLowest + n));
      b.cluster.gateway.routes.push_back(route(kLowest + n, n, 0));
    }
    for (LineSettings* line : {&top, &middle_line, &lowest_line}) {
      line->bits_per_second = times.bits_per_second;
      line->protocol = &drive_faults();
    }
    top.trace = &judge;
    top.user_number = 30;
  }
  ~Levels() {
    for (const std::string& what : judge.wrong) ADD_FAILURE() << what;
  }
  Levels(const Levels&) = delete;
  Levels& operator=(const Levels&) = delete;

  static cansync::SubSlaveRoute route(unsigned number, unsigned slave, unsigned below) {
    return {
        {static_cast<std::uint16_t>(number)}, *SlaveNumber::from(slave), {static_cast<std::uint16_t>(below)}};
  }
  static cansync::MasterSettings master_settings(BitRate rate, unsigned slaves) {
    cansync::MasterSettings settings;
    settings.bit_rate = rate;
    settings.send_margin = cansync::default_send_margin(rate);
    for (unsigned n = 0; n < slaves; ++n) settings.slaves[n].configured = true;
    settings.process.maximum_slave = *SlaveNumber::from(slaves == 0 ? 0 : slaves - 1);
    return settings;
  }
  ClusterNodeSettings gateway_settings(BitRate rate, unsigned number, unsigned slaves) const {
    ClusterNodeSettings settings;
    settings.cluster.upper.number = *SlaveNumber::from(number);
    settings.cluster.upper.bit_rate = rate;
    settings.cluster.lower = master_settings(rate, slaves);
    settings.delay = times.bit_time() * 20;
    settings.lock_time = times.interval * 20;
    ParameterDefinition status;
    status.number = kStatusWord;
    status.access = ParameterDefinition::Access::read_only;
    settings.service.parameters = {status};
    return settings;
  }

  void build() {
    std::vector<std::unique_ptr<Node>> low;
    for (unsigned n = 0; n < lowest_count; ++n) low.push_back(leaf(n, kLowest + n, lowest));
    std::vector<std::unique_ptr<Node>> mid;
    for (unsigned n = 0; n < middle_count; ++n) {
      if (lowest_count != 0 && n == kGatewayB) {
        auto node = std::make_unique<ClusterNode>(b, told_b, ends_b);
        gateway_b = node.get();
        middle.push_back(nullptr);
        mid.push_back(std::move(node));
      } else {
        mid.push_back(leaf(n, kMiddle + n, middle));
      }
    }
    std::vector<std::unique_ptr<Node>> high;
    auto the_master = std::make_unique<MasterNode>(master, &ends);
    auto node = std::make_unique<ClusterNode>(a, told_a, ends_a);
    master_node = the_master.get();
    gateway_a = node.get();
    high.push_back(std::move(the_master));
    high.push_back(std::move(node));
    for (const auto& [number, settings] : beside) {
      auto other = std::make_unique<LeafSlave>(settings, number, times.bit_time() * 20);
      others.push_back(other.get());
      high.push_back(std::move(other));
    }
    lowest_bus = std::make_unique<Line>(lowest_line, std::move(low));
    middle_bus = std::make_unique<Line>(middle_line, std::move(mid));
    top_bus = std::make_unique<Line>(top, std::move(high));
    gateway_a->connect(*middle_bus);
    std::vector<ClusterNode*> gateways = {gateway_a};
    if (gateway_b != nullptr) {
      gateway_b->connect(*lowest_bus);
      gateways.push_back(gateway_b);
    }
    levels_ = std::make_unique<LevelRun>(*top_bus, gateways);
  }
  /// Builds and runs until every level is active.
  void start() {
    build();
    ASSERT_TRUE(run_until([this] { return all_active(); }, 4000));
    run(3);
  }
  bool all_active() {
    return is_active(master_node->master().state()) &&
           gateway_a->cluster().state() == cansync::ClusterState::active &&
           (gateway_b == nullptr || gateway_b->cluster().state() == cansync::ClusterState::active);
  }
  void run(unsigned intervals = 1) {
    for (unsigned n = 0; n < intervals; ++n) levels_->run_to(levels_->now() + times.interval);
  }
  template <class Done>
  bool run_until(Done done, unsigned most = 5000) {
    for (unsigned i = 0; i < most; ++i) {
      if (done()) return true;
      run();
    }
    return done();
  }

  cansync::Master& upper_master() { return master_node->master(); }
  cansync::ParameterRequest read(unsigned sub, unsigned number) {
    cansync::ParameterRequest request;
    request.id = ++ids_;
    request.slave = *SlaveNumber::from(kGatewayA);
    request.sub_slave = {static_cast<std::uint16_t>(sub)};
    request.number = *cansync::ParameterNumber::from(number);
    return request;
  }
  cansync::ParameterRequest write(unsigned sub, unsigned number, std::uint32_t value) {
    auto request = read(sub, number);
    request.write = true;
    request.value = value;
    request.format = number % 2 != 0 ? cansync::ParameterFormat::doubleword : cansync::ParameterFormat::word;
    return request;
  }
  cansync::ParameterResult end_of(const cansync::ParameterRequest& request) {
    EXPECT_EQ(upper_master().submit(request), cansync::Refusal::none);
    EXPECT_TRUE(run_until([&] { return ends.parameters.contains(request.id); }));
    return ends.parameters[request.id];
  }
  cansync::TransferRequest transfer(unsigned sub, bool download, std::span<std::uint8_t> data,
                                    std::uint32_t address = 0x100) {
    cansync::TransferRequest request;
    request.id = ++ids_;
    request.direction = download ? cansync::TransferRequest::Direction::download
                                 : cansync::TransferRequest::Direction::upload;
    request.slave = *SlaveNumber::from(kGatewayA);
    request.sub_slave = {static_cast<std::uint16_t>(sub)};
    request.address = address;
    request.data = data;
    return request;
  }
  cansync::TransferResult end_of(const cansync::TransferRequest& request) {
    EXPECT_EQ(upper_master().submit(request), cansync::Refusal::none);
    EXPECT_TRUE(run_until([&] { return ends.transfers.contains(request.id); }, 20'000));
    return ends.transfers[request.id];
  }
  LeafSlave& of(unsigned cansync_number) {
    return cansync_number >= kLowest ? *lowest[cansync_number - kLowest] : *middle[cansync_number - kMiddle];
  }
  cansync::Cluster& cluster() { return gateway_a->cluster(); }

  const cansync::SlotTimes& times;
  SlotJudge judge;
  unsigned middle_count;
  unsigned lowest_count;
  MasterNodeSettings master;
  ClusterNodeSettings a, b;
  LineSettings top, middle_line, lowest_line;
  std::vector<std::pair<std::uint16_t, cansync::SlaveSideSettings>> beside;  ///< on the top line
  can::Time leaf_delay{};

  JobEnds ends, ends_a, ends_b;
  NobodyTold told_a, told_b;
  MasterNode* master_node = nullptr;
  ClusterNode* gateway_a = nullptr;
  ClusterNode* gateway_b = nullptr;
  std::vector<LeafSlave*> middle, lowest, others;
  std::unique_ptr<Line> lowest_bus, middle_bus, top_bus;

 private:
  std::unique_ptr<Node> leaf(unsigned slave, unsigned cansync_number, std::vector<LeafSlave*>& kept) {
    cansync::SlaveSideSettings settings;
    settings.number = *SlaveNumber::from(slave);
    settings.bit_rate = times.bit_rate;
    auto node = std::make_unique<LeafSlave>(settings, static_cast<std::uint16_t>(cansync_number),
                                            leaf_delay == can::Time{} ? times.bit_time() * 20 : leaf_delay);
    kept.push_back(node.get());
    return node;
  }

  cansync::JobId ids_ = 0;
  std::unique_ptr<LevelRun> levels_;
};

}  // namespace sim::test
