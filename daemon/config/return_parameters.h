#pragma once

#include <optional>

#include "cansync/settings.h"
#include "daemon/config/value.h"

namespace cansyncd {

/// A return parameter from "NUMBER=VALUE", both decimal or 0x..: number 0..4095, value 0..4294967295. Nothing
/// for anything else.
std::optional<cansync::ReturnParameter> to_return_parameter(const Scalar& item);

/// Is this a list of at most 32 of them, each number once?
bool takes_return_parameters(const Value& value);

}  // namespace cansyncd
