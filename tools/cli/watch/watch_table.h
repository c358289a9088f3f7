#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/base/output.h"
#include "cli/text/table.h"
#include "cli/watch/watch_rows.h"

/// The rows of `watch` as a table and as objects.
namespace cansync::cli {

/// One row for --json; `now`: CLOCK_REALTIME in ns.
JsonObject row_object(const WatchRow& row, std::int64_t now);

/// What the table may show; the last two stand for each of the values and parameters, under its name or
/// number.
std::vector<Table::Column> watch_columns();

/// The table's columns: those values that any of the slaves maps, under their name when all slaves agree on
/// it, then the parameters.
class WatchTable {
 public:
  WatchTable(const std::vector<WatchRow>& rows, bool with_time, bool raw);

  void fill(const std::vector<WatchRow>& rows, std::int64_t now);
  const Table& table() const { return table_; }

 private:
  std::vector<Table::Column> columns(const std::vector<WatchRow>& rows);
  std::vector<std::string> cells(const WatchRow& row, std::int64_t now) const;
  std::string cell(const WatchRow& row, unsigned value) const;

  bool raw_;
  bool with_time_;
  unsigned mapped_ = 0;
  std::size_t parameters_ = 0;
  Table table_;
};

}  // namespace cansync::cli
