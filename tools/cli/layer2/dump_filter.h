#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "can/frame.h"

/// Which frames `can dump` shows. Main thread.
namespace cansync::cli {

/// A set of frames: any when there is nothing in it.
class DumpFilter {
 public:
  /// Adds the identifiers of a list with commas: `123` or `18DAF110` (hexadecimal, three digits for 11 bits,
  /// eight for 29), `100-1FF` (both included), `120:7F0` (those that agree in the bits of the mask). Throws
  /// UsageError.
  void add_identifiers(std::string_view list);
  /// `data` or `remote` alone. Throws UsageError for anything else.
  void set_kind(std::string_view kind);

  bool takes(const can::Frame& frame) const noexcept;

 private:
  /// Identifiers that are in first..last once `mask` is laid on them.
  struct Identifiers {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::uint32_t mask = 0;
    bool extended = false;
  };
  static Identifiers parse(std::string_view text);

  std::vector<Identifiers> identifiers_;
  std::optional<bool> remote_;
};

}  // namespace cansync::cli
