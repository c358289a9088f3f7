#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cansync/telegram/mapping.h"
#include "cli/cansync/profiles.h"
#include "cli/scan/question_line.h"

/// Who is on a line where no master runs, and what each drive tells of itself.
namespace cansync::cli {

/// A parameter that was read.
struct FoundParameter {
  std::uint16_t number = 0;
  bool doubleword = false;
  std::uint32_t value = 0;  ///< raw
  std::uint16_t error = 0;  ///< the slave's code, when it has the parameter and gives no value now; 0: none
};

/// A mapping as the drive tells it: reference or actual values, first and second telegram.
using FoundMapping = std::array<std::optional<TelegramMapping>, kChannels>;

/// A slave that answered.
struct FoundSlave {
  SlaveNumber number;
  ProfilePointer profile;  ///< by which it was recognised; null: none
  std::uint16_t status_parameter = 301;
  std::optional<std::uint16_t> status_word;  ///< nothing: it does not give it under that number
  std::optional<std::uint16_t> block_limit;  ///< bytes; nothing: not found out
  bool block_limit_told = false;             ///< by a parameter, not by trying
  FoundMapping reference;
  FoundMapping actual;
  bool twice = false;                      ///< two drives answer with this number
  std::vector<FoundParameter> parameters;  ///< by rising number
};

/// What is to be found out.
struct InquirySettings {
  SlaveMask slaves = SlaveMask::all();
  std::vector<ProfilePointer> profiles;  ///< drives are recognised by these
  bool parameters = false;               ///< every parameter number of every slave that answers
};

/// How far it is: what is done now, of how many.
using InquiryProgress = std::function<void(const std::string& what, unsigned done, unsigned total)>;

/// What came of it.
struct InquiryResult {
  std::vector<FoundSlave> slaves;  ///< by rising number
  bool stopped = false;            ///< it was ended before it was through
  std::string failure;             ///< why the line let it ask no more; empty: it did
};

/// Asks the slaves, one question at a time. Nothing on a drive is changed; an upload that was begun to try a
/// block's length is closed, also when it is stopped or the line fails; what was found until then is kept.
/// Throws as `QuestionLine::ask` when that is nothing.
InquiryResult inquire(QuestionLine& line, const InquirySettings& settings, const InquiryProgress& progress);

/// The profile whose recognition values all are among the parameters, the one with the most of them; null:
/// none. Pure.
ProfilePointer recognised(const std::vector<ProfilePointer>& profiles,
                          const std::vector<FoundParameter>& parameters);

}  // namespace cansync::cli
