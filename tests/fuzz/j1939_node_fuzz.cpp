// A whole node of J1939: any frames of others at any times, requests of a program, lost echoes, an emptied
// controller. Most frames are ones the node understands, so that claims, both transport protocols and
// requests go far.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <map>
#include <vector>

#include "bytes.h"
#include "frames.h"
#include "j1939/node.h"
#include "require.h"

namespace {

using namespace j1939;
using fuzz::Bytes;
using fuzz::require;

constexpr std::size_t kMost = 3000;
constexpr Address kOwn = 0x80;
constexpr std::array<Pgn, 8> kGroups = {0xEF00,
                                        0xFEF1,
                                        0x1FF00,
                                        pgn::kRequest,
                                        pgn::kCommandedAddress,
                                        pgn::kAcknowledgement,
                                        pgn::kAddressClaimed,
                                        pgn::kActiveFaults};

NodeSettings settings(Bytes& in) {
  NodeSettings out;
  out.claim.preferred = kOwn;
  out.claim.name = compose(NameFields{.identity = 5, .arbitrary_address = in.flag()});
  out.claim.last_other = 0x82;
  out.claim.first_other = 0x81;
  out.between_others = in.flag();
  out.window = static_cast<std::uint8_t>(1 + in.below(255));
  out.most_bytes = in.flag() ? kMost : kMostBytes;
  if (in.flag()) (void)out.filter.add({});
  out.provided = {{0xFEF1, 6, {1, 2, 3}}, {0xEF00, 7, std::vector<std::uint8_t>(20, 9)}, {0x1FF00, 6, {}}};
  return out;
}

class NodeRun {
 public:
  explicit NodeRun(Bytes& in) : in_(in), node_(settings(in)) { node_.start(now_); }

  void go() {
    while (!in_.empty()) {
      step();
      take_answers();
      require(node_.waiting() <= kMostMessages + kMostRequests, "the queue is bounded");
      require(node_.handed_over_count() <= kMostHandedOver, "so is what stands in the controller");
      require(node_.transports() <= TransportReceiver::kSessions + TransportSender::kSessions,
              "so are messages in packets");
    }
    node_.stop();
    take_answers();
    require(open_.empty(), "every order is answered");
  }

 private:
  void step() {
    switch (in_.below(8)) {
      case 0:
        return hear(fuzz::frame(in_));
      case 1:
      case 2:
        return hear(of_the_transport());
      case 3:
        return hear(of_a_group());
      case 4:
        return submit();
      case 5:
        if (!open_.empty()) (void)node_.cancel(open_.begin()->first);
        return;
      case 6:
        return pass();
      default:
        return send();
    }
  }

  Address any_source() { return static_cast<Address>(0x20 + in_.below(4)); }

  can::Frame of_the_transport() {
    constexpr std::array<Pgn, 4> kBy = {pgn::kTransportControl, pgn::kTransportData,
                                        pgn::kExtendedTransportControl, pgn::kExtendedTransportData};
    constexpr std::array<std::uint8_t, 9> kControls = {16, 17, 19, 20, 21, 22, 23, 32, 255};
    const Pgn by = kBy[in_.below(4)];
    const bool control = by == pgn::kTransportControl || by == pgn::kExtendedTransportControl;
    std::array<std::uint8_t, 8> bytes = {};
    for (std::uint8_t& byte : bytes) byte = in_.byte();
    if (control) {
      bytes[0] = kControls[in_.below(kControls.size())];
      const Pgn group = kGroups[in_.below(3)];
      for (unsigned i = 0; i < 3; ++i) bytes[5 + i] = static_cast<std::uint8_t>(group >> 8 * i);
    }
    const Address to = in_.flag() ? node_.claim().wanted().value_or(kOwn) : kGlobalAddress;
    return frame_of(identifier_of(by, 7, to, any_source()), bytes);
  }

