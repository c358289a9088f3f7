#include "text/json.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace text {
namespace {

TEST(Json, KeepsTheOrderOfTheKeys) {
  JsonObject object;
  object.add("b", 1).add("a", "x").add("c", true).add_null("d");
  object.add("e", JsonArray().add(1u).add("two").add(2.5).add_null().add(false));
  object.add("f", JsonObject().add("g", std::uint64_t{18446744073709551615u}));
  EXPECT_EQ(
      object.text(),
      R"({"b":1,"a":"x","c":true,"d":null,"e":[1,"two",2.5,null,false],"f":{"g":18446744073709551615}})");
}

TEST(Json, WritesBytesAsNumbers) {
  EXPECT_EQ(JsonObject().add("byte", std::uint8_t{65}).text(), R"({"byte":65})");
}

TEST(Json, EscapesWhatMustNotStandInAString) {
  EXPECT_EQ(json_string("a\"b\\c\n\r\t\x01\x1f"), R"("a\"b\\c\n\r\t\u0001\u001f")");
  EXPECT_EQ(json_string("°C"), "\"°C\"");
}

TEST(Json, ReplacesWhatIsNoText) {
  EXPECT_EQ(json_string("a\xffz"), "\"a\uFFFDz\"");
}

TEST(Json, HasNoNumberForInfinity) {
  EXPECT_EQ(json_number(std::numeric_limits<double>::infinity()), "null");
  EXPECT_EQ(json_number(std::numeric_limits<double>::quiet_NaN()), "null");
  EXPECT_EQ(json_number(-0.25), "-0.25");
}

}  // namespace
}  // namespace text
