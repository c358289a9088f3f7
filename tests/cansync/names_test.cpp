// Every enumerator has a name of its own; every code of the manuals' tables has a meaning.

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <set>
#include <string>

#include "cansync/channel/jobs.h"
#include "cansync/channel/transfer_phase.h"
#include "cansync/master.h"
#include "cansync/settings/mode.h"
#include "cansync/supervision/slave_state.h"
#include "cansync/telegram/errors.h"
#include "cansync/telegram/telegram.h"
#include "support/documented_table.h"

namespace cansync {
namespace {

// Names of the enumerators 0..last are different, not empty and not the fallback; last + 1 has the fallback.
template <class Enum>
void expect_names(Enum last) {
  const auto count = static_cast<unsigned>(last) + 1;
  std::set<std::string_view> names;
  for (unsigned i = 0; i < count; ++i) {
    const std::string_view text = name(static_cast<Enum>(i));
    EXPECT_FALSE(text.empty());
    EXPECT_FALSE(text.starts_with("unknown_event") || text.starts_with("unknown decode") ||
                 text.starts_with("unknown outcome") || text.starts_with("unknown refusal"))
        << i;
    EXPECT_TRUE(names.insert(text).second) << text;
  }
  EXPECT_TRUE(name(static_cast<Enum>(count)).starts_with("unknown"));
}

TEST(Names, DecodeErrors) {
  expect_names(DecodeError::reserved_bits);
  EXPECT_EQ(static_cast<unsigned>(DecodeError::reserved_bits) + 1, kDecodeErrors);
}
TEST(Names, UnexpectedTelegrams) {
  expect_names(Unexpected::unasked);
  EXPECT_EQ(static_cast<unsigned>(Unexpected::unasked) + 1, kUnexpectedKinds);
}
TEST(Names, Outcomes) {
  expect_names(Outcome::taken);
}
TEST(Names, Refusals) {
  expect_names(Refusal::beyond_limit);
}
TEST(Names, BusAccesses) {
  expect_names(BusAccess::other_master);
}
TEST(Names, Events) {
  expect_names(MasterEvent::Code::slave_status_refused);
}
TEST(Names, SlaveStates) {
  expect_names(SlaveState::held);
  EXPECT_EQ(static_cast<unsigned>(SlaveState::held) + 1, kSlaveStates);
  expect_names(SlaveEvent::duplicated);
  EXPECT_EQ(static_cast<unsigned>(SlaveEvent::duplicated) + 1, kSlaveEvents);
}

// One word for one state: of the code, and of the table in the document.
TEST(Names, OperatingStatesAsTheDocumentHasThem) {
  const std::string table =
      ::test::documented_table(CANSYNC_PROTOCOL_DOC, "<!-- words for the operating states -->");
  for (const State state :
       {State::start_up, State::waiting_for_initialisation, State::waiting_for_start, State::setting_up_slave,
        State::active_slave, State::setting_up_master, State::active_master}) {
    char row[80] = {};
    static_cast<void>(std::snprintf(row, sizeof row, "\n| %s | `0x%04X` | ", std::string(name(state)).c_str(),
                                    static_cast<unsigned>(state)));
    EXPECT_NE(table.find(row), std::string::npos) << row << " is not in\n" << table;
  }
  EXPECT_EQ(name(static_cast<State>(0xFFFF)), "unknown state");
}
TEST(Names, CommandsAreCalledAsTheVerbHasThem) {
  EXPECT_EQ(name(ControlCommand::start_synchronous), "setup");
  EXPECT_EQ(name(ControlCommand::enable_active), "run");
  EXPECT_EQ(name(ControlCommand::cold_restart), "restart");
  EXPECT_EQ(name(ControlCommand::reset_can), "reset-can");
}

TEST(Names, TransferPhases) {
  expect_names(TransferPhase::ended);
  EXPECT_EQ(static_cast<unsigned>(TransferPhase::ended) + 1, kTransferPhases);
  expect_names(TransferEvent::ended);
  EXPECT_EQ(static_cast<unsigned>(TransferEvent::ended) + 1, kTransferEvents);
}

TEST(Names, StatesByTheirRegisterValue) {
  // Those of a slave are called like those of a master.
  for (const auto& own : {std::array{0x0001u, 0x0002u, 0x0003u, 0x0043u, 0x0080u},
                          std::array{0x0001u, 0x0002u, 0x0003u, 0x0013u, 0x0020u}}) {
    std::set<std::string_view> names;
    for (const unsigned value : own) {
      const std::string_view text = name(static_cast<State>(value));
      EXPECT_NE(text, "unknown state") << value;
      EXPECT_TRUE(names.insert(text).second) << text;
    }
  }
  for (const unsigned value : {0x0000u, 0x0011u, 0x0012u, 0x0041u, 0x0042u}) {  // reserved
    EXPECT_EQ(name(static_cast<State>(value)), "unknown state") << value;
  }
}

TEST(Names, CommandsByTheirRegisterValue) {
  std::set<std::string_view> names;
  for (const unsigned value : {0x0000u, 0x0001u, 0x0002u, 0x0020u, 0x0040u, 0x0080u}) {
    const std::string_view text = name(static_cast<ControlCommand>(value));
    EXPECT_NE(text, "unknown command") << value;
    EXPECT_TRUE(names.insert(text).second) << text;
  }
  for (const unsigned value : {0x0012u, 0x0013u, 0x0004u}) {
    EXPECT_EQ(name(static_cast<ControlCommand>(value)), "unknown command") << value;
  }
}

template <class Error>
void expect_meanings(std::initializer_list<unsigned> codes) {
  std::set<std::string_view> known;
  unsigned unknown = 0;
  for (unsigned code = 0; code <= 0xFFFF; ++code) {
    const std::string_view text = meaning(static_cast<Error>(code));
    if (text == "unknown error code") {
      ++unknown;
    } else {
      EXPECT_TRUE(known.insert(text).second) << text;
    }
  }
  for (const unsigned code : codes) {
    EXPECT_NE(meaning(static_cast<Error>(code)), "unknown error code") << std::hex << code;
  }
  EXPECT_EQ(unknown, 0x10000 - codes.size());
}

TEST(Meanings, ParameterErrorsOfTheManual) {
  expect_meanings<ParameterError>({0x0000, 0xFFFF, 0xFFFE, 0xFFFD, 0xFFFC, 0xFFFB, 0xFFFA, 0xFFF9});
  EXPECT_EQ(meaning(static_cast<ParameterError>(0xFFFE)), "value below the minimum");
  EXPECT_EQ(meaning(static_cast<ParameterError>(0xFFFD)), "value above the maximum");
}

TEST(Meanings, TransferErrorsOfTheManual) {
  expect_meanings<TransferError>(
      {0x0000, 0x0001, 0x0002, 0x0100, 0x0101, 0x0102, 0x0103, 0x0104, 0x0105, 0x0107, 0x0108});
  EXPECT_EQ(meaning(static_cast<TransferError>(0x0105)), "start address not allowed");
  EXPECT_EQ(meaning(static_cast<TransferError>(0x0106)), "unknown error code");  // reserved in M 3.2.2.6
}

}  // namespace
}  // namespace cansync
