#include <gtest/gtest.h>

#include <string_view>

#include "access_requests.h"
#include "daemon/cansync/texts/profile_rules.h"
#include "profile/reader.h"
#include "support/gateway_rig.h"

/// What the gateway does with drive profiles.
namespace cansyncd {
namespace {

constexpr const char* kProfile = R"(
[profile]
name = "drive"
[[parameter]]
number = 100
name = "speed-limit"
format = "word"
unit = "rpm"
minimum = 10
maximum = 50
access = "read-write"
[[parameter]]
number = 101
name = "version"
format = "word"
access = "read-only"
)";

Config profile_config(bool rules = true) {
  Config config = gateway_config();
  config.access.profile_rules = rules;
  auto profile = profile::parse(kProfile, "profile.toml").profile;
  if (profile) config.slaves[1].parameters = std::make_shared<const profile::Profile>(*profile);
  return config;
}

cansync::ParameterRequest write_of(unsigned slave, unsigned number, std::uint32_t value) {
  cansync::ParameterRequest request;
  request.write = true;
  request.slave = *cansync::SlaveNumber::from(slave);
  request.number = *cansync::ParameterNumber::from(number);
  request.value = value;
  return request;
}

TEST(ProfileRules, OnlyAWriteToAKnownParameterOfTheSlaveItselfIsRefused) {
  const Config config = profile_config();
  const auto refused = profile_refusal(write_of(1, 100, 51), config);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->cause, gateway_CAUSE_PROFILE);
  EXPECT_EQ(refused->reason,
            "speed-limit (parameter 100): found 51 rpm (raw 51); allowed: 10..50 rpm; by its drive profile, "
            "see access.profile_rules");
  EXPECT_TRUE(profile_refusal(write_of(1, 101, 1), config));
  EXPECT_FALSE(profile_refusal(write_of(1, 100, 50), config));
  EXPECT_FALSE(profile_refusal(write_of(1, 102, 51), config)) << "not in the profile";
  EXPECT_FALSE(profile_refusal(write_of(2, 100, 51), config)) << "a slave without a profile";
  cansync::ParameterRequest other = write_of(1, 100, 51);
  other.sub_slave.value = 4;
  EXPECT_FALSE(profile_refusal(other, config)) << "a participant below the slave";
  other = write_of(1, 101, 51);
  other.write = false;
  EXPECT_FALSE(profile_refusal(other, config)) << "a read";
  EXPECT_FALSE(profile_refusal(write_of(1, 100, 51), profile_config(false))) << "switched off";
}

TEST(ProfileRules, ParametersHaveTheirNames) {
  const Config config = profile_config();
  EXPECT_EQ(parameter_label(config, 1, 100), "speed-limit (parameter 100)");
  EXPECT_EQ(parameter_label(config, 1, 7), "parameter 7");
  EXPECT_EQ(parameter_label(config, 2, 100), "parameter 100");
  auto request = parameter(1, true);
  request.slave = 4'000'000'000;
  EXPECT_EQ(parameter_text(config, request), "parameter 100") << "a slave that cannot be";
  request.slave = 1;
  request.sub_slave = 3;
  EXPECT_EQ(parameter_text(config, request), "parameter 100 of sub-slave 3");
}

TEST(GatewayProfile, AWriteOutsideTheLimitsIsRefusedAndRecordedByName) {
  GatewayRig rig(profile_config());
  rig.tell(in_operation());
  rig.client.write(parameter(1, true, 51));
  const auto reply = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_REFUSED);
  EXPECT_NE(std::string_view(reply->reason).find("allowed: 10..50 rpm"), std::string_view::npos)
      << reply->reason;
  const auto entries = rig.journal.with("CANSYNC_REQUEST", "1");
  ASSERT_EQ(entries.size(), 1U);
  EXPECT_EQ(entries.front().field("CANSYNC_WHAT"), "speed-limit (parameter 100)");
  EXPECT_NE(rig.journal.all().front().field("CANSYNC_RESULT").find("refused: profile: speed-limit"),
            std::string::npos);
}

TEST(GatewayProfile, AWriteInsideTheLimitsIsTaken) {
  GatewayRig rig(profile_config());
  rig.tell(in_operation());
  rig.client.write(parameter(1, true, 50));
  const auto request = rig.next_request();
  ASSERT_TRUE(request);
  EXPECT_EQ(std::get<cansync::ParameterRequest>(*request).value, 50U);
}

TEST(GatewayProfile, TheStatusNamesTheProfile) {
  GatewayRig rig(profile_config());
  const auto status_of = [&](unsigned slave) {
    return rig.client.wait_for<cansync_SlaveStatus>(
        [&](const cansync_SlaveStatus& sample) { return sample.slave == slave; });
  };
  const auto with = status_of(1);
  ASSERT_TRUE(with);
  EXPECT_STREQ(with->profile, "drive");
  EXPECT_EQ(std::string_view(with->profile_hash), profile::parse(kProfile, "profile.toml").profile->hash);
  const auto without = status_of(2);
  ASSERT_TRUE(without);
  EXPECT_STREQ(without->profile, "");
  EXPECT_STREQ(without->profile_hash, "");
}

}  // namespace
}  // namespace cansyncd
