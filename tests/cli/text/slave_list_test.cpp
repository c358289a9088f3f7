#include "cli/text/slave_list.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "cli/text/values.h"

namespace cansync::cli {
namespace {

/// A line whose slaves have these names; counts how often it is asked.
class Line {
 public:
  explicit Line(std::map<std::string, int, std::less<>> names, std::uint32_t configured = 0x0F)
      : names_(std::move(names)), configured_(configured) {}

  std::uint32_t parse(std::string_view text) {
    return parse_slave_list(text, {[this](std::string_view name) {
                                     ++asked;
                                     const auto found = names_.find(name);
                                     return found == names_.end() ? -1 : found->second;
                                   },
                                   [this] { return configured_; },
                                   [](std::string_view name) { return "no '" + std::string(name) + "'"; }});
  }

  std::string complaint(std::string_view text) {
    try {
      parse(text);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  }

  int asked = 0;

 private:
  std::map<std::string, int, std::less<>> names_;
  std::uint32_t configured_;
};

TEST(SlaveList, TakesNumbersRangesNamesAndAll) {
  Line line({{"winder", 9}, {"un-winder", 10}});
  EXPECT_EQ(line.parse("winder"), 0x200u);
  EXPECT_EQ(line.parse("0,4-7,winder"), 0x2F1u);
  EXPECT_EQ(line.parse("un-winder,3"), 0x408u) << "only numbers have ranges";
  EXPECT_EQ(line.parse("all"), 0x0Fu);
  EXPECT_EQ(line.parse("all,winder"), 0x20Fu);
  EXPECT_EQ(line.parse("winder,winder"), 0x200u);
}

TEST(SlaveList, ANumberAsksNobody) {
  Line line({{"3", 9}});
  EXPECT_EQ(line.parse("0"), 0x1u);
  EXPECT_EQ(line.parse("31"), 0x80000000u);
  EXPECT_EQ(line.parse("0x5"), 0x20u) << "a number, no mask";
  EXPECT_EQ(line.parse("3"), 0x8u) << "no configuration takes a number for a name";
  EXPECT_EQ(line.asked, 0);
  EXPECT_EQ(line.parse("1,3,5-9"), 0x3EAu);
  EXPECT_EQ(line.parse("3-3"), 0x8u);
}

TEST(SlaveList, WhatIsANameTooIsAmbiguous) {
  Line line({{"1-2", 7}, {"front,rear", 6}, {"rear", 8}, {"front", 9}, {"all", 5}, {"a-b", 4}});
  for (const char* text : {"1-2", "3,1-2", "front,rear", "all", "all,rear"}) {
    const std::string told = line.complaint(text);
    EXPECT_NE(told.find("is ambiguous"), std::string::npos) << text << ": " << told;
  }
  EXPECT_NE(line.complaint("1-2").find("slave 7 has this name"), std::string::npos);
  EXPECT_EQ(line.parse("a-b"), 0x10u) << "no range";
  EXPECT_EQ(line.parse("rear,front"), 0x300u);
}

TEST(SlaveList, WrongNumbersAreToldBeforeNamesAreAsked) {
  Line line({});
  EXPECT_EQ(line.complaint("winder,32"), "SLAVE: found '32'; allowed: 0..31, decimal or hexadecimal (0x..)");
  EXPECT_EQ(line.complaint("7-4,winder"),
            "SLAVE: found range '7-4'; allowed: the smaller number first, such as 4-7");
  for (const char* text : {"-1", "1-32", "1-", "3x", "1-2-3"}) EXPECT_NE(line.complaint(text), "") << text;
  EXPECT_EQ(line.asked, 0);
}

TEST(SlaveList, EmptyPartsAndUnknownNamesAreRefused) {
  Line line({{"winder", 1}});
  for (const char* text : {"", ",", "1,", ",1", "1,,2", "winder,"})
    EXPECT_NE(line.complaint(text).find(fmt::format("SLAVE: found '{}'; allowed: a number, a name", text)),
              std::string::npos)
        << line.complaint(text);
  EXPECT_EQ(line.complaint("winder,nobody"), "SLAVE: no 'nobody'");
  Line empty({}, 0);
  EXPECT_EQ(empty.complaint("all"), "SLAVE: found 'all'; no slave is configured");
}

TEST(SlaveList, WhatIsWrittenAsASetIsReadAgain) {
  Line line({});
  for (const std::uint32_t mask : {0x1u, 0x80000001u, 0xAAAAAAAAu, 0xFFFFFFFFu, 0x0FF00FF0u})
    EXPECT_EQ(line.parse(format_slave_set(mask)), mask);
}

TEST(SlaveFile, HasNumberAndNameFilledIn) {
  EXPECT_EQ(file_of_slave("b/{slave}-{name}.toml", 3, "winder"), "b/3-winder.toml");
  EXPECT_EQ(file_of_slave("{name}{name}", 3, "{slave}"), "{slave}{slave}") << "a name is no pattern";
  EXPECT_EQ(file_of_slave("{name}", 3, "{name}"), "{name}");
  EXPECT_EQ(file_of_slave("plain", 3, "../x"), "plain");
  EXPECT_THROW(static_cast<void>(file_of_slave("{name}", 3, "../x")), UsageError);
  EXPECT_THROW(static_cast<void>(file_of_slave("{name}", 3, "")), UsageError);
  EXPECT_TRUE(is_file_pattern("x{slave}"));
  EXPECT_TRUE(is_file_pattern("{name}"));
  EXPECT_FALSE(is_file_pattern("{other}"));
}

}  // namespace
}  // namespace cansync::cli
