#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "can/fake_kernel.h"
#include "can/link_watch.h"
#include "can/socketcan/kernel_frame.h"
#include "can/socketcan/socketcan_bus.h"
#include "daemon/bus/socketcan_line.h"
#include "daemon/cansync/bus/bus_plan.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "support/virtual_line.h"

namespace cansyncd::test {

/// The kernel's side of SocketCAN, with drives behind it.
class LineKernel final : public can::Kernel {
 public:
  explicit LineKernel(sim::Line& line) : line_(line) {}

  std::map<std::string, unsigned> calls;
  unsigned clock_readings = 0;  ///< of CLOCK_MONOTONIC
  std::function<void()> on_sleep = [] {};
  std::deque<can_frame> errors;  ///< error frames that come with the next look
  std::vector<can_filter> filters;
  int send_error = 0;

  /// A frame that waited in the controller or its queue while nobody acknowledged, and went out afterwards.
  struct Late {
    can::Frame frame;
    can::Time waited;
  };
  static constexpr std::size_t kQueue = 8;  ///< frames that controller and queue keep
  bool one_shot = false;                    ///< the controller tries each frame once
  bool deaf = false;                        ///< nothing that was received is there yet
  std::vector<Late> late;
  unsigned attempts = 0;  ///< frames handed over while the cable was off

  /// Without the cable nobody acknowledges: frames stay until it is back, and go out then.
  void cable(bool on) {
    cable_ = on;
    if (!on) return;
    for (const Kept& kept : kept_) {
      late.push_back({kept.frame, line_.now() - kept.at});
      line_.send(kept.frame);
    }
    kept_.clear();
  }
  std::size_t kept() const { return kept_.size(); }
  /// The interface goes down or up: its queues are emptied, and the socket tells it once.
  void set_up(bool up) {
    up_ = up;
    if (up) return;
    kept_.clear();
    told_down_ = false;
  }

  int open_socket() noexcept override { return fake_.open_socket(); }
  void close_socket(int socket) noexcept override { fake_.close_socket(socket); }
  int set_option(int, int level, int name, const void* value, std::size_t size) noexcept override {
    ++calls["setsockopt"];
    if (level != SOL_CAN_RAW || name != CAN_RAW_FILTER) return 0;
    const auto* first = static_cast<const can_filter*>(value);
    filters.assign(first, first + size / sizeof(can_filter));
    return 0;
  }
  int bind_to(int, int) noexcept override {
    ++calls["bind"];
    return 0;
  }
  int send_frame(int, const can_frame& frame) noexcept override {
    ++calls["send"];
    if (send_error != 0) return send_error;
    if (!up_ || !std::exchange(told_down_, true)) return -ENETDOWN;
    can::Frame out;
    out.id = frame.can_id;
    out.dlc = frame.len;
    std::copy_n(frame.data, frame.len, out.data.begin());
    if (!cable_) {
      if (kept_.size() == kQueue) return -ENOBUFS;
      ++attempts;
      if (!one_shot) kept_.push_back({out, line_.now()});
      return sizeof(frame);
    }
    return line_.send(out) == can::SendResult::queued ? static_cast<int>(sizeof(frame)) : -ENOBUFS;
  }
  int receive(int socket, mmsghdr* messages, unsigned count) noexcept override {
    ++calls["recvmmsg"];
    if (!std::exchange(told_down_, true)) return -ENETDOWN;
    while (!errors.empty()) {
      can::test::Arriving error;
      error.frame = errors.front();
      fake_.arriving.push_back(error);
      errors.pop_front();
    }
    drain();
    if (deaf) return -EAGAIN;
    return fake_.receive(socket, messages, count);
  }
  int sleep_until(can::Time deadline) noexcept override {
    ++calls["clock_nanosleep"];
    on_sleep();
    while (line_.wait_until(deadline) != can::Wake::deadline) {
      drain();
    }
    return 0;
  }
  int wait_readable(int, can::Time) noexcept override { return 0; }
  can::Time monotonic() noexcept override {
    ++clock_readings;
    return line_.now();
  }
  can::Time realtime() noexcept override { return line_.now() + fake_.wall_offset; }

