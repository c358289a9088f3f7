// Drive passports (tools/cli/cansync/passport.h): what is read is written and read again as the same.
#include "bytes.h"
#include "cli/cansync/passport.h"
#include "require.h"

namespace {

using cansync::cli::Passport;
using fuzz::require;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::text_of(data, size);
  const auto reading = cansync::cli::parse_passport(text);
  require(reading.passport.has_value() == reading.problem.empty(), "a passport, or why it is none");
  if (!reading.passport) return 0;
  const Passport& passport = *reading.passport;
  require(passport.slave <= 31, "its slave is one of a line");
  int before = -1;
  for (const auto& entry : passport.entries) {
    require(entry.number > before && entry.number <= 4095, "numbers rise and fit a telegram");
    require(passport.find(entry.number) == &entry, "it is found by its number");
    before = entry.number;
  }
  const auto again = cansync::cli::parse_passport(cansync::cli::passport_text(passport));
  require(again.passport == passport, "a written passport reads as the same");
  require(!again.changed, "its checksum fits");
  return 0;
}
