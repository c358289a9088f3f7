#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>

namespace test {

/// The table that follows the line `marker` of the file `document`, up to an empty line.
inline std::string documented_table(const std::string& document, const std::string& marker) {
  std::ifstream file(document);
  EXPECT_TRUE(file) << document;
  std::string line;
  while (std::getline(file, line) && line != marker) {
  }
  EXPECT_TRUE(file) << marker << " is missing";
  std::string table;
  while (std::getline(file, line) && !line.empty()) table += line + "\n";
  return table;
}

/// What the document must say of `next` for the enumerators 0..states-1 and 0..events-1: rows are states,
/// columns events, – an event that cannot come in that state.
template <class State, class Event>
std::string table_of_next(unsigned states, unsigned events) {
  std::string table = "| state |";
  std::string rule = "|---|";
  for (unsigned event = 0; event < events; ++event) {
    table += " " + std::string(name(static_cast<Event>(event))) + " |";
    rule += "---|";
  }
  table += "\n" + rule + "\n";
  for (unsigned from = 0; from < states; ++from) {
    const State state = static_cast<State>(from);
    table += "| `" + std::string(name(state)) + "` |";
    for (unsigned event = 0; event < events; ++event) {
      const auto to = next(state, static_cast<Event>(event));
      table += to ? " `" + std::string(name(*to)) + "` |" : " – |";
    }
    table += "\n";
  }
  return table;
}

/// Every pair gives what the document says.
template <class State, class Event>
void expect_documented(const std::string& document, const std::string& marker, unsigned states,
                       unsigned events) {
  const std::string expected = table_of_next<State, Event>(states, events);
  EXPECT_EQ(documented_table(document, marker), expected)
      << document << " and the code differ. Of the code:\n"
      << expected;
}

}  // namespace test
