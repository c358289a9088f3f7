#include "daemon/desk/gateway_events.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <vector>

#include "dds/endpoint.h"
#include "dds/participant.h"
#include "support/dds_places.h"
#include "support/kept_journal.h"

namespace cansyncd {
namespace {

TEST(GatewayEvents, WhatIsFrequentPushesNoFaultOutOfTheLastEvents) {
  constexpr unsigned kFrequent = 150;
  TwoPlaces places("events0");
  const gateway::dds::Participant here(places.here);
  KeptJournal journal;
  EventPublisher events(here, journal, "events0");
  auto now = std::chrono::steady_clock::now();
  events.publish({gateway_SEVERITY_ERROR, "second_daemon", -1, "the fault", std::nullopt}, now);
  for (unsigned i = 0; i < kFrequent; ++i) {
    now += FloodGuard::kWindow;  // else they would be summed up
    EventText done{gateway_SEVERITY_INFO, "request_done", -1, "done", std::nullopt};
    done.request.emplace();
    events.publish(done, now);
  }
  const gateway::dds::Participant there(places.there);
  gateway::dds::DataSignal signal;
  gateway::dds::Reader<gateway_Event> late(there, &signal);
  std::vector<gateway_Event> seen;
  const auto is_fault = [](const gateway_Event& event) {
    return std::string_view(event.code) == "second_daemon";
  };
  EXPECT_TRUE(eventually(signal, [&] {
    late.take([&](const gateway_Event& event) { seen.push_back(event); });
    return std::any_of(seen.begin(), seen.end(), is_fault) && seen.size() > 100;
  }));
  EXPECT_EQ(seen.size(), 101u);
}

}  // namespace
}  // namespace cansyncd
