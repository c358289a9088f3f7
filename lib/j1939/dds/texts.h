#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "j1939/address_claim.h"
#include "j1939/order.h"
#include "j1939/transport.h"

/// Words for people. Any thread.
namespace j1939::dds {

/// "listening", "claiming", "claimed", "cannot-claim".
std::string_view name_of(ClaimState state) noexcept;
/// A short word of an outcome, as the audit trail has it.
std::string_view name_of(Outcome outcome) noexcept;
/// What an answer means and what helps; empty when done. Allocates.
std::string reason_of(const Answer& answer);
/// What a failure mode identifier means (SAE J1939-73), 0..31.
std::string_view failure_mode(std::uint8_t fmi) noexcept;

}  // namespace j1939::dds
