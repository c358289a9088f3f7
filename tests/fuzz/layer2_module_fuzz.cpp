// Tables and received frames of general frames (lib/layer2): a module is set up by the first bytes as far as
// its checks have nothing against, and then gets frames, orders and echoes by the rest.
#include <chrono>
#include <optional>
#include <vector>

#include "bytes.h"
#include "layer2/module.h"
#include "require.h"

namespace {

using fuzz::Bytes;
using fuzz::require;

can::Frame frame_of(Bytes& bytes) {
  can::Frame frame;
  const std::uint8_t flags = bytes.byte();
  frame.extended = (flags & 1) != 0;
  frame.remote = (flags & 2) != 0;
  frame.error = (flags & 0xF0) == 0xF0 && !frame.extended && !frame.remote;
  // Few identifiers, so that they meet those of the tables.
  frame.id = (flags & 4) != 0 ? bytes.number<std::uint32_t>() & can::kExtendedIdentifierMask : bytes.byte();
  if (!frame.extended) frame.id &= can::kStandardIdentifierMask;
  frame.dlc = static_cast<std::uint8_t>(bytes.below(9));
  if (!frame.remote)
    for (unsigned i = 0; i < frame.dlc; ++i) frame.data[i] = bytes.byte();
  return frame;
}

layer2::ModuleSettings settings_of(Bytes& bytes) {
  layer2::ModuleSettings settings;
  for (unsigned left = bytes.below(8); left > 0; --left) {
    layer2::ReceiveRange range;
    range.first = bytes.number<std::uint32_t>();
    range.last = range.first + bytes.number<std::uint16_t>();
    const std::uint8_t flags = bytes.byte();
    range.extended = (flags & 1) != 0;
    range.high_priority = (flags & 2) != 0;
    range.kinds = static_cast<layer2::FrameKinds>(flags / 4 % 3);
    const bool good = layer2::check(range) == layer2::RangeProblem::none;
    require(settings.station.filter.add(range) == good, "what the check finds is not taken, all else is");
  }
  settings.receive_queue = static_cast<std::uint16_t>(bytes.below(8));
  settings.receive_high_queue = static_cast<std::uint16_t>(bytes.below(4));
  settings.receive_overflow = static_cast<layer2::Overflow>(bytes.below(2));
  settings.station.queue = static_cast<std::uint16_t>(bytes.below(8));
  settings.station.high_queue = static_cast<std::uint16_t>(bytes.below(4));
  settings.station.overflow = static_cast<layer2::Overflow>(bytes.below(2));
  settings.mapping.rule = {bytes.byte(), bytes.number<std::uint32_t>(), bytes.flag()};
  settings.mapping.interval = std::chrono::microseconds(bytes.number<std::uint16_t>());
  settings.mapping.on_change = bytes.flag();
  for (unsigned left = bytes.below(24); left > 0; --left)
    settings.mapped.push_back({bytes.byte(), static_cast<std::uint8_t>(bytes.below(10)),
                               static_cast<std::uint16_t>(bytes.below(1040)),
                               static_cast<std::uint8_t>(bytes.below(10)), bytes.flag()});
  const auto fault = layer2::DataMapping::check(settings.mapping, settings.mapped);
  require(fault.problem == layer2::MappingProblem::none ||
              fault.problem == layer2::MappingProblem::interval || fault.entry < settings.mapped.size(),
          "a fault names its entry");
  if (fault.problem != layer2::MappingProblem::none) settings.mapped.clear();
  return settings;
}

/// One module and what it was given.
class Run {
 public:
  explicit Run(Bytes& bytes) : bytes_(bytes), module_(settings_of(bytes)) { module_.begin(now_); }

  void go() {
    for (unsigned turn = 0; turn < 2000 && !bytes_.empty(); ++turn) step(bytes_.byte());
    while (const auto waiting = module_.take_received()) taken(*waiting);
    require(fetched_ <= received_, "no frame comes twice");
    module_.end();
    while (module_.take_answer()) ++answers_;
    require(answers_ == accepted_, "every order that was taken has one answer");
  }

 private:
  void step(std::uint8_t choice) {
    switch (choice % 8) {
      case 0:
      case 1:
        ++received_;
        module_.receive(frame_of(bytes_), now_);
        break;
      case 2:
        if (const auto waiting = module_.take_received()) taken(*waiting);
        break;
      case 3:
        submit();
        break;
      case 4:
        send();
        break;
      case 5:
        now_ += std::chrono::microseconds(bytes_.number<std::uint16_t>());
        module_.advance(now_);
        require(module_.next_deadline() > now_, "time goes on");
        break;
      case 6:
        control(bytes_.byte());
        break;
      default:
        while (module_.take_answer()) ++answers_;
    }
  }

  void taken(const layer2::WaitingFrame& waiting) {
    ++fetched_;
    require(!waiting.frame.error && waiting.frame.dlc <= 8, "what is fetched is a frame");
  }

  void submit() {
    layer2::SendOrder order;
    order.id = ++number_;
    order.frame = frame_of(bytes_);
    order.frame.error = false;
    order.timeout = std::chrono::milliseconds(1 + bytes_.below(16));
    order.priority = bytes_.flag() ? layer2::Priority::high : layer2::Priority::normal;
    if (module_.submit(order, now_) == layer2::Refusal::none) ++accepted_;
  }

  void send() {
    const auto frame = module_.next_frame();
    if (!frame) return;
    require(frame->dlc <= 8 && !frame->error, "what is sent is a frame");
    if (bytes_.flag()) return module_.held_back(layer2::Obstacle{});
    module_.handed_over();
    if (!bytes_.flag()) module_.echo(*frame, now_);
  }

  void control(std::uint8_t what) {
    switch (what % 5) {
      case 0:
        return module_.set_running(!module_.running(), now_);
      case 1:
        return module_.clear_queues();
      case 2:
        return module_.reset_overflow();
      case 3:
        return module_.controller_emptied();
      default:
        (void)module_.cancel(number_);
    }
  }

  Bytes& bytes_;
  layer2::Time now_{0};
  layer2::Module module_;
  layer2::OrderId number_ = 0;
  std::uint64_t received_ = 0;
  std::uint64_t fetched_ = 0;
  std::uint64_t accepted_ = 0;
  std::uint64_t answers_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  Run(bytes).go();
  return 0;
}
