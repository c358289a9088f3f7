// How requests end that have no final answer, in each protocol: the table of docs/dds-api.md, printed from the
// functions that give outcome, reply code and exit status. CANSYNC_WRITE_DOCS=1 writes it into the document.

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "can/job_ending.h"
#include "cansync/channel/outcome_rules.h"
#include "cansync/dds/convert.h"
#include "cli/base/exit_codes.h"
#include "cli/connect/gateway_reply.h"
#include "daemon/cansync_slave/gateway/slave_requests.h"
#include "j1939/answers.h"
#include "j1939/dds/convert.h"
#include "layer2/dds/convert.h"
#include "layer2/station.h"

namespace cansyncd {
namespace {

using can::JobEnd;
using can::JobEnding;
using can::JobKnown;

constexpr std::array kEnds = {std::pair{JobEnd::unanswered, "no answer"},
                              std::pair{JobEnd::time, "time over"}, std::pair{JobEnd::cancelled, "cancel"},
                              std::pair{JobEnd::stopped, "stop"}, std::pair{JobEnd::lost, "loss"}};
constexpr std::array kKnown = {std::pair{JobKnown::not_sent, "not sent"},
                               std::pair{JobKnown::handed_over, "handed over"},
                               std::pair{JobKnown::taken, "busy"}};
static_assert(kEnds.size() == can::kJobEnds && kKnown.size() == can::kJobKnown);

constexpr std::string_view kBegin = "<!-- made by job_endings_test: begin -->\n";
constexpr std::string_view kEnd = "<!-- made by job_endings_test: end -->\n";

/// Reply code and exit status of `cansync`.
std::string cell(gateway_ReplyCode code) {
  static constexpr std::array kCodes = {
      "DONE",      "REFUSED",        "SLAVE_ERROR",         "TIMEOUT",
      "NO_ANSWER", "WORD_EXPECTED",  "DOUBLEWORD_EXPECTED", "VALUE_TOO_WIDE",
      "CANCELLED", "MASTER_STOPPED", "SLAVE_LOST",          "REPLACED"};
  const cansync::client::Reply reply = cansync::cli::reply_of({.replied = true, .code = code});
  return std::string(kCodes.at(code)) + ", " +
         std::to_string(static_cast<unsigned>(cansync::cli::exit_code(reply.code)));
}

std::string table() {
  std::string text = "| ended by | known | CANsync | frames | J1939 |\n|---|---|---|---|---|\n";
  for (const auto& [end, what] : kEnds)
    for (const auto& [known, state] : kKnown) {
      const bool frames = known != JobKnown::taken;
      const bool station = frames && end != JobEnd::lost;
      text += std::string("| ") + what + " | " + state + " | " +
              cell(cansync::dds::to_reply_code(cansync::outcome_of(known, end))) + " | " +
              (station ? cell(layer2::dds::to_reply_code(layer2::outcome_of(known, end))) : "–") + " | " +
              (frames ? cell(j1939::dds::to_reply_code(j1939::outcome_of(known, end))) : "–") + " |\n";
    }
  return text;
}

TEST(JobEndings, TheTableOfTheDocumentIsThatOfTheProgram) {
  std::ifstream file(CANSYNC_DDS_API_DOC);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::size_t begin = text.find(kBegin);
  const std::size_t end = text.find(kEnd);
  ASSERT_TRUE(begin != std::string::npos && end != std::string::npos && begin < end) << CANSYNC_DDS_API_DOC;
  const std::size_t from = begin + kBegin.size();
  if (std::getenv("CANSYNC_WRITE_DOCS") != nullptr)  // NOLINT(concurrency-mt-unsafe): one thread
    std::ofstream(CANSYNC_DDS_API_DOC) << text.substr(0, from) << table() << text.substr(end);
  else
    EXPECT_EQ(text.substr(from, end - from), table())
        << "write it anew: CANSYNC_WRITE_DOCS=1 job_endings_test";
}

TEST(JobEndings, OfTheSlaveRoleEveryPairHasTheOutcomeOfTheTable) {
  for (const auto& [end, what] : kEnds)
    for (const auto& [known, state] : kKnown) {
      const SlaveOutcome outcome = slave_outcome_of(known, end);
      const JobEnding ending = can::ending_of(known, end);
      EXPECT_EQ(outcome == SlaveOutcome::cancelled, ending == JobEnding::cancelled) << what << ", " << state;
      EXPECT_EQ(outcome == SlaveOutcome::stopped, ending == JobEnding::stopped) << what << ", " << state;
      EXPECT_NE(outcome, SlaveOutcome::done) << what << ", " << state;
      // The document gives one column for both.
      const bool has_column =
          known != JobKnown::taken && (end == JobEnd::cancelled || end == JobEnd::stopped);
      const auto frames = layer2::dds::to_reply_code(layer2::outcome_of(known, end));
      EXPECT_TRUE(!has_column || reply_code_of(outcome) == frames) << what << ", " << state;
    }
  EXPECT_EQ(slave_outcome_of(SlaveOrderDone{}), SlaveOutcome::done);
  EXPECT_EQ(slave_outcome_of(SlaveOrderDone{.stopped = JobKnown::not_sent}), SlaveOutcome::stopped);
  EXPECT_EQ(slave_outcome_of(SlaveOrderDone{.stopped = JobKnown::handed_over}), SlaveOutcome::no_answer);
}

TEST(JobEndings, NothingThatWasHandedOverIsCalledCancelledStoppedOrLost) {
  for (const auto& [end, what] : kEnds)
    for (const auto& [known, state] : kKnown) {
      const JobEnding ending = can::ending_of(known, end);
      const bool says_nothing_was_sent =
          ending == JobEnding::cancelled || ending == JobEnding::stopped || ending == JobEnding::lost;
      EXPECT_EQ(says_nothing_was_sent && known != JobKnown::not_sent, false) << what << ", " << state;
      EXPECT_EQ(ending == JobEnding::taken, known == JobKnown::taken && end != JobEnd::time)
          << what << ", " << state;
    }
}

}  // namespace
}  // namespace cansyncd
