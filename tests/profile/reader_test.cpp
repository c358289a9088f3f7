// What a profile says, and everything that can be wrong with one but its limits.
#include "profile/reader.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "profile/hash.h"
#include "profile/meaning.h"
#include "profile_text.h"

namespace profile {
namespace {

namespace fs = std::filesystem;

TEST(ProfileReader, ReadsEveryKey) {
  const Reading reading = parse(R"([profile]
name = "drive-4"
text = "a drive"
[[parameter]]
number = 4095
name = "torque-offset"
format = "word"
signed = true
unit = "%"
factor = 0.1
offset = 2
minimum = -98.0
maximum = 102
access = "read-write"
volatile = true
group = "motion"
text = "what it does"
[[parameter]]
number = 7
name = "type"
format = "doubleword"
access = "read-only"
identity = "type"
)",
                                "f");
  ASSERT_TRUE(reading.profile) << problems_text(reading.problems);
  const Profile& profile = *reading.profile;
  EXPECT_EQ(profile.name, "drive-4");
  EXPECT_EQ(profile.text, "a drive");
  ASSERT_EQ(profile.parameters.size(), 2U);
  EXPECT_EQ(profile.parameters[0].number, 7) << "by rising number";
  EXPECT_EQ(profile.parameters[0].identity, Identity::type);
  EXPECT_EQ(profile.parameters[0].access, Access::read_only);
  EXPECT_FALSE(profile.parameters[0].limited);
  EXPECT_EQ(profile.parameters[0].maximum, 4294967295);
  const Parameter* torque = profile.find("torque-offset");
  ASSERT_NE(torque, nullptr);
  EXPECT_EQ(torque, profile.find(4095));
  EXPECT_EQ(profile.find(8), nullptr);
  EXPECT_EQ(profile.find("torque"), nullptr);
  EXPECT_TRUE(torque->is_signed && torque->is_volatile && torque->limited);
  EXPECT_EQ(torque->minimum, -1000);
  EXPECT_EQ(torque->maximum, 1000);
  EXPECT_EQ(torque->unit + torque->group + torque->text, "%motionwhat it does");
}

TEST(ProfileMeaning, BitsAndNumbersAreWords) {
  const Reading reading = parse(
      one_parameter("bits = [\"0 ready\", \"3 fault!\", \"15 in step\"]\nvalues = [\"9 both\"]\n"), "f");
  ASSERT_TRUE(reading.profile) << problems_text(reading.problems);
  const Parameter& parameter = reading.profile->parameters.front();
  EXPECT_EQ(words(parameter, 0x8001), "ready, in step");
  EXPECT_EQ(words(parameter, 9), "both, ready, fault");
  EXPECT_EQ(words(parameter, 0x10), "");
  EXPECT_EQ(fault_words(parameter, 0x8009), "fault");
  EXPECT_EQ(fault_words(parameter, 0x8001), "");
}

TEST(ProfileMeaning, WhatIsNoListOfNumbersAndWordsIsRefused) {
  for (const char* wrong : {"bits = 3", "bits = [3]", "bits = [\"fault\"]", "bits = [\"16 fault\"]",
                            "bits = [\"-1 fault\"]", "bits = [\"3 a\", \"3 b\"]", "bits = [\"3 \"]",
                            "bits = [\"3 !\"]", "values = [\"65536 much\"]", "bits = [\"3x fault\"]"}) {
    const Reading reading = parse(one_parameter(std::string(wrong) + "\n"), "f");
    ASSERT_EQ(reading.problems.size(), 1U) << wrong;
    EXPECT_NE(reading.problems[0].text.find("allowed: a list of \"NUMBER WORDS\""), std::string::npos);
  }
}

TEST(ProfileReader, TheHashIsThatOfTheFile) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const std::string toml = one_parameter("");
  EXPECT_EQ(parse(toml, "f").profile->hash, sha256(toml));
}

TEST(ProfileReader, WhatIsMissingIsNamed) {
  EXPECT_EQ(problems_of(""),
            "f:1:1: profile: is missing; allowed: a section [profile] with a name\n"
            "f:1:1: parameter: is missing; allowed: at least one section [[parameter]]\n");
  EXPECT_EQ(problems_of("[profile]\ntext = \"x\"\n[[parameter]]\nnumber = 1\n"),
            "f:1:1: profile.name: is missing; allowed: 1..64 lower-case letters, digits and '-', the same as "
            "the file's name\n"
            "f:3:1: parameter.name: is missing; allowed: 1..64 lower-case letters, digits and '-'\n"
            "f:3:1: parameter.format: is missing; allowed: \"word\", \"doubleword\"\n"
            "f:3:1: parameter.access: is missing; allowed: \"read-write\", \"read-only\", \"none\"\n");
}

