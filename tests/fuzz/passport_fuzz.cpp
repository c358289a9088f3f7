// Drive passports (lib/profile/passport.h): what is read is written and read again as the same.
#include "bounded.h"
#include "bytes.h"
#include "profile/passport.h"
#include "require.h"

namespace {

using fuzz::require;
using profile::Passport;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::text_of(data, size);
  const auto reading = fuzz::bounded(size, fuzz::kOfText, [&] { return profile::parse_passport(text); });
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
  const auto again = profile::parse_passport(profile::passport_text(passport));
  require(again.passport == passport, "a written passport reads as the same");
  require(!again.changed, "its checksum fits");
  return 0;
}
