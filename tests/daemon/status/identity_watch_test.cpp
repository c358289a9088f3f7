#include "daemon/status/identity_watch.h"

#include <gtest/gtest.h>

#include <string>

namespace cansyncd {
namespace {

using std::chrono::days;
using std::chrono::hours;
using std::chrono::seconds;

const auto kEnd = IdentityWatch::WallTime(std::chrono::sys_days(std::chrono::year(2026) / 12 / 31));

gateway::dds::IdentityEnd ending(IdentityWatch::WallTime at = kEnd, bool is_authority = false) {
  return {"/etc/cansync/security/certificate.pem", at, is_authority};
}

TEST(IdentityWatch, With31DaysLeftNothingIsToldAndWith29OneWarning) {
  IdentityWatch watch(ending());
  EXPECT_FALSE(watch.look(kEnd - days{31}, ending()));
  EXPECT_EQ(watch.time_left(kEnd - days{31}), seconds{31 * 86400});
  const auto event = watch.look(kEnd - days{29}, ending());
  ASSERT_TRUE(event);
  EXPECT_EQ(event->code, "identity_ending");
  EXPECT_EQ(event->severity, gateway_SEVERITY_WARNING);
  EXPECT_EQ(
      event->text,
      "the identity of DDS Security (/etc/cansync/security/certificate.pem) ends on 2026-12-31 00:00 UTC, in 29 "
      "days; at that time DDS removes the daemon's participant: no client reaches it, and reference values stop; "
      "renew it where the authorities are (cansync-security renew DIR NAME), copy the folder DIR/NAME here, and "
      "restart the daemon when the line may stop");
  EXPECT_FALSE(watch.look(kEnd - days{28}, ending())) << "told once";
}

TEST(IdentityWatch, With0DaysLeftItIsAnErrorAlsoAtTheStart) {
  IdentityWatch watch(ending());
  const auto event = watch.look(kEnd, ending());
  ASSERT_TRUE(event);
  EXPECT_EQ(event->code, "identity_ended");
  EXPECT_EQ(event->severity, gateway_SEVERITY_ERROR);
  EXPECT_NE(event->text.find("ended on 2026-12-31 00:00 UTC; renew it"), std::string::npos) << event->text;
  EXPECT_EQ(watch.time_left(kEnd + hours{1}), seconds{0});
  EXPECT_FALSE(watch.look(kEnd + days{1}, ending()));
}

TEST(IdentityWatch, TheLastDaysAreToldAgain) {
  IdentityWatch watch(ending());
  std::string codes;
  for (auto now = kEnd - days{40}; now <= kEnd + days{2}; now += hours{1}) {
    if (const auto event = watch.look(now, ending()))
      codes += std::string(event->code.word()) + " " + std::to_string((kEnd - now) / days{1}) + " ";
  }
  EXPECT_EQ(codes, "identity_ending 30 identity_ending 7 identity_ending 1 identity_ended 0 ");
}

TEST(IdentityWatch, AClockThatIsSetIsFollowed) {
  IdentityWatch watch(ending());
  EXPECT_TRUE(watch.look(kEnd - days{5}, ending()));
  EXPECT_FALSE(watch.look(kEnd - days{300}, ending())) << "set back";
  EXPECT_EQ(watch.time_left(kEnd - days{300}), seconds{300 * 86400});
  EXPECT_TRUE(watch.look(kEnd - days{29}, ending())) << "and it comes near again";
  EXPECT_TRUE(watch.look(kEnd + days{400}, ending())) << "set far ahead";
}

TEST(IdentityWatch, OfRenewedFilesTheRestartIsWhatIsMissing) {
  IdentityWatch watch(ending());
  const auto event = watch.look(kEnd - days{2}, ending(kEnd + days{3000}));
  ASSERT_TRUE(event) << "what runs has the old ones";
  EXPECT_NE(event->text.find("the files on disk are valid until 2035-03-19 00:00 UTC: restart the daemon"),
            std::string::npos)
      << event->text;
  const auto ended = watch.look(kEnd + days{1}, ending(kEnd + days{3000}));
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, "identity_ended");
  IdentityWatch restarted(ending(kEnd + days{3000}));
  EXPECT_FALSE(restarted.look(kEnd + days{1}, ending(kEnd + days{3000})));
}

TEST(IdentityWatch, AnAuthorityIsNotRenewed) {
  IdentityWatch watch(ending(kEnd, true));
  const auto event = watch.look(kEnd - days{2}, std::nullopt);
  ASSERT_TRUE(event);
  EXPECT_NE(event->text.find("an authority cannot be renewed"), std::string::npos) << event->text;
}

TEST(IdentityWatch, WithoutDdsSecurityThereIsNothing) {
  IdentityWatch watch(std::nullopt);
  EXPECT_FALSE(watch.is_used());
  EXPECT_FALSE(watch.look(kEnd, std::nullopt));
  EXPECT_EQ(watch.time_left(kEnd), seconds{0});
}

}  // namespace
}  // namespace cansyncd