TEST(ProfileReader, UnknownKeysAndSections) {
  EXPECT_EQ(problems_of(one_parameter("units = \"rpm\"\n")),
            "f:7:1: parameter.units: no key of this section; allowed: number, name, format, signed, unit, "
            "factor, offset, minimum, maximum, access, volatile, identity, tells, actual_value, group, text, "
            "bits, values\n");
  EXPECT_EQ(problems_of(one_parameter("[other]\n")),
            "f:7:2: other: no section of a profile; allowed: [profile] once, [[parameter]] for each "
            "parameter\n");
  EXPECT_EQ(problems_of("parameter = 3\n[profile]\nname = \"p\"\n"),
            "f:1:1: parameter: no section of a profile; allowed: [profile] once, [[parameter]] for each "
            "parameter\n");
}

TEST(ProfileReader, SaysHowADriveIsRecognisedAndWhatItTells) {
  const std::string text =
      "[profile]\nname = \"p\"\nrecognised_by = [\"7=4400\", \"9=4294967295\"]\n"
      "[[parameter]]\nnumber = 1\nname = \"a\"\nformat = \"doubleword\"\naccess = \"read-only\"\n"
      "tells = \"actual-mapping-2\"\nactual_value = 7\n";
  const Reading reading = parse(text, "f");
  ASSERT_TRUE(reading.profile) << problems_of(text);
  ASSERT_EQ(reading.profile->recognised_by.size(), 2u);
  EXPECT_EQ(reading.profile->recognised_by[1].number, 9);
  EXPECT_EQ(reading.profile->recognised_by[1].value, 4294967295u);
  ASSERT_NE(reading.profile->telling(Tells::actual_mapping_2), nullptr);
  EXPECT_EQ(reading.profile->telling(Tells::actual_mapping_1), nullptr);
  EXPECT_EQ(reading.profile->parameters[0].actual_value, 7);
}

TEST(ProfileReader, RefusesWhatNoScanCanUse) {
  const auto recognised_by = [](const std::string& list) {
    return problems_of(
        "[profile]\nname = \"p\"\nrecognised_by = " + list +
        "\n[[parameter]]\nnumber = 1\nname = \"a\"\nformat = \"word\"\naccess = \"read-only\"\n");
  };
  EXPECT_EQ(recognised_by("[\"1=2\"]"), "");
  for (const char* list :
       {"[]", "[\"7\"]", "[\"4096=1\"]", "[\"1=4294967296\"]", "[\"1=2\", \"1=3\"]", "\"1=2\""})
    EXPECT_NE(recognised_by(list), "") << list;
  EXPECT_NE(problems_of(one_parameter("tells = \"speed\"\n")), "");
  EXPECT_NE(problems_of(one_parameter("tells = \"actual-mapping-1\"\n")), "")
      << "a word holds no four registers";
  EXPECT_NE(problems_of(one_parameter("actual_value = 8\n")), "");
  const std::string again =
      "[[parameter]]\nnumber = 13\nname = \"b\"\nformat = \"word\"\naccess = \"read-only\"\n";
  EXPECT_NE(problems_of(one_parameter("tells = \"status-word\"\n" + again + "tells = \"status-word\"\n"))
                .find("found \"status-word\" again"),
            std::string::npos);
}

TEST(ProfileReader, NumbersAndNamesAreThereOnce) {
  const std::string again =
      "[[parameter]]\nnumber = 12\nname = \"speed-limit\"\nformat = \"word\"\naccess = \"none\"\n";
  EXPECT_EQ(problems_of(one_parameter(again)),
            "f:8:10: parameter.number: found 12 again, first used by the parameter in line 2; allowed: each "
            "number once\n"
            "f:9:8: parameter.name: found \"speed-limit\" again, first used by the parameter in line 2; "
            "allowed: each name once\n");
}

TEST(ProfileReader, NamesAreLowerCaseLettersDigitsAndDashes) {
  for (const char* name : {"", "Speed", "speed_limit", "1speed", "-speed", "drehzahl-maß", "a b"}) {
    EXPECT_FALSE(is_name(name)) << name;
  }
  EXPECT_TRUE(is_name("p"));
  EXPECT_TRUE(is_name("ramp-2-up"));
  EXPECT_TRUE(is_name(std::string(64, 'a')));
  EXPECT_FALSE(is_name(std::string(65, 'a')));
  EXPECT_EQ(problems_of(one_parameter("group = \"Motion\"\n")),
            "f:7:9: parameter.group: found \"Motion\"; allowed: 1..64 lower-case letters, digits and '-', "
            "beginning with a letter, in quotes\n");
}

