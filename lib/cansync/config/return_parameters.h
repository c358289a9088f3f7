#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "cansync/config/draft.h"
#include "cansync/settings/settings.h"

namespace cansyncd {

/// A number 0..4294967295, decimal or 0x..; nothing for anything else.
std::optional<std::uint32_t> to_raw_number(std::string_view text);

/// A return parameter from "NUMBER=VALUE", both decimal or 0x..: number 0..4095, value 0..4294967295. Nothing
/// for anything else.
std::optional<cansync::ParameterValue> to_return_parameter(const Scalar& item);

/// Is this a list of at most 32 of them, each number once?
bool takes_return_parameters(const Draft& draft, const Value& value);

inline constexpr std::string_view kReturnParametersWords =
    "a list of at most 32 strings \"NUMBER=VALUE\", numbers 0..4095 each once, values 0..4294967295";
static_assert(cansync::kListedParameters == 32, "the words name it");

}  // namespace cansyncd
