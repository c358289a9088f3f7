#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/frame.h"
#include "cli/base/output.h"
#include "cli/text/row_writer.h"
#include "cli/trace/trace_writer.h"
#include "dbc/database.h"

/// How `can dump` writes frames. Main thread.
namespace cansync::cli {

/// The range that takes a frame.
struct TakenBy {
  std::uint8_t range = 0;      ///< place in the configuration
  bool high_priority = false;  ///< of that range
};

/// A received frame with what the daemon says of it, or a recorded one.
struct DumpedFrame {
  std::int64_t time = 0;  ///< ns since 1970 (UTC) of its last bit
  can::Frame frame;
  std::string_view interface;       ///< of the recording; of a daemon the name of its bus
  std::optional<TakenBy> taken_by;  ///< nothing: recorded
};

/// The columns of the table.
std::vector<Table::Column> dump_columns();

/// Writes frames in one of the forms: a table, in which bytes that changed are coloured; objects with
/// `--json`; a candump text log; a pcapng capture.
class DumpForm {
 public:
  /// What is wanted. A capture, else a log, else what `output` says.
  struct Choice {
    bool candump = false;
    std::string capture;  ///< file of the capture, "-" for standard output; empty: none
    dbc::Database names;  ///< what frames mean; empty: not told
  };
  /// Opens the capture. Throws as TraceCapture.
  DumpForm(Output& output, Choice choice);

  /// What is written comes out at the next `flush`, or when much of it waits. Throws as `flush`.
  void write(const DumpedFrame& frame);
  /// Throws std::system_error when it cannot be written.
  void flush();

 private:
  /// An identifier with its width and kind.
  using Key = std::uint64_t;
  /// So many identifiers are remembered at most, for the colours.
  static constexpr std::size_t kMostRemembered = 4096;

  /// The most characters that wait for `flush`.
  static constexpr std::size_t kMostWaiting = 65536;

  void write_line(const DumpedFrame& frame);
  /// The bytes, those that differ from the last frame of the same identifier coloured.
  std::string painted_data(const can::Frame& frame);

  Output& output_;
  Choice choice_;
  bool colours_;
  RowWriter table_;
  bool headed_ = false;
  std::unique_ptr<TraceCapture> capture_;
  std::map<Key, can::Frame> last_;
  std::string text_;
};

}  // namespace cansync::cli
