#pragma once

#include <string>
#include <string_view>

#include "config/option.h"

/// Documents of a table of options. Each begins with `head`. Main thread.
namespace config {

/// What the documents of one table begin with.
struct DocumentHeads {
  std::string_view markdown;
  std::string_view file;
  std::string_view man;
};

/// A page in Markdown: a table for each section.
std::string options_markdown(const Table& table, std::string_view head);

/// A part of a manual page in mdoc.
std::string options_man(const Table& table, std::string_view head);

/// A file with every option at its default, each explained in a comment; of numbered sections one with its
/// smallest number. Options without a fixed default are comments with their example.
std::string default_file(const Table& table, std::string_view head);

}  // namespace config
