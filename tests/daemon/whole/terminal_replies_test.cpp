// Exactly one terminal reply for each request, whatever happens: real DDS, the gateway on its own thread, and
// the realtime loop with simulated drives in virtual time.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "cansync/sim/drive_parameters.h"
#include "whole_requests.h"

namespace cansyncd {
namespace {

constexpr std::uint32_t kForEver = 3'600'000;  // ms; the longest that may be asked for
constexpr std::uint32_t kSoon = 500;           // ms
constexpr std::uint32_t kSooner = 100;         // ms; shorter than 255 unanswered commands

/// Kinds of requests that end in the same way. `waiting`: reads that wait for their turn in the gateway.
enum Kind : std::uint8_t {
  read,
  write,
  upload,
  download,
  waiting,
  control_word,
  broadcast,
  line_setting,
  mode,
  release,
  kKinds
};

constexpr std::uint64_t kRequests = 20;

Kind kind_of(std::uint64_t number) {
  static constexpr std::array kFirst = {read,      write,        upload,       download,     control_word,
                                        broadcast, line_setting, line_setting, line_setting, line_setting,
                                        mode,      release,      read,         read};
  return number <= kFirst.size() ? kFirst.at(number - 1) : waiting;
}

/// Every kind of request, and more reads of slave 1 than the gateway gives to the master at once. It gives
/// the master four of what changes the line, too; mode and release wait for the others.
void ask_all(TestClient& client, std::uint32_t timeout) {
  client.write(parameter(1, 1, false, timeout));
  client.write(parameter(2, 1, true, timeout));
  client.write(transfer(3, 2, timeout));
  auto down = transfer(4, 3, timeout);
  std::vector<std::uint8_t> data(down.length, 0xA5);
  down.direction = cansync_DIRECTION_DOWNLOAD;
  down.data = {down.length, down.length, data.data(), false};
  client.deliver(down);
  client.write(command(5, cansync_COMMAND_CONTROL_WORD));
  client.write(command(6, cansync_COMMAND_BROADCAST));
  client.write(command(7, cansync_COMMAND_POLLING));
  client.write(command(8, cansync_COMMAND_CHANNEL_CURSORS));
  client.write(command(9, cansync_COMMAND_REFERENCE_MAPPING));
  client.write(command(10, cansync_COMMAND_ACTUAL_MAPPING));
  client.write(command(11, cansync_COMMAND_MODE));
  client.deliver(command(12, cansync_COMMAND_RELEASE));
  for (std::uint64_t number = 13; number < kRequests; ++number) {
    client.write(parameter(number, 1, false, timeout));
  }
  client.deliver(parameter(kRequests, 1, false, timeout));
}

/// What tests of a cause need at hand.
struct Scene {
  WholeRig& rig;
  std::unique_ptr<Asker>& asker;
};

using Codes = std::set<gateway_ReplyCode>;

/// Something that happens to open requests, and how each kind of them may end.
struct Cause {
  const char* name;
  std::uint32_t timeout;
  bool under_way;  ///< jobs have begun, and their slaves answer busy; else: nothing has begun
  std::function<void(Scene&)> happens;  ///< while time is held
  std::array<Codes, kKinds> endings;    ///< by Kind
  std::uint8_t lost_after = 3;          ///< unanswered commands
  bool edges_after = true;              ///< the line goes on
  bool daemon_after = true;             ///< the gateway goes on
};

const Codes kDone = {gateway_REPLY_DONE};
const Codes kRefused = {gateway_REPLY_REFUSED};
const Codes kCancelled = {gateway_REPLY_CANCELLED};
const Codes kTimeout = {gateway_REPLY_TIMEOUT};
const Codes kStopped = {gateway_REPLY_MASTER_STOPPED};
const Codes kLost = {gateway_REPLY_SLAVE_LOST};
const Codes kNoAnswer = {gateway_REPLY_NO_ANSWER};

using Endings = std::array<Codes, kKinds>;

/// Jobs end with `codes`, those that wait with `of_waiting`; commands as if nothing had happened.
Endings jobs(const Codes& codes, const Codes& of_waiting) {
  return {codes, codes, codes, codes, of_waiting, kDone, kDone, kDone, kDone, kRefused};
}
Endings jobs(const Codes& codes) {
  return jobs(codes, codes);
}
Endings all_kinds(const Codes& codes) {
  Endings endings;
  endings.fill(codes);
  return endings;
}
Endings with(Endings endings, std::initializer_list<std::pair<Kind, Codes>> others) {
  for (const auto& [kind, codes] : others) endings.at(kind) = codes;
  return endings;
}
Codes operator|(const Codes& left, const Codes& right) {
  Codes both = left;
  both.insert(right.begin(), right.end());
  return both;
}

void cancel_all(Scene& scene) {
  for (std::uint64_t number = 1; number < kRequests; ++number) {
    scene.asker->client.write(TestClient::request<gateway_JobCancel>(number));
  }
  scene.asker->client.deliver(TestClient::request<gateway_JobCancel>(kRequests));
  pass_marker(scene.rig);
}

void client_goes(Scene& scene) {
  scene.asker.reset();
  ASSERT_TRUE(scene.rig.heard("client_gone"));
  pass_marker(scene.rig);
}

void silence(Scene& scene) {
  add(scene.rig, sim::FaultKind::silent);
}

void lose_answers(Scene& scene) {
  // The master does not get them.
  sim::Fault lost = fault(sim::FaultKind::lost);
  lost.receivers = {};
  (void)scene.rig.line().line().faults().add(lost);
}

template <cansync_Mode Wanted>
void change_mode(Scene& scene) {
  order(scene.rig, Wanted);
}

void bus_off(Scene& scene) {
  sim::Fault destroyed = fault(sim::FaultKind::corrupted);
  destroyed.count = 500;
  (void)scene.rig.line().line().faults().add(destroyed);
  scene.rig.release();
  ASSERT_TRUE(scene.rig.watch_bus(
      [](const auto& status) { return std::string_view(status.controller_state) == "bus-off"; }));
  order(scene.rig, cansync_MODE_RESET_CAN);
}

void reload(Scene& scene) {
  Config changed = whole_config();
  changed.slaves[1].name = "renamed";
  scene.rig.gateway().reload(changed);
}

void stop_gateway(Scene& scene) {
  scene.rig.gateway().stop();
}

void stop_both(Scene& scene) {
  scene.rig.end_line();
  scene.rig.gateway().stop();
}

/// The next daemon serves the same client, whose numbers go on.
void new_daemon(Scene& scene) {
  scene.rig.stop_gateway();
  ASSERT_TRUE(scene.asker->wait_until_gone());
  scene.rig.start_gateway();
  ASSERT_TRUE(scene.asker->wait_for_gateway());
}

const std::vector<Cause>& causes() {
  // What waits for others may have been done, or be refused, by then; of what the slave may have taken nothing is known.
  static const Codes kStoppedLater = kStopped | kRefused;
  static const Endings kOvertaken =
      with(jobs(kDone | kStopped, kDone | kStoppedLater), {{write, kDone | kStopped | kNoAnswer},
                                                           {download, kDone | kStopped | kNoAnswer},
                                                           {control_word, kDone | kStopped},
                                                           {broadcast, kDone | kStopped},
                                                           {mode, kDone | kRefused}});
  static const std::vector<Cause> all = {
      {"nothing", kForEver, false, [](Scene&) {}, jobs(kDone)},
      {"busy until the monitoring time is over", kSoon, true, [](Scene&) {}, jobs(kTimeout)},
      // One after the other, until the slave counts as lost.
      {"answers stay away", kSooner, false, lose_answers,
       with(jobs(kTimeout),
            {{read, kTimeout | kLost}, {write, kNoAnswer}, {waiting, kTimeout | kLost | kRefused}}),
       255},
      {"slaves fall silent before", kForEver, false, silence, jobs(kLost, kRefused)},
      {"slaves fall silent in the middle", kForEver, true, silence,
       with(jobs(kLost, kRefused), {{write, kLost | kNoAnswer}})},
      {"cancel before", kForEver, false, cancel_all, with(all_kinds(kCancelled), {{line_setting, kDone}})},
      {"cancel in the middle", kForEver, true, cancel_all, jobs(kCancelled)},
      {"client goes before", kForEver, false, client_goes,
       with(all_kinds(kCancelled), {{line_setting, kDone}})},
      {"client goes in the middle", kForEver, true, client_goes, jobs(kCancelled)},
      // The order waits behind the settings of the line.
      {"mode stop before", kForEver, false, change_mode<cansync_MODE_STOP>, kOvertaken, 3, false},
      {"mode stop in the middle", kForEver, true, change_mode<cansync_MODE_STOP>,
       jobs(kStopped, kStoppedLater), 3, false},
      {"mode restart before", kForEver, false, change_mode<cansync_MODE_RESTART>, kOvertaken},
      // Those that wait are refused, or served by the line that has started again.
      {"mode restart in the middle", kSoon, true, change_mode<cansync_MODE_RESTART>,
       jobs(kStopped, kStoppedLater | kTimeout)},
      {"reset of the controller", kSoon, true, change_mode<cansync_MODE_RESET_CAN>, jobs(kTimeout)},
      {"reload", kSoon, true, reload, jobs(kTimeout)},
      {"bus-off until it is reset", kSoon, true, bus_off,
       with(jobs(kLost | kTimeout, kLost | kTimeout | kRefused), {{write, kLost | kTimeout | kNoAnswer}})},
      {"the gateway stops before", kForEver, false, stop_gateway, all_kinds(kStopped), 3, true, false},
      {"the gateway stops in the middle", kForEver, true, stop_gateway, jobs(kStopped), 3, true, false},
      {"the realtime thread ends, then the gateway", kForEver, true, stop_both, jobs(kStopped), 3, false,
       false},
      {"a new daemon", kForEver, true, new_daemon, jobs(kStopped)},
  };
  return all;
}

class TerminalReplies : public testing::TestWithParam<std::size_t> {};

TEST_P(TerminalReplies, EveryRequestHasExactlyOne) {
  const Cause& cause = causes().at(GetParam());
  SCOPED_TRACE(cause.name);
  Config config = whole_config();
  config.master.startup.lost_after = cause.lost_after;
  WholeRig rig(config);
  if (cause.under_way) add(rig, sim::FaultKind::busy);
  auto asker = rig.new_asker();
  ask_all(asker->client, cause.timeout);
  pass_marker(rig);
  // All that can begins, and what ends at once is told; shorter than any monitoring time.
  for (int i = 0; cause.under_way && i < 3; ++i) {
    rig.run(30);
    pass_marker(rig);
  }
  Scene scene{rig, asker};
  cause.happens(scene);
  rig.release();
  EXPECT_TRUE(rig.all_answered(kRequests));
  // Longer than all that may still come takes.
  if (cause.edges_after) {
    rig.hold();
    rig.run(5000);
  }
  if (cause.daemon_after) pass_marker(rig);
  for (std::uint64_t number = 1; number <= kRequests; ++number) {
    const auto& codes = rig.replies();
    const auto found = codes.find(number);
    if (found == codes.end()) {
      ADD_FAILURE() << "request " << number << " has no reply";
      continue;
    }
    EXPECT_EQ(found->second.size(), 1u) << "request " << number;
    const auto& endings = cause.endings.at(kind_of(number));
    EXPECT_TRUE(endings.contains(found->second.front()))
        << "request " << number << ": " << found->second.front();
  }
  EXPECT_EQ(rig.replies().size(), kRequests);
}

INSTANTIATE_TEST_SUITE_P(Causes, TerminalReplies, testing::Range<std::size_t>(0, causes().size()));

TEST(TerminalReplies, ASlavesErrorIsOne) {
  WholeRig rig;
  rig.release();
  const auto asker = rig.new_asker();
  auto unknown = parameter(1, 1, false, 0);
  unknown.number = 4000;
  asker->client.write(unknown);
  auto read_only = parameter(2, 1, true, 0);
  read_only.number = sim::parameter::device_type;
  asker->client.write(read_only);
  auto wide = parameter(3, 1, false, 0);
  wide.number = sim::parameter::user_doubleword;
  asker->client.write(wide);
  auto beyond = transfer(4, 2, 0);
  beyond.address = 0x00F00000;
  asker->client.write(beyond);
  EXPECT_EQ(only_replies(rig, 4),
            (std::vector{gateway_REPLY_SLAVE_ERROR, gateway_REPLY_SLAVE_ERROR,
                         gateway_REPLY_DOUBLEWORD_EXPECTED, gateway_REPLY_SLAVE_ERROR}));
}

/// After the daemon was started anew, the clients that are still there are served.
TEST(TerminalReplies, TheNextDaemonServesTheSameClient) {
  WholeRig rig;
  auto asker = rig.new_asker();
  asker->client.deliver(parameter(1, 1, false, 0));
  pass_marker(rig);
  Scene scene{rig, asker};
  new_daemon(scene);
  asker->client.write(parameter(2, 1, false, 0));
  asker->client.write(transfer(3, 2, 0));
  asker->client.write(command(4, cansync_COMMAND_CONTROL_WORD));
  rig.release();
  EXPECT_EQ(only_replies(rig, 4), (std::vector{gateway_REPLY_MASTER_STOPPED, gateway_REPLY_DONE,
                                               gateway_REPLY_DONE, gateway_REPLY_DONE}));
}

}  // namespace
}  // namespace cansyncd
