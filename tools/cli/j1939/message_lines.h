#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/base/output.h"
#include "cli/text/row_writer.h"
#include "dbc/database.h"
#include "j1939.h"
#include "j1939/client/groups.h"
#include "j1939/message.h"

/// Messages of J1939 for people and programs.
namespace cansync::cli {

/// "0FEF1": five hexadecimal digits.
std::string pgn_text(std::uint32_t pgn);
/// A group of one to five hexadecimal digits with 0x, or five without. Throws UsageError.
std::uint32_t parse_pgn(std::string_view text);
/// An address 0..253, or 255 or "all". Throws UsageError.
std::uint8_t parse_address(std::string_view text, std::string_view what);
/// "01 02 FF".
std::string bytes_text(std::span<const std::uint8_t> bytes);
/// Up to 1785 bytes of two hexadecimal digits, blanks or dots between them. Throws UsageError.
std::vector<std::uint8_t> parse_bytes(std::string_view text);
JsonArray bytes_json(std::span<const std::uint8_t> bytes);

/// Of the table of messages.
std::vector<Table::Column> message_columns();

/// A message that a daemon received, or of a recording.
struct ShownMessage {
  std::int64_t time = 0;       ///< ns since 1970 (UTC) of the last bit of its last frame
  std::string_view interface;  ///< of the recording; of a daemon the name of its bus
  std::uint32_t pgn = 0;
  std::uint8_t priority = 0;
  std::uint8_t source = 0;
  std::uint8_t destination = 0;
  j1939::Transport transport = j1939::Transport::frame;
  std::optional<std::uint8_t>
      range;  ///< place in the configuration of the range that takes it; nothing: recorded
  std::span<const std::uint8_t> data;
};

/// Writes messages until `count` are there; 0: without end. `bus`: the name of the daemon's. `names`: what they
/// mean; may be empty.
class MessageLines {
 public:
  MessageLines(Output& output, std::uint64_t count, std::string bus, dbc::Database names = {})
      : output_(output),
        table_(message_columns()),
        count_(count),
        bus_(std::move(bus)),
        names_(std::move(names)) {}

  void show(const j1939_MessageBatch& batch);
  void show(const j1939_LongMessage& message);
  /// What is written comes out at the next `flush`, or when much of it waits. Throws as `flush`.
  void show(const ShownMessage& message);
  /// Throws std::system_error when it cannot be written.
  void flush();
  bool enough() const noexcept { return count_ != 0 && shown_ == count_; }
  std::uint64_t shown() const noexcept { return shown_; }

 private:
  /// The most characters that wait for `flush`.
  static constexpr std::size_t kMostWaiting = 65536;

  void tell_missed(const j1939_MessageBatch& batch);

  Output& output_;
  RowWriter table_;
  std::uint64_t count_;
  std::uint64_t shown_ = 0;
  std::uint64_t number_ = 0;  ///< of the last batch; 0: none yet
  std::uint64_t lost_ = 0;
  std::string bus_;
  j1939::client::Groups names_;
  std::string text_;
};

}  // namespace cansync::cli
