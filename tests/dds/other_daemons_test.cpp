#include "dds/other_daemons.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>

#include "dds/bounded_text.h"
#include "support/dds_places.h"

namespace gateway::dds {
namespace {

constexpr DaemonIdentity kOwn = {1};
constexpr DaemonIdentity kOther = {2};

/// What a daemon shows of itself.
class Shown {
 public:
  Shown(const ParticipantOptions& place, const DaemonIdentity& identity) : participant_(place) {
    gateway_GatewayStatus status = {};
    copy_text("0.1.0", status.version);
    copy_text("plc\n7", status.host);
    status.process = 1234;
    set_daemon(identity, status);
    EXPECT_EQ(writer_.write(status), DDS_RETCODE_OK);
  }

 private:
  Participant participant_;
  Writer<gateway_GatewayStatus> writer_{participant_};
};

TEST(OtherDaemons, EachIsToldOnceWhenItComesAndWhenItIsGone) {
  const TwoPlaces places;
  const Participant here(places.here);
  DataSignal signal;
  OtherDaemons others(here, kOwn, &signal);
  const Shown own(places.here, kOwn);
  std::optional<Shown> second(std::in_place, places.there, kOther);
  OtherDaemons::News news;
  ASSERT_TRUE(eventually(signal, [&] { return !(news = others.look()).came.empty(); }));
  ASSERT_EQ(news.came.size(), 1u) << "it is not another one itself";
  EXPECT_EQ(news.came[0].identity, kOther);
  EXPECT_EQ(news.came[0].name, "cansyncd 0.1.0, process 1234 on host plc\\x0a7");
  EXPECT_TRUE(others.look().came.empty());
  EXPECT_EQ(others.there().size(), 1u);
  second.reset();
  ASSERT_TRUE(eventually(signal, [&] { return !(news = others.look()).gone.empty(); }));
  EXPECT_EQ(news.gone[0].identity, kOther);
  EXPECT_TRUE(others.there().empty());
  EXPECT_TRUE(others.look().gone.empty());
}

TEST(NameInUse, IsThatOfALivingDaemonOnTheSameBus) {
  const TwoPlaces places;
  ParticipantOptions elsewhere = places.there;
  elsewhere.partition = "anotherbus";
  const Participant here(places.here);
  std::optional<Shown> other(std::in_place, elsewhere, kOther);
  const auto begin = std::chrono::steady_clock::now();
  const auto name_in_use = [&] {
    const auto first = names_in_use({&here, 1}).at(0);
    return first ? first->name : std::string();
  };
  EXPECT_EQ(name_in_use(), "");
  EXPECT_GE(std::chrono::steady_clock::now() - begin, kShortLook);
  other.emplace(places.there, kOther);
  // Its status may come after a look on a machine that has much to do, but it comes.
  std::string found;
  for (int i = 0; i < 60 && found.empty(); ++i) found = name_in_use();
  EXPECT_EQ(found, "cansyncd 0.1.0, process 1234 on host plc\\x0a7");
}

}  // namespace
}  // namespace gateway::dds
