#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "daemon/cansync/requests/protocol.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "support/loop_rig.h"

/// What the refusals of the master advise is carried out on a line in virtual time, and helps.
namespace cansyncd::test {
namespace {

using cansync::Outcome;
using cansync::Refusal;

constexpr can::Time kAtTheEdge{0};

/// Context of a refusal as the gateway makes it.
RefusalContext context_of(const MasterSnapshot& master) {
  return {.state = master.state,
          .interval = master.when.interval,
          .responding = master.responding,
          .released = master.released,
          .access = master.access,
          .waits_for_upper_sync = master.waits_for_upper_sync};
}

/// Expects that the text of a refusal ends with `remedy`.
void expect_remedy(const RefusalContext& line, Refusal refusal, const Request& request,
                   std::string_view remedy) {
  Config config;
  config.bus.interface = "can0";
  for (unsigned n = 0; n < 3; ++n) config.master.slaves[n].configured = true;
  const std::string text = refusal_text(refusal, request, config, line);
  EXPECT_TRUE(text.ends_with(remedy)) << text;
}

TEST(MasterRemedies, OfAStateThatDoesNotAllowIt) {
  LoopRig rig(virtual_time(StartTarget::none));
  const ModeRequest run{1, Mode::run, false};
  const auto read = read_request(2, 1, 100);
  rig.push_at(50, run);
  rig.push_at(50, read);
  rig.push_at(50, references(cansync::Channel::one));
  rig.at(60, kAtTheEdge, [&] {
    const RefusalContext line = context_of(rig.snapshot());
    expect_remedy(line, Refusal::wrong_state, run, ": give mode setup, then mode run");
    expect_remedy(line, Refusal::wrong_state, read, ": give mode setup");
    expect_remedy(line, Refusal::wrong_state, references(cansync::Channel::one),
                  ": give mode setup, then mode run");
  });
  rig.push_at(61, ModeRequest{3, Mode::set_up, false});
  rig.push_at(100, read_request(4, 1, 100));
  rig.push_at(100, references(cansync::Channel::one));
  rig.at(190, kAtTheEdge, [&] {
    expect_remedy(context_of(rig.snapshot()), Refusal::wrong_state, references(cansync::Channel::one),
                  ": give mode run");
  });
  rig.push_at(200, ModeRequest{5, Mode::run, false});
  rig.push_at(210, references(cansync::Channel::one));
  rig.run_until(220);
  EXPECT_EQ(rig.answer_to<Refused>(1).refusal, Refusal::wrong_state);
  EXPECT_EQ(rig.answer_to<Refused>(2).refusal, Refusal::wrong_state);
  EXPECT_EQ(rig.answer_to<ParameterDone>(4).result.outcome, Outcome::done);
  EXPECT_EQ(rig.answer_to<CommandDone>(5).outcome, Outcome::done);
  EXPECT_EQ(rig.reported<ReferenceRefused>().size(), 2u) << "in stop and in set-up, not in run";
}

TEST(MasterRemedies, WhereTheModeAloneDoesNotBringSetUpTheRefusalNamesWhatDoes) {
  cansync::MasterSettings settings = master_settings(3);
  settings.startup.listen = std::chrono::milliseconds(200);
  LoopRig rig(virtual_time(StartTarget::none), settings);
  const ModeRequest run{1, Mode::run, false};
  rig.at(40, kAtTheEdge, [&] { rig.bus.controller.link = can::LinkState::down; });
  rig.push_at(50, ModeRequest{2, Mode::set_up, false});
  rig.push_at(60, run);
  rig.at(70, kAtTheEdge, [&] {
    expect_remedy(
        context_of(rig.snapshot()), Refusal::wrong_state, run,
        ": interface can0 is missing, down or bus-off: correct that first, then give mode setup, then mode run");
    rig.bus.controller.link = can::LinkState::up;
  });
  rig.at(100, kAtTheEdge, [&] {
    expect_remedy(
        context_of(rig.snapshot()), Refusal::wrong_state, run,
        ": the master listens whether another one sends (startup.listen_ms): wait for its end, then give "
        "mode setup, then mode run");
  });
  rig.push_at(500, ModeRequest{3, Mode::set_up, false});
  rig.push_at(700, ModeRequest{4, Mode::run, false});
  rig.run_until(720);
  EXPECT_EQ(rig.answer_to<Refused>(1).refusal, Refusal::wrong_state) << "set-up was not reached";
  EXPECT_EQ(rig.answer_to<CommandDone>(4).outcome, Outcome::done);
}

}  // namespace
}  // namespace cansyncd::test