 private:
  bool passes(const can::Frame& frame) const {
    const canid_t id = can::to_kernel(frame).can_id;
    return std::any_of(filters.begin(), filters.end(), [id](const can_filter& filter) {
      return (id & filter.can_mask) == (filter.can_id & filter.can_mask);
    });
  }
  /// The line wakes for each frame that waits; the kernel keeps them.
  void drain() {
    can::ReceivedFrame received;
    while (line_.receive(received)) {
      if (!passes(received.frame)) continue;
      can::test::Arriving arriving;
      arriving.frame.can_id = received.frame.id;
      arriving.frame.len = received.frame.dlc;
      std::copy_n(received.frame.data.begin(), received.frame.dlc, arriving.frame.data);
      arriving.own = received.own;
      arriving.software = received.end + fake_.wall_offset;
      fake_.arriving.push_back(arriving);
    }
  }

  struct Kept {
    can::Frame frame;
    can::Time at;
  };

  sim::Line& line_;
  can::test::FakeKernel fake_;
  std::deque<Kept> kept_;
  bool cable_ = true;
  bool up_ = true;
  bool told_down_ = true;
};

/// The SYNC wire, which is no part of the CAN interface.
class CountedWire final : public sync_line::SyncWire {
 public:
  explicit CountedWire(sim::Line& line) : line_(line) {}
  std::function<void(std::uint64_t)> on_edge = [](std::uint64_t) {};
  std::uint64_t edges = 0;

  void sync_edge(can::Time due) noexcept override {
    line_.sync_edge(due);
    on_edge(edges++);
  }

 private:
  sim::Line& line_;
};

/// The configuration of a SocketCAN line with these settings.
inline Config config_for(const cansync::MasterSettings& settings) {
  Config config;
  config.bus.kind = BusKind::socketcan;
  config.bus.interface = "can0";
  config.master = settings;
  config.bus.bits_per_second = cansync::slot_times(settings.bit_rate).bits_per_second;
  return config;
}

/// Four drives at 1 Mbit/s; the interface is watched by hand.
struct Rig {
  explicit Rig(const can::LinkFacts& facts = can::test::can0())
      : bus((links.facts = facts, watch.look(), socketcan_settings(bus_plan(config))), board, links, kernel) {
    links.on_set_up = [this](bool up) { kernel.set_up(up); };
    wire.on_edge = [this](std::uint64_t edge) {
      static_cast<void>(exchange.master.read(latest));
      on_edge(edge);
      if (edge >= last) loop.request_stop();
    };
  }

  cansync::MasterSettings settings = support::line_settings(cansync::BitRate::mbit1, 4);
  Config config = config_for(settings);
  sim::Line line{sim::LineSettings{}, support::drives_for(settings)};
  LineKernel kernel{line};
  can::test::FakeLinks links;
  can::LinkBoard board;
  can::BusSockets sockets{bus_plan(config).filters, kernel};
  can::LinkWatch watch{links, board, sockets, {"can0", 1'000'000}};
  can::SocketcanBus bus;
  CountedWire wire{line};
  Exchange exchange{ExchangeSizes{}};
  RealtimeLoop loop{settings, loop_settings(), bus, exchange};
  std::function<void(std::uint64_t)> on_edge = [](std::uint64_t) {};
  std::uint64_t last = 0;
  MasterSnapshot latest;
  std::vector<Report> reports;
  std::multimap<cansync::JobId, Terminal> terminals;

  LoopSettings loop_settings() {
    LoopSettings chosen;
    chosen.sync_wire = &wire;
    chosen.wall_clock = nullptr;
    chosen.look_at_every_slot = false;
    return chosen;
  }
  void run(std::uint64_t edges) {
    last = edges;
    loop.run();
    Report report;
    while (exchange.reports.try_pop(report)) reports.push_back(report);
    Terminal terminal;
    while (exchange.terminals.try_pop(terminal)) {
      terminals.emplace(std::visit([](const auto& t) { return t.id; }, terminal), terminal);
    }
  }
  /// The master's state at the last edge, before it was stopped.
  const MasterSnapshot& snapshot() const { return latest; }
  void link(const can::LinkFacts& facts) {
    links.facts = facts;
    watch.look();
  }
  void give_references() {
    for (const auto channel : {cansync::Channel::one, cansync::Channel::two}) {
      cansync::ReferenceUpdate update;
      update.channel = channel;
      update.value = {1, 2, 3, 4};
      update.valid_mask = 0x0F;
      EXPECT_TRUE(exchange.requests.try_push(update));
    }
  }
  template <class T>
  std::vector<T> reported() const {
    std::vector<T> found;
    for (const Report& report : reports) {
      if (const T* typed = std::get_if<T>(&report)) found.push_back(*typed);
    }
    return found;
  }
};

}  // namespace cansyncd::test
