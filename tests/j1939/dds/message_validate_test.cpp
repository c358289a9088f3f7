#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "j1939/dds/validate.h"
#include "j1939/transport.h"

namespace j1939::dds {
namespace {

struct Wrong {
  const char* words;
  gateway_RefusalCause cause;
  std::function<void(j1939_MessageRequest&)> change;
  std::function<void(j1939_MessageRequest&)> allow;  ///< what the text says that is allowed
};

TEST(MessageValidate, EachFieldOutOfItsRangeIsToldByNameAndRange) {
  std::vector<std::uint8_t> data(1786);
  j1939_MessageRequest good = {};
  good.pgn = 0xEF00;
  good.destination = 0x21;
  good.data._buffer = data.data();
  good.data._length = 8;
  EXPECT_FALSE(check(good));
  const std::vector<Wrong> all = {
      {"kind 9", gateway_CAUSE_KIND,
       [](auto& r) {
         const unsigned nine = 9;  // as a newer client may say
         std::memcpy(&r.kind, &nine, sizeof(nine));
       },
       [](auto& r) { r.kind = j1939_MESSAGE_SEND; }},
      {"pgn 0x40000", gateway_CAUSE_FIELD, [](auto& r) { r.pgn = 0x40000; },
       [](auto& r) { r.pgn = 0x3EF00; }},
      {"allowed 0xEF00", gateway_CAUSE_FIELD, [](auto& r) { r.pgn = 0xEF21; },
       [](auto& r) { r.pgn = 0xEF00; }},
      {"priority 8", gateway_CAUSE_FIELD, [](auto& r) { r.priority = 8; }, [](auto& r) { r.priority = 7; }},
      {"data: 1786 bytes", gateway_CAUSE_LENGTH, [](auto& r) { r.data._length = 1786; },
       [](auto& r) { std::swap(r.data._length, r.long_data._length); }},
      {"long_data: 1785 bytes", gateway_CAUSE_LENGTH,
       [](auto& r) {
         r.data._length = 0;
         r.long_data._length = 1785;
       },
       [](auto& r) { std::swap(r.data._length, r.long_data._length); }},
      {"beside 8 of data", gateway_CAUSE_LENGTH, [](auto& r) { r.long_data._length = 1786; },
       [](auto& r) { r.data._length = 0; }},
      {"long_data: 1048577", gateway_CAUSE_LENGTH,
       [](auto& r) {
         r.data._length = 0;
         r.long_data._length = 1048577;
       },
       [](auto& r) { r.long_data._length = 1048576; }},
      {"MESSAGE_ASK has none", gateway_CAUSE_LENGTH, [](auto& r) { r.kind = j1939_MESSAGE_ASK; },
       [](auto& r) { r.data._length = 0; }},
      {"destination 254", gateway_CAUSE_FIELD, [](auto& r) { r.destination = 254; },
       [](auto& r) { r.destination = 253; }},
      {"goes to all", gateway_CAUSE_FIELD, [](auto& r) { r.pgn = 0xFEF1; },
       [](auto& r) { r.destination = 255; }},
      {"timeout 3600001", gateway_CAUSE_FIELD, [](auto& r) { r.timeout = 3'600'001; },
       [](auto& r) { r.timeout = 3'600'000; }},
  };
  for (const Wrong& wrong : all) {
    j1939_MessageRequest request = good;
    wrong.change(request);
    const auto problem = check(request);
    ASSERT_TRUE(problem) << wrong.words;
    EXPECT_EQ(problem->cause, wrong.cause) << wrong.words;
    EXPECT_NE(problem->reason.find(wrong.words), std::string::npos) << problem->reason;
    EXPECT_LT(problem->reason.size(), std::size_t{gateway_TEXT});
    wrong.allow(request);
    EXPECT_FALSE(check(request)) << problem->reason;
  }
  good.pgn = 0xFEF1;
  good.data._length = 9;
  EXPECT_FALSE(check(good)) << "in packets a PDU2 group may go to one node";
}

TEST(MessageValidate, EachRefusalHasACauseAndAReasonThatFits) {
  EXPECT_FALSE(explain(Refusal::none, 64, 1785));
  for (const Refusal refusal : {Refusal::queue_full, Refusal::bad_order, Refusal::too_long,
                                Refusal::too_long_for_all, Refusal::no_address, Refusal::stopped}) {
    const auto problem = explain(refusal, 64, 1785);
    ASSERT_TRUE(problem);
    EXPECT_FALSE(problem->reason.empty());
    EXPECT_LT(problem->reason.size(), std::size_t{gateway_TEXT});
  }
}

}  // namespace
}  // namespace j1939::dds
