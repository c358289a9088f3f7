#pragma once

#include <string>
#include <string_view>

/// What a file is that a reader of another format was given. Pure.
namespace text {

/// A format that is recognized, and how the user gets what is wanted instead.
struct ForeignFile {
  std::string_view name;    ///< e.g. "a Git LFS pointer"; empty: not recognized
  std::string_view remedy;  ///< e.g. "run: git lfs pull"; empty: none is known
  /// It may be the wanted file, only stored or written otherwise: the remedy is right for every reader.
  bool same_content = false;
};

/// Recognizes a file by its first bytes: formats of logs, captures and signal files, and what is no text.
/// Any thread; does not allocate.
ForeignFile recognize_file(std::string_view content) noexcept;

/// The content without the mark of UTF-8 that editors of other systems put before it. Any thread; does not allocate.
std::string_view without_mark(std::string_view content) noexcept;

/// "it looks like a Git LFS pointer; run: git lfs pull"; empty: not recognized. Allocates.
std::string recognized_text(std::string_view content);

/// The same for a reader of what people write for this project (TOML, passports), into which no log or signal
/// file can be converted: such a file is named without a remedy. Allocates.
std::string recognized_in_place_of_own(std::string_view content);

}  // namespace text
