// DBC files (lib/dbc), and frames read by those of which something is used.
#include "bounded.h"
#include "bytes.h"
#include "database_check.h"
#include "dbc/reader.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const dbc::File file =
      fuzz::bounded(size, fuzz::kOfText, [&] { return dbc::read_database(fuzz::text_of(data, size)); });
  require(file.remarks.size() <= dbc::kMostRemarks, "remarks are bounded");
  for (const dbc::Remark& remark : file.remarks)
    require(remark.line > 0 && remark.column > 0 && !remark.text.empty(), "a remark has a place and words");
  require(file.refused.empty() != file.database.messages().empty(), "a file without messages is refused");
  fuzz::check_database(file.database);
  return 0;
}
