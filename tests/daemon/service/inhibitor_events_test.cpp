#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "daemon/segment/segment.h"

namespace cansyncd {
namespace {

using Lines = std::vector<std::string>;

/// A segment that writes down the events that it is to publish.
class WrittenEvents final : public Segment {
 public:
  void start() override {}
  void end_realtime() noexcept override {}
  void stop() noexcept override {}
  Heartbeat::Progress progress() const noexcept override { return {}; }
  bool record() noexcept override { return false; }
  ReloadPlan plan_reload(std::span<const std::string>) override { return {}; }
  void post(const EventText& event) override { codes.emplace_back(event.code.word()); }
  void set_surroundings(const Surroundings&) override {}
  bool in_run() const noexcept override { return true; }
  void set_pending_restart(const PendingRestart&) override {}

  Lines codes;
};

TEST(InhibitorEvents, ARefusalIsToldOnceAndItsEndToo) {
  WrittenEvents segment;
  const InhibitorState states[] = {
      {},        {false, "Access denied"}, {false, "Access denied"}, {false, "no D-Bus"}, {true, ""}, {},
      {true, ""}};
  InhibitorState before;
  for (const InhibitorState& now : states) {
    segment.tell_inhibitors(before, now);
    before = now;
  }
  EXPECT_EQ(segment.codes, Lines({"sleep_not_inhibited", "sleep_not_inhibited", "sleep_inhibited"}));
}

}  // namespace
}  // namespace cansyncd
