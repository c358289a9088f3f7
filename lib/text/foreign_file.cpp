#include "text/foreign_file.h"

#include <algorithm>
#include <array>

namespace text {
namespace {

constexpr std::string_view kConvertLog =
    "convert it: can_logconvert FILE OUT.log (package python3-can), and read OUT.log";
constexpr std::string_view kConvertAsc =
    "convert it: asc2log -I FILE -O OUT.log (package can-utils), and read OUT.log";
constexpr std::string_view kConvertMatrix = "export it as a DBC file";
constexpr std::string_view kUnpack = "unpack it first";

/// Bytes that a format's files begin with.
struct Beginning {
  std::string_view bytes;
  ForeignFile file;
};

using namespace std::string_view_literals;
constexpr auto kBeginnings = std::to_array<Beginning>({
    {"version https://git-lfs"sv, {"a Git LFS pointer", "fetch the file itself: git lfs pull", true}},
    {"\xFF\xFE"sv, {"text in UTF-16", "save it as UTF-8", true}},
    {"\xFE\xFF"sv, {"text in UTF-16", "save it as UTF-8", true}},
    {"LOGG"sv, {"a Vector BLF log", kConvertLog}},
    {";$FILEVERSION"sv, {"a PEAK TRC log", kConvertLog}},
    {";####"sv, {"a PEAK TRC log", kConvertLog}},
    {"***BUSMASTER"sv, {"a BUSMASTER log", {}}},
    {"date "sv, {"a Vector ASC log", kConvertAsc}},
    {"Time Stamp,ID,Extended"sv, {"a SavvyCAN CSV log", kConvertLog}},
    {"timestamp,arbitration_id"sv, {"a python-can CSV log", kConvertLog}},
    {"\xD4\xC3\xB2\xA1"sv, {"a libpcap capture", "convert it: editcap -F pcapng FILE OUT.pcapng"}},
    {"\xA1\xB2\xC3\xD4"sv, {"a libpcap capture", "convert it: editcap -F pcapng FILE OUT.pcapng"}},
    {"\x4D\x3C\xB2\xA1"sv, {"a libpcap capture", "convert it: editcap -F pcapng FILE OUT.pcapng"}},
    {"\xA1\xB2\x3C\x4D"sv, {"a libpcap capture", "convert it: editcap -F pcapng FILE OUT.pcapng"}},
    {"\x0A\x0D\x0D\x0A"sv, {"a pcapng capture", "give it where a log is wanted"}},
    {"\x1F\x8B"sv, {"a gzip archive", kUnpack, true}},
    {"PK\x03\x04"sv, {"a ZIP archive or a spreadsheet", kUnpack, true}},
    {"\x7F"
     "ELF"sv,
     {"a program", {}}},
    {"MDF  "sv, {"an ASAM MDF log", kConvertLog}},
    {"SQLite format 3"sv, {"a SQLite database", kConvertLog}},
    {"%PDF"sv, {"a PDF document", {}}},
});

constexpr std::size_t kMostLooked = 4096;

std::string_view without_blanks(std::string_view text) noexcept {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin == text.npos ? std::string_view() : text.substr(begin);
}

ForeignFile recognize_markup(std::string_view text) noexcept {
  if (text.starts_with('<')) {
    if (text.find("<NetworkDefinition") != text.npos) return {"a KCD file (XML)", kConvertMatrix};
    if (text.find("AUTOSAR") != text.npos) return {"an ARXML file", kConvertMatrix};
    return {"XML or HTML", kConvertMatrix};
  }
  if (text.starts_with('{') || text.starts_with("[{") || text.starts_with("[\n"))
    return {"JSON", kConvertMatrix};
  if (text.starts_with("FormatVersion=")) return {"a PCAN symbol file", kConvertMatrix};
  if (text.starts_with("base hex") || text.starts_with("base dec")) return {"a Vector ASC log", kConvertAsc};
  return {};
}

std::string in_words(const ForeignFile& file) {
  if (file.name.empty()) return {};
  std::string text = "it looks like " + std::string(file.name);
  if (!file.remedy.empty()) text += "; " + std::string(file.remedy);
  return text;
}

}  // namespace

std::string_view without_mark(std::string_view content) noexcept {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return content.starts_with(kMark) ? content.substr(kMark.size()) : content;
}

ForeignFile recognize_file(std::string_view content) noexcept {
  const auto found = std::find_if(kBeginnings.begin(), kBeginnings.end(),
                                  [content](const Beginning& one) { return content.starts_with(one.bytes); });
  if (found != kBeginnings.end()) return found->file;
  std::string_view beginning = content.substr(0, kMostLooked);
  beginning = without_blanks(without_mark(beginning));
  if (const ForeignFile markup = recognize_markup(beginning); !markup.name.empty()) return markup;
  if (beginning.find('\0') != beginning.npos) return {"no text", {}};
  return {};
}

std::string recognized_text(std::string_view content) {
  return in_words(recognize_file(content));
}

std::string recognized_in_place_of_own(std::string_view content) {
  ForeignFile file = recognize_file(content);
  if (!file.same_content) file.remedy = {};
  return in_words(file);
}

}  // namespace text
