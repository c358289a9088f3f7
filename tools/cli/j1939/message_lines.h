#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/base/output.h"
#include "cli/text/table.h"
#include "dbc/database.h"
#include "j1939.h"

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

/// Writes messages until `count` are there; 0: without end. `names`: what they mean; may be empty.
class MessageLines {
 public:
  MessageLines(Output& output, std::uint64_t count, dbc::Database names = {})
      : output_(output), table_(message_columns()), count_(count), names_(std::move(names)) {}

  void show(const j1939_MessageBatch& batch);
  void show(const j1939_LongMessage& message);
  bool enough() const noexcept { return count_ != 0 && shown_ == count_; }

 private:
  void tell_missed(const j1939_MessageBatch& batch);
  void show(const j1939_ReceivedMessage& message, std::span<const std::uint8_t> data);

  Output& output_;
  Table table_;
  std::uint64_t count_;
  std::uint64_t shown_ = 0;
  std::uint64_t number_ = 0;  ///< of the last batch; 0: none yet
  std::uint64_t lost_ = 0;
  dbc::Database names_;
};

}  // namespace cansync::cli