  can::Frame of_a_group() {
    std::array<std::uint8_t, 8> bytes = {};
    for (std::uint8_t& byte : bytes) byte = in_.byte();
    const Pgn group = kGroups[in_.below(kGroups.size())];
    const bool own_address = in_.below(8) == 0;
    can::Frame frame = frame_of(
        identifier_of(group, 6, in_.flag() ? kOwn : kGlobalAddress, own_address ? kOwn : any_source()),
        bytes);
    frame.dlc = static_cast<std::uint8_t>(in_.below(9));
    return frame;
  }

  void hear(const can::Frame& frame) {
    const auto delivery = node_.receive(frame, now_);
    if (!delivery) return;
    const Message& message = delivery->message;
    require(message.data.size() <= kMost, "a message is bounded");
    require(message.transport != Transport::frame || message.data.size() <= 8, "a frame has eight bytes");
    require(message.transport != Transport::extended || message.data.size() > kMostBytes,
            "the extended form is for longer ones");
    std::size_t sum = 0;
    for (const std::uint8_t byte : message.data) sum += byte;  // every byte can be read
    require(sum <= 255 * message.data.size(), "bytes are bytes");
  }

  void submit() {
    Order order;
    order.id = ++number_;
    order.kind = in_.flag() ? OrderKind::request : OrderKind::send;
    order.number = kGroups[in_.below(kGroups.size())];
    order.priority = static_cast<std::uint8_t>(in_.below(9));
    order.destination = in_.flag() ? any_source() : kGlobalAddress;
    order.timeout = std::chrono::milliseconds(1 + in_.below(5000));
    constexpr std::array<std::size_t, 6> kSizes = {0, 8, 9, 1785, 1786, kMost + 1};
    std::vector<std::uint8_t>& memory = memory_[order.id];
    memory.resize(kSizes[in_.below(kSizes.size())]);
    order.memory = memory;
    if (node_.submit(order, now_) == Refusal::none) {
      open_[order.id] = now_;
    } else {
      memory_.erase(order.id);
    }
  }

  void send() {
    const auto frame = node_.next_frame();
    if (!frame) return;
    require(frame->extended && !frame->remote && frame->dlc <= 8, "what is sent is a frame of J1939");
    const Identifier parts = parse(frame->id);
    require(parts.source == kNullAddress || parts.source == node_.claim().wanted().value_or(kNullAddress) ||
                pgn_of(parts) == pgn::kAddressClaimed,
            "nothing is sent with another's address");
    switch (in_.below(8)) {
      case 0:
        return node_.held_back(Obstacle::bus_off);
      case 1:
        return node_.handed_over();  // its echo is missed
      case 2:
        node_.handed_over();
        return node_.controller_emptied();
      case 3:
        node_.handed_over();
        return node_.echoes_lost();
      default:
        node_.handed_over();
        return node_.echo(*frame, now_);
    }
  }

  void pass() {
    const Time due = node_.next_deadline();
    require(due > Time::min(), "a deadline is a time");
    const Time step = std::chrono::milliseconds(in_.below(2000));
    now_ = in_.flag() && due != Time::max() ? std::max(now_, due) : now_ + step;
    node_.advance(now_);
    require(node_.next_deadline() > now_ || node_.next_deadline() == Time::max() || can_send(),
            "time goes on, or something is to be sent");
  }
  bool can_send() { return node_.next_frame().has_value(); }

  void take_answers() {
    while (const auto answer = node_.take_answer()) {
      const auto found = open_.find(answer->id);
      require(found != open_.end(), "one answer for each order");
      require(answer->size <= memory_[answer->id].size(), "an answer fits its memory");
      open_.erase(found);
      memory_.erase(answer->id);
    }
  }

  Bytes& in_;
  Time now_ = std::chrono::seconds(1);
  Node node_;
  OrderId number_ = 0;
  std::map<OrderId, Time> open_;
  std::map<OrderId, std::vector<std::uint8_t>> memory_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  NodeRun(in).go();
  return 0;
}
