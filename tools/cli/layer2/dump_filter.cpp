#include "cli/layer2/dump_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "can/typed/identifier.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

[[noreturn]] void refuse_identifiers(std::string_view text) {
  throw UsageError(fmt::format(
      "--id: found '{}'; allowed: identifiers {}, as 123, 0x123, 100-1FF or 120:7F0 (identifier:mask), with "
      "commas between",
      text, can::kTypedIdentifierForm));
}

}  // namespace

DumpFilter::Identifiers DumpFilter::parse(std::string_view text) {
  const std::size_t cut = text.find_first_of("-:");
  const auto first = can::typed_identifier(text.substr(0, cut));
  if (!first) refuse_identifiers(text);
  const std::uint32_t all = first->extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
  if (cut == std::string_view::npos) return {first->value, first->value, all, first->extended};
  const bool masked = text[cut] == ':';
  const auto second = can::typed_identifier(text.substr(cut + 1), masked);
  if (!second || second->extended != first->extended) refuse_identifiers(text);
  if (masked) {
    const std::uint32_t mask = second->value & all;
    return {first->value & mask, first->value & mask, mask, first->extended};
  }
  if (second->value < first->value) refuse_identifiers(text);
  return {first->value, second->value, all, first->extended};
}

void DumpFilter::add_identifiers(std::string_view list) {
  while (true) {
    const std::size_t comma = list.find(',');
    identifiers_.push_back(parse(list.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    list.remove_prefix(comma + 1);
  }
}

void DumpFilter::set_kind(std::string_view kind) {
  if (kind != "data" && kind != "remote")
    throw UsageError(fmt::format("--kind: found '{}'; allowed: data, remote", kind));
  remote_ = kind == "remote";
}

bool DumpFilter::takes(const can::Frame& frame) const noexcept {
  if (remote_ && frame.remote != *remote_) return false;
  const auto fits = [&frame](const Identifiers& wanted) {
    const std::uint32_t masked = frame.id & wanted.mask;
    return wanted.extended == frame.extended && masked >= wanted.first && masked <= wanted.last;
  };
  return identifiers_.empty() || std::any_of(identifiers_.begin(), identifiers_.end(), fits);
}

}  // namespace cansync::cli
