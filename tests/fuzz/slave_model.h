#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "bytes.h"
#include "cansync/slave/slave.h"
#include "require.h"

namespace fuzz {

/// An application that answers as the input says, and checks what it is asked: blocks from front to back,
/// each byte once, and ends of what has begun alone.
class Application final : public cansync::SlaveApplication {
 public:
  explicit Application(Bytes& in) : in_(in) {}

  /// Before each frame: nothing was asked of it yet.
  void next_frame() noexcept { asked_ = 0; }
  /// How often the application was asked since then, and its last answer to a parameter.
  unsigned asked() const noexcept { return asked_; }
  const cansync::ParameterAnswer& parameter() const noexcept { return parameter_; }
  /// A block is open, or was answered busy when it was to begin.
  bool open() const noexcept { return open_; }
  bool begun() const noexcept { return begun_; }
  /// A parameter access was answered busy, and neither came again nor was dropped.
  bool pending() const noexcept { return pending_; }
  /// Since the last `begin_block`.
  std::uint16_t moved() const noexcept { return next_; }
  std::uint16_t length() const noexcept { return length_; }
  /// The byte of an upload at this offset.
  static std::uint8_t content(unsigned offset) noexcept { return static_cast<std::uint8_t>(offset * 7 + 1); }
  /// The bytes of the newest `write_block`.
  std::span<const std::uint8_t> taken() const noexcept { return std::span(taken_).first(taken_size_); }

  cansync::ParameterAnswer read_parameter(cansync::ParameterNumber, cansync::Element,
                                          cansync::SubSlave) noexcept override {
    return answer();
  }
  cansync::ParameterAnswer write_parameter(cansync::ParameterNumber, cansync::Element element,
                                           cansync::SubSlave, bool doubleword,
                                           std::uint32_t value) noexcept override {
    require(element == cansync::kValueElement, "the value alone is written");
    require(doubleword || value <= 0xFFFF, "a word holds a word");
    return answer();
  }
  void parameter_dropped() noexcept override {
    require(pending_ || unheard_, "what was answered busy or never on the bus alone is dropped, and once");
    pending_ = unheard_ = false;
  }
  void parameter_answered() noexcept override {
    require(unheard_, "an answer is on the bus once");
    unheard_ = false;
  }

  BlockAnswer begin_block(const cansync::TransferInitialise& initialise) noexcept override {
    ++asked_;
    require(!open_, "a block is ended before the next one begins");
    require(!begun_ || initialise == initialise_, "a busy beginning is ended before another one");
    initialise_ = initialise;
    const BlockAnswer out = block_answer();
    begun_ = out.busy;
    if (out.busy || out.error != cansync::TransferError::none) return out;
    upload_ = initialise.direction == cansync::TransferInitialise::Direction::upload;
    length_ = upload_ && out.length != 0 ? out.length : initialise.length.value();
    open_ = true;
    next_ = 0;
    return out;
  }
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override {
    check_block(true, offset, out.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = content(static_cast<unsigned>(offset + i));
    return moved_by(out.size());
  }
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override {
    check_block(false, offset, data.size());
    std::copy(data.begin(), data.end(), taken_.begin());
    taken_size_ = data.size();
    return moved_by(data.size());
  }
  void end_block(bool complete) noexcept override {
    require(begun_ || open_, "only what has begun ends");
    require(!complete || (open_ && next_ == length_), "a complete block has all of its bytes");
    open_ = begun_ = false;
  }
  void control_word(std::uint16_t) noexcept override { ++asked_; }
  void action(std::uint8_t command, std::uint8_t, std::uint16_t) noexcept override {
    ++asked_;
    require(command >= 2, "a control word is no other action");
  }

 private:
  cansync::ParameterAnswer answer() noexcept {
    ++asked_;
    const std::uint8_t bits = in_.byte();
    parameter_ = {};
    parameter_.busy = (bits & 3) == 3;
    if ((bits & 12) == 12) parameter_.error = cansync::ParameterError::not_present;
    parameter_.doubleword = (bits & 16) != 0;
    parameter_.value = in_.number<std::uint32_t>();
    pending_ = parameter_.busy;
    unheard_ = !parameter_.busy;
    return parameter_;
  }
  BlockAnswer block_answer() noexcept {
    const std::uint8_t bits = in_.byte();
    BlockAnswer out;
    out.busy = (bits & 3) == 3;
    if ((bits & 12) == 12) {
      out.error = (bits & 16) != 0 ? cansync::TransferError::cancelled_by_slave
                                   : cansync::TransferError::not_possible;
    }
    // Mostly a length that there is, at times one that no block has.
    if ((bits & 32) != 0) out.length = static_cast<std::uint16_t>(1 + in_.below(4200));
    return out;
  }
  BlockAnswer moved_by(std::size_t size) noexcept {
    const BlockAnswer out = block_answer();
    if (!out.busy && out.error == cansync::TransferError::none)
      next_ = static_cast<std::uint16_t>(next_ + size);
    return out;
  }
  void check_block(bool upload, std::uint16_t offset, std::size_t size) noexcept {
    ++asked_;
    require(open_ && upload_ == upload, "blocks move in their direction while one is open");
    require(offset == next_, "bytes move from front to back, each once");
    require(size == std::min<std::size_t>(6, static_cast<std::size_t>(length_ - next_)) && size > 0,
            "as many bytes as the block still has");
  }

  Bytes& in_;
  cansync::TransferInitialise initialise_;
  cansync::ParameterAnswer parameter_;
  std::array<std::uint8_t, 6> taken_ = {};
  std::size_t taken_size_ = 0;
  unsigned asked_ = 0;
  bool pending_ = false;
  bool unheard_ = false;  ///< a parameter answer was not on the bus yet
  bool begun_ = false;
  bool open_ = false;
  bool upload_ = false;
  std::uint16_t length_ = 0;
  std::uint16_t next_ = 0;
};

/// What a slave's answer must be whatever stands behind it.
inline void check_answer(const cansync::Slave& slave, const cansync::Telegram& question,
                         const can::Frame& answer) {
  using namespace cansync;
  const std::uint8_t number = slave.settings().number.value();
  require(answer.is_standard_data() && answer.dlc <= 8, "an answer is a data frame");
  const Decoded decoded = decode(answer);
  require(std::holds_alternative<Telegram>(decoded), "an answer is a telegram");
  const Telegram& said = std::get<Telegram>(decoded);
  require((answer.id & 0x7Fu) == number, "an answer names its slave");
  require(is_synchronous(slave.state()), "nothing is answered before synchronous operation");
  if (const auto* reference = std::get_if<ReferenceTelegram>(&question)) {
    const auto* actual = std::get_if<ActualTelegram>(&said);
    require(reference->polled == number, "only the slave that is asked answers");
    require(is_active(slave.state()), "actual values are sent in active operation");
    require(actual != nullptr && actual->channel == reference->channel, "with actual values of the channel");
    require(!slave.settings().full_length || actual->words == 4, "in full length where that is set");
    return;
  }
  require(!std::holds_alternative<ActionCommand>(question), "an action is never answered");
  require(!std::holds_alternative<ActualTelegram>(question), "actual values are never answered");
  const bool parameter = std::holds_alternative<ParameterCommand>(question);
  require(
      parameter ? std::holds_alternative<ParameterReply>(said) : std::holds_alternative<TransferReply>(said),
      "each command is answered in its kind");
}

}  // namespace fuzz