TEST(ProfileReader, WrongTypesAndRanges) {
  const auto first_of = [](const std::string& line) { return problems_of(one_parameter(line + "\n")); };
  EXPECT_EQ(first_of("signed = 1"), "f:7:10: parameter.signed: found 1; allowed: true or false\n");
  EXPECT_EQ(first_of("factor = \"1\""), "f:7:10: parameter.factor: found \"1\"; allowed: a finite number\n");
  EXPECT_EQ(first_of("factor = 0.0"),
            "f:7:10: parameter.factor: found 0; allowed: a finite number other than 0\n");
  EXPECT_EQ(first_of("offset = nan"), "f:7:10: parameter.offset: found nan; allowed: a finite number\n");
  EXPECT_EQ(first_of("unit = \"in s\""),
            "f:7:8: parameter.unit: found \"in s\"; allowed: a string of up to 16 bytes without blanks\n");
  EXPECT_EQ(first_of("text = \"a\\nb\""),
            "f:7:8: parameter.text: found \"a\\x0ab\"; allowed: a string of up to 200 bytes on one line\n");
  EXPECT_EQ(first_of("text = [1]"),
            "f:7:8: parameter.text: found a value of type array; allowed: a string of up to 200 bytes on one "
            "line\n");
  EXPECT_EQ(problems_of("[profile]\nname = \"p\"\n[[parameter]]\nnumber = 4096\nname = \"a\"\nformat = "
                        "\"byte\"\naccess = \"rw\"\n"),
            "f:4:10: parameter.number: found 4096; allowed: 0..4095\n"
            "f:6:10: parameter.format: found \"byte\"; allowed: \"word\", \"doubleword\"\n"
            "f:7:10: parameter.access: found \"rw\"; allowed: \"read-write\", \"read-only\", \"none\"\n");
}

TEST(ProfileReader, WhatIdentifiesADriveIsReadOnly) {
  EXPECT_EQ(problems_of(one_parameter("identity = \"unit\"\n")),
            "f:7:12: parameter.identity: found beside a parameter that is not read-only or is volatile; "
            "allowed: with access = \"read-only\" and without volatile\n");
}

TEST(ProfileReader, WhatIsNoTomlHasAPlace) {
  EXPECT_TRUE(problems_of("[profile\n").starts_with("f:1:"));
  std::string deep = "a";
  for (int i = 0; i < 100'000; ++i) deep += ".a";
  EXPECT_TRUE(problems_of(deep + " = 1\n").starts_with("f:1:")) << "a key that would take the stack";
}

TEST(ProfileReader, AParameterWithAProblemIsLeftOutWhole) {
  const std::string more =
      "[[parameter]]\nnumber = 13\nname = \"ramp\"\nformat = \"word\"\naccess = \"read-write\"\nfactr = 0.1\n"
      "[[parameter]]\nnumber = 14\nname = \"gain\"\nformat =\naccess = \"read-write\"\n"
      "[[parameter]]\nnumber = 15\nname = \"last\"\nformat = \"word\"\naccess = \"read-write\"\n";
  const Reading reading = parse(one_parameter(more), "f");
  ASSERT_TRUE(reading.profile) << problems_text(reading.problems);
  std::string names;
  for (const Parameter& parameter : reading.profile->parameters) names += parameter.name + " ";
  EXPECT_EQ(names, "speed-limit last ");
  EXPECT_EQ(reading.problems.size(), 2U) << problems_text(reading.problems);
  EXPECT_FALSE(
      parse("[profile]\nname = \"p\"\n" + more.substr(0, more.find("[[parameter]]", 5)), "f").profile)
      << "without anything that can be used";
}

TEST(ProfileReader, OnlySoManyProblemsAreTold) {
  std::string keys;
  for (int i = 0; i < 25; ++i) keys += "key" + std::to_string(i) + " = 1\n";
  const std::string text = problems_of(one_parameter(keys));
  EXPECT_TRUE(text.ends_with("and 5 more problems\n")) << text;
}

TEST(ProfileReader, AFileIsCalledLikeItsProfile) {
  const fs::path folder = fs::temp_directory_path() / ("profile_test_" + std::to_string(getpid()));
  fs::create_directory(folder);
  const std::string right = (folder / "p.toml").string();
  const std::string wrong = (folder / "q.toml").string();
  std::ofstream(right) << one_parameter("");
  std::ofstream(wrong) << one_parameter("");
  EXPECT_EQ(problems_text(read(right).problems), "");
  EXPECT_EQ(problems_text(read(wrong).problems),
            wrong + ": profile.name: found \"p\" in a file called q.toml; allowed: the same name\n");
  EXPECT_EQ(problems_text(read((folder / "none.toml").string()).problems),
            (folder / "none.toml").string() + ": cannot read this profile: No such file or directory\n");
  fs::remove_all(folder);
}

}  // namespace
}  // namespace profile
