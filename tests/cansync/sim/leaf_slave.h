#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "cansync/slave/slave.h"
#include "sim/node.h"

namespace sim::test {

/// A slave at the end of a network: it notes what it is told, so that a test can say what was applied, and
/// how often. A number that is odd is a doubleword. 999 is not present; 600 reads
/// how many edges were noted.
class LeafSlave final : public Node, private cansync::SlaveApplication {
 public:
  LeafSlave(const cansync::SlaveSideSettings& settings, std::uint16_t cansync_number, can::Time delay)
      : cansync_number_(cansync_number), delay_(delay), slave(settings, *this) {
    using cansync::ControlCommand;
    for (const auto command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                               ControlCommand::start_synchronous, ControlCommand::enable_active})
      slave.control(command);
  }

  /// How many questions about a new access are answered busy.
  std::function<unsigned()> busy = [] { return 0u; };
  /// What a parameter is that nobody has written.
  static std::uint32_t initial(std::uint16_t cansync_number, std::uint16_t parameter) {
    const std::uint32_t value = cansync_number * 77u + parameter;
    return parameter % 2 != 0 ? value | 0x10000u : value & 0xFFFFu;
  }

  struct Reference {
    std::uint64_t edge = 0;  ///< edges before its interval
    can::Time at{};          ///< edge of its interval
    std::array<bool, 2> fresh = {};
    cansync::Values values = {};
  };
  std::vector<std::pair<std::uint16_t, std::uint32_t>> applied;  ///< each write, as often as it was applied
  std::vector<can::Time> edges;
  std::vector<Reference> references;
  std::vector<std::uint16_t> control_words;
  std::map<std::uint32_t, std::vector<std::uint8_t>> memory;  ///< blocks by address
  std::vector<std::uint32_t> blocks;                          ///< addresses of whole downloads
  unsigned dropped = 0;
  unsigned questions = 0;
  unsigned refusals = 0;  ///< the next writes are answered with `refusal`
  cansync::ParameterError refusal = cansync::ParameterError::not_available_now;
  bool record = true;
  bool deaf = false;  ///< takes no part in the bus

 private:
  std::uint16_t cansync_number_;
  can::Time delay_;

 public:
  cansync::Slave slave;

  NodeNumber node_number() const noexcept override { return slave.settings().number.value(); }
  bool accepts(const can::Frame& frame) const noexcept override {
    namespace identifier = cansync::identifier;
    if (!frame.is_standard_data()) return false;
    const std::uint32_t channel = identifier::channel_of(frame.identifier());
    if (channel == identifier::command)
      return identifier::participant_of(frame.identifier()) == slave.settings().number.value();
    return channel == identifier::reference_one || channel == identifier::reference_two ||
           frame.identifier() == identifier::action;
  }
  void on_sync(can::Time now) noexcept override {
    if (record) {
      if (!edges.empty()) {
        references.push_back(
            {edges.size() - 1,
             edge_,
             {slave.reference_fresh(cansync::Channel::one), slave.reference_fresh(cansync::Channel::two)},
             slave.references()});
      }
      edges.push_back(now);
    }
    edge_ = now;
    slave.on_sync();
    slave.release_actual(cansync::Channel::one, {cansync_number_, 1, 2, 3, 4, 5, 6, 7});
    slave.release_actual(cansync::Channel::two, {cansync_number_, 1, 2, 3, 4, 5, 6, 7});
  }
  std::optional<Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override {
    if (deaf) return std::nullopt;
    const auto answer = slave.receive(frame, end - edge_);
    if (!answer) return std::nullopt;
    const can::Time ready = std::max(end, edge_ + answer->window.earliest) + delay_;
    if (!slave.may_start(*answer, ready - edge_)) return std::nullopt;
    return Transmission{answer->frame, ready};
  }
  std::optional<Transmission> on_sent(const can::Frame& frame, can::Time) noexcept override {
    slave.sent(frame);
    return std::nullopt;
  }

 private:
  bool takes_time() {
    ++questions;
    if (!left_) left_ = busy();
    if (*left_ == 0) {
      left_.reset();
      return false;
    }
    --*left_;
    return true;
  }
  static cansync::ParameterAnswer leaf_answer(cansync::ParameterError error) {
    cansync::ParameterAnswer result;
    result.error = error;
    return result;
  }
  cansync::ParameterAnswer read_parameter(cansync::ParameterNumber number, cansync::Element,
                                          cansync::SubSlave sub) noexcept override {
    cansync::ParameterAnswer result;
    const std::uint16_t parameter = number.value();
    if (sub.value != 0 || parameter == 999) return leaf_answer(cansync::ParameterError::not_present);
    if (parameter == 301) {
      result.value = slave.sync_activated() ? 0x8007 : 0x0007;
      return result;
    }
    if (takes_time()) {
      result.busy = true;
      return result;
    }
    if (parameter == 600) {
      result.doubleword = true;
      result.value = static_cast<std::uint32_t>(edges.size());
      return result;
    }
    result.doubleword = parameter % 2 != 0;
    const auto written = values_.find(parameter);
    result.value = written != values_.end() ? written->second : initial(cansync_number_, parameter);
    return result;
  }
  cansync::ParameterAnswer write_parameter(cansync::ParameterNumber number, cansync::Element,
                                           cansync::SubSlave sub, bool doubleword,
                                           std::uint32_t value) noexcept override {
    const std::uint16_t parameter = number.value();
    if (sub.value != 0 || parameter == 999) return leaf_answer(cansync::ParameterError::not_present);
    if (doubleword != (parameter % 2 != 0)) return leaf_answer(cansync::ParameterError::wrong_format);
    if (takes_time()) {
      cansync::ParameterAnswer result;
      result.busy = true;
      return result;
    }
    if (refusals != 0) {
      --refusals;
      return leaf_answer(refusal);
    }
    applied.emplace_back(parameter, value);
    values_[parameter] = value;
    return {};
  }
  void parameter_dropped() noexcept override {
    ++dropped;
    left_.reset();
  }
  BlockAnswer begin_block(const cansync::TransferInitialise& initialise) noexcept override {
    BlockAnswer result;
    if (initialise.address == 0x666) result.error = cansync::TransferError::address_not_allowed;
    if (takes_time()) {
      result.busy = true;
      return result;
    }
    address_ = initialise.address;
    download_ = initialise.direction == cansync::TransferInitialise::Direction::download;
    if (download_) block_.assign(initialise.length.value(), 0);
    if (!download_) block_ = memory[address_];
    if (!download_) block_.resize(initialise.length.value());
    return result;
  }
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override {
    std::copy_n(block_.begin() + offset, out.size(), out.begin());
    return {};
  }
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override {
    std::ranges::copy(data, block_.begin() + offset);
    return {};
  }
  void end_block(bool complete) noexcept override {
    left_.reset();
    if (!complete || !download_) return;
    memory[address_] = block_;
    blocks.push_back(address_);
  }
  void control_word(std::uint16_t word) noexcept override { control_words.push_back(word); }
  void action(std::uint8_t, std::uint8_t, std::uint16_t) noexcept override {}

  can::Time edge_{};
  std::optional<unsigned> left_;
  std::map<std::uint16_t, std::uint32_t> values_;
  std::uint32_t address_ = 0;
  bool download_ = false;
  std::vector<std::uint8_t> block_;
};

}  // namespace sim::test
