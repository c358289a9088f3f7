#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dbc/database.h"

namespace dbc {

/// What a file says of the multiplexors of one message, until all of it is known: a signal's own mark (M, m1,
/// m1M) comes before the ranges of SG_MUL_VAL_, which name the multiplexor.
class Choices {
 public:
  /// The mark of the signal that comes next in the message. `value`: behind `m`; nothing: it has none.
  void add_signal(std::optional<std::uint64_t> value) { signals_.push_back({value, std::nullopt}); }

  /// Of SG_MUL_VAL_: the signal is there when the multiplexor is in one of the ranges. Both by their place in
  /// the message. A second one for a signal counts in the place of the first.
  void add_ranges(std::size_t signal, std::size_t multiplexor,
                  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges);

  /// Gives the signals of the message their choices. Those whose multiplexor is not known are taken out of
  /// the message, each with a call of `left_out`: its place in the message as it was, and why.
  void resolve(Message& message, const std::function<void(std::size_t, const std::string&)>& left_out) const;

 private:
  struct Said {
    std::optional<std::uint64_t> mark;  ///< the number behind `m`
    std::optional<Choice> named;        ///< of SG_MUL_VAL_
  };
  /// The multiplexors of a message.
  struct Multiplexors {
    std::size_t all = 0;
    std::size_t unchosen = 0;  ///< that no other one chooses
    std::size_t last_unchosen = 0;
  };

  Multiplexors multiplexors_of(const Message& message) const;

  std::vector<Said> signals_;
};

}  // namespace dbc
