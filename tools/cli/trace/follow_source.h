#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "cli/base/exit_codes.h"
#include "cli/base/output.h"
#include "cli/trace/trace_source.h"

/// Reading a log, a capture or an interface to its end. Main thread.
namespace cansync::cli {

/// What is done with the frames of a source.
struct SourceUse {
  std::function<void(const can::CandumpLine&)> frame;
  std::function<void()> flush;   ///< called after at most some 100 ms, and at the end: writes what is waiting
  std::function<bool()> enough;  ///< no more frames are wanted
};

/// Gives every frame of the source to `use` until its end, `enough` or Ctrl-C. What is not understood is shown as
/// remarks: the first ten, then the count, with --json all; progress of a long file on standard error when that
/// is a terminal and data go elsewhere. Returns `done`; `in_part` when something was left out; `failed` when
/// there was no frame besides. Throws as TraceSource.
ExitCode follow_source(TraceSource& source, Output& output, const SourceUse& use);

/// The CAN interfaces of a recording.
class RecordedInterfaces {
 public:
  /// More are not told apart: their frames are left out.
  static constexpr std::size_t kMost = 256;

  /// `only`: the one interface whose frames are wanted; empty: all.
  explicit RecordedInterfaces(std::string only) : only_(std::move(only)) {}

  /// The number of this interface; nothing: its frames are not wanted, or left out.
  std::optional<std::uint32_t> take(const std::string& name);
  /// At the end: says so when there were several, when the wanted one was not there, and what was left out.
  /// Returns `in_part` when something was.
  ExitCode end(Output& output) const;

 private:
  std::string only_;
  std::map<std::string, std::uint32_t, std::less<>> numbers_;
  std::string last_;  ///< whose number is `last_number_`
  std::optional<std::uint32_t> last_number_;
  std::uint64_t left_out_ = 0;
};

}  // namespace cansync::cli
