#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "bakery.h"
#include "config/option.h"
#include "config/shown.h"

namespace {

std::vector<std::string> keys(const config::Settings& settings) {
  std::vector<std::string> out;
  for (const config::Setting& setting : settings.items) out.push_back(setting.key);
  return out;
}

std::string problems(const std::string& toml, const std::vector<std::string>& overrides = {}) {
  return config::problems_text(bakery::read(toml, overrides).problems);
}

/// What is wrong with a value.
std::string mismatch(const std::string& key, const std::string& value) {
  bakery::Draft draft;
  const config::Option* option = bakery::rows().table().find(key);
  return bakery::rows().apply(*option, *config::parse_value(value), draft).value_or("");
}

TEST(ConfigProblem, ShowsControlCharactersOfTheFile) {
  EXPECT_EQ(config::to_string({{"a.toml", 2, 8}, "bus.name", "found 'x\x1b[2J'"}),
            "a.toml:2:8: bus.name: found 'x\\x1b[2J'");
}

TEST(ConfigTable, StandsInTheOrderOfItsSectionsWhoeverBroughtTheRows) {
  std::string order;
  for (const config::Option& option : bakery::rows().table().options())
    order += std::string(option.key) + " ";
  EXPECT_EQ(
      order,
      "shop.town shop.loaves shop.open shop.rest_ms shop.closed shop.doors oven.number oven.heat oven.tray.number oven.tray.bread ");
}

TEST(ConfigTable, RefusesRowsThatFitNoSection) {
  const config::Section shop[] = {{"shop", "", ""}};
  const config::Section ovens[] = {{"oven", "oven numbers", ""}};
  const config::Option town = config::rows::boolean("shop.town", "true", "");
  EXPECT_NO_THROW(config::Table(shop, {town}));
  EXPECT_THROW(config::Table(ovens, {town}), std::logic_error);
  EXPECT_THROW(config::Table(ovens, {}), std::logic_error) << "a numbered section without an option number";
}

TEST(ConfigRows, ADefaultIsWhatItsFieldHoldsBeforeAnythingIsRead) {
  const auto initial = [](const char* key) { return std::string(bakery::rows().table().find(key)->initial); };
  EXPECT_EQ(initial("shop.town"), "\"Ulm\"");
  EXPECT_EQ(initial("shop.loaves"), "12");
  EXPECT_EQ(initial("shop.open"), "true");
  EXPECT_EQ(initial("shop.rest_ms"), "1500");
  EXPECT_EQ(initial("shop.closed"), "\"sunday\"");
}

TEST(ConfigRows, AWordAndADurationGoIntoTheirFields) {
  bakery::Draft draft;
  for (const config::Setting& setting : bakery::read("[shop]\nclosed = \"monday\"\nrest_ms = 7\n").items)
    EXPECT_EQ(bakery::rows().apply(*setting.option, setting.value, draft), std::nullopt) << setting.key;
  EXPECT_EQ(draft.shop.closed, bakery::Day::monday);
  EXPECT_EQ(draft.shop.rest, std::chrono::milliseconds(7));
  EXPECT_EQ(mismatch("shop.closed", "\"friday\""), "found \"friday\"; allowed: \"monday\" or \"sunday\"");
}

TEST(ConfigRows, EachRowTakesItsOwnValue) {
  bakery::Draft draft;
  EXPECT_EQ(draft.shop.town, "Ulm");
  EXPECT_EQ(draft.shop.loaves, 12);
  EXPECT_TRUE(draft.shop.open);
  for (const config::Setting& setting :
       bakery::read(
           "[shop]\ntown = \"Bonn\"\n[[oven]]\nnumber = 1\n[[oven.tray]]\nnumber = 0\nbread = \"rye\"\n")
           .items) {
    EXPECT_EQ(bakery::rows().apply(*setting.option, setting.value, draft), std::nullopt) << setting.key;
  }
  EXPECT_EQ(draft.shop.town, "Bonn");
  EXPECT_EQ(draft.trays, std::vector<std::string>{"rye"});
}

TEST(ConfigRows, SayWhatIsAllowed) {
  EXPECT_EQ(mismatch("shop.loaves", "100"), "found 100; allowed: 0..99 loaves");
  EXPECT_EQ(mismatch("shop.loaves", "99"), "");
  EXPECT_EQ(mismatch("shop.open", "1"), "found 1; allowed: true or false");
  EXPECT_EQ(mismatch("oven.heat", "\"oil\""), "found \"oil\"; allowed: \"gas\" or \"wood\"");
  EXPECT_EQ(mismatch("shop.doors", "3"), "found 3; allowed: an even number");
  EXPECT_EQ(mismatch("shop.doors", "4"), "");
  EXPECT_NE(mismatch("oven.tray.bread", "\"12\""), "") << "a number is no name";
}

TEST(ConfigSettings, CarryTheNumbersOfTheirSections) {
  const config::Settings settings =
      bakery::read("[[oven]]\nnumber = 3\n[[oven.tray]]\nnumber = 7\nbread = \"rye\"\n[shop]\nopen = false\n",
                   {"oven.3.heat=wood", "shop.open=true"});
  EXPECT_EQ(config::problems_text(settings.problems), "");
  EXPECT_EQ(keys(settings), (std::vector<std::string>{"oven.3.number", "oven.3.tray.7.bread",
                                                      "oven.3.tray.7.number", "oven.3.heat", "shop.open"}));
  EXPECT_EQ(settings.items[1].numbers, (std::vector<int>{3, 7}));
  EXPECT_TRUE(settings.items.back().overridden);
}

TEST(ConfigSettings, ProblemsNamePlaceFindAndRange) {
  EXPECT_EQ(problems("[ship]\n"), "f:1:2: ship: no such section; allowed: [shop], [[oven]], [[oven.tray]]\n");
  EXPECT_EQ(
      problems("[shop]\ntwon = 1\n"),
      "f:2:1: shop.twon: no such option; allowed in this section: town, loaves, open, rest_ms, closed, doors\n");
  EXPECT_EQ(problems("[oven]\nnumber = 1\n"),
            "f:1:2: oven: found single brackets; allowed: sections [[oven]]\n");
  EXPECT_EQ(problems("[[oven]]\nheat = \"gas\"\n"), "f:1:1: oven.number: missing; allowed: 1..4\n");
  EXPECT_EQ(problems("[[oven]]\nnumber = 5\n"), "f:2:10: oven.number: found 5; allowed: 1..4\n");
  EXPECT_EQ(problems("[[oven]]\nnumber = 1\n[[oven]]\nnumber = 1\n"),
            "f:4:10: oven.number: found 1, which line 2 has already; allowed: each number once\n");
}

TEST(ConfigSettings, LongValuesAreCutInProblems) {
  EXPECT_EQ(config::shown(std::string(80, 'x')), std::string(80, 'x'));
  EXPECT_EQ(config::shown(std::string(1000, 'x')), std::string(60, 'x') + "... (1000 bytes)");
  std::string accents;
  for (int i = 0; i < 50; ++i) accents += "\xC3\xA4";
  EXPECT_EQ(config::shown("y" + accents), "y" + accents.substr(0, 58) + "... (101 bytes)")
      << "no half characters";
  const config::Option* option = bakery::rows().table().find("oven.tray.bread");
  ASSERT_NE(option, nullptr);
  EXPECT_EQ(config::mismatch_text(*option, config::scalar_value(std::string(1000, 'x'))).find("found \"xxx"),
            0u);
  EXPECT_LT(config::mismatch_text(*option, config::scalar_value(std::string(1000, 'x'))).size(), 200u);
  const std::string control = config::mismatch_text(*option, config::scalar_value(std::string("a\tb")));
  EXPECT_EQ(control.find("found \"a\\tb\"; allowed: "), 0u) << control;
  EXPECT_NE(control.find("no control character"), std::string::npos) << control;
}

TEST(ConfigSettings, ProblemsOfOverridesSayTheForm) {
  const auto of = [](const std::string& assignment) {
    const std::string text = problems("", {assignment});
    return text.substr(text.find(": ") + 2);
  };
  EXPECT_EQ(of("oven.5.heat=gas"), "oven.5.heat: found key oven.5.heat; allowed: oven numbers 1..4\n");
  EXPECT_EQ(of("oven.1.tray.10.bread=x"),
            "oven.1.tray.10.bread: found key oven.1.tray.10.bread; allowed: tray numbers 0..9\n");
  EXPECT_EQ(of("oven.1.tray.bread=x"),
            "oven.1.tray.bread: found key oven.1.tray.bread; allowed: oven.N.tray.M.OPTION\n");
  EXPECT_EQ(of("shop.1.open=true"), "shop.1.open: found key shop.1.open; allowed: shop.open\n");
  EXPECT_EQ(of("oven.1.number=1"),
            "oven.1.number: numbers stand in the file alone; allowed: any other option\n");
}

}  // namespace
