// Writes a candump log of everything that a node of J1939 can say: its claim, one frame of each kind,
// messages in packets by every form, both ends of them, an abort, an acknowledgement. Behind each identifier
// and its bytes stands in a second file, a line each, what the frame means: priority, PGN, source,
// destination.
//
//   message_capture LOG MEANINGS
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <utility>
#include <vector>

#include "can/candump.h"
#include "j1939/node.h"

namespace {

using namespace j1939;

/// Two nodes on one bus, in virtual time.
class Bus {
 public:
  Bus(const char* log, const char* meanings) : log_(log), meanings_(meanings) {
    for (Node* node : {&one_, &two_}) node->start(now_);
    run(std::chrono::milliseconds(300));
  }

  void send(Node& node, OrderKind kind, Pgn number, Address destination, std::size_t size) {
    memory_.emplace_back(size, std::uint8_t{0xA5});
    Order order;
    order.id = ++number_;
    order.kind = kind;
    order.number = number;
    order.priority = size > 8 ? 7 : 3;
    order.destination = destination;
    order.timeout = std::chrono::seconds(60);
    order.memory = memory_.back();
    (void)node.submit(order, now_);
    run(std::chrono::seconds(3));
  }

  Node& one() { return one_; }
  Node& two() { return two_; }
  bool good() { return log_.good() && meanings_.good() && number_ == answered_; }

 private:
  static NodeSettings settings(Address address, std::uint32_t identity) {
    NodeSettings out;
    out.claim.preferred = address;
    out.claim.name = compose(NameFields{.identity = identity, .manufacturer = 7});
    (void)out.filter.add({.first = 0xE000, .last = 0x1FFFF});
    out.provided = {{0xFEEB, 6, std::vector<std::uint8_t>(30, 0x31)}};
    return out;
  }

  void run(Time time) {
    const Time end = now_ + time;
    while (now_ < end) {
      while (pass(one_, two_) || pass(two_, one_)) {
      }
      now_ = std::min<Time>({end, std::max<Time>(now_ + std::chrono::microseconds(1),
                                                 std::min(one_.next_deadline(), two_.next_deadline()))});
    }
  }

  /// One frame of `from`, heard by `to`.
  bool pass(Node& from, Node& to) {
    from.advance(now_);
    while (from.take_answer()) ++answered_;
    const auto frame = from.next_frame();
    if (!frame) return false;
    from.handed_over();
    now_ += std::chrono::microseconds(600);
    from.echo(*frame, now_);
    (void)to.receive(*frame, now_);
    write(*frame);
    return true;
  }

  void write(const can::Frame& frame) {
    std::array<char, can::kCandumpLineLimit> line;
    const auto time = std::chrono::duration_cast<std::chrono::microseconds>(now_);
    log_.write(line.data(), static_cast<std::streamsize>(can::write_candump_line(time, "can0", frame, line)));
    const Identifier parts = parse(frame.id);
    meanings_ << unsigned{parts.priority} << '|' << pgn_of(parts) << '|' << unsigned{parts.source} << '|'
              << unsigned{destination_of(parts)} << '\n';
  }

  std::ofstream log_;
  std::ofstream meanings_;
  Time now_ = std::chrono::seconds(1);
  Node one_{settings(0x80, 1)};
  Node two_{settings(0x21, 2)};
  std::vector<std::vector<std::uint8_t>> memory_;
  OrderId number_ = 0;
  OrderId answered_ = 0;
};

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) return 2;
  Bus bus(arguments[1], arguments[2]);
  bus.send(bus.one(), OrderKind::send, 0xFEF1, kGlobalAddress, 8);  // PDU2
  bus.send(bus.one(), OrderKind::send, 0xEF00, 0x21, 3);            // PDU1
  bus.send(bus.one(), OrderKind::send, 0x1FEF1, kGlobalAddress,
           1);  // data page 1; without any data tshark 4.0 stumbles
  bus.send(bus.one(), OrderKind::send, 0xFECA, kGlobalAddress, 22);  // BAM
  bus.send(bus.one(), OrderKind::send, 0xEF00, 0x21, 1785);          // RTS, CTS, acknowledgement
  bus.send(bus.one(), OrderKind::send, 0xEF00, 0x21, 4000);          // by the extended form
  bus.send(bus.one(), OrderKind::send, 0xD000, 0x21, 100);           // nobody takes it: abort
  bus.send(bus.one(), OrderKind::send, 0xD000, 0x21, 2000);          // likewise
  bus.send(bus.one(), OrderKind::request, 0xFEEB, 0x21, 1785);       // answered in packets
  bus.send(bus.two(), OrderKind::request, 0xFE00, 0x80, 8);          // refused
  bus.send(bus.one(), OrderKind::request, pgn::kAddressClaimed, kGlobalAddress, 0);
  return bus.good() ? 0 : 1;
}
