#pragma once

#include <cstdint>
#include <string>

#include "profile/profile.h"

/// What bits and numbers of a parameter mean, in words. Pure functions; any thread; they allocate.
namespace profile {

/// "ready, powered" for the bits that are set, or the words of the number; empty: the profile says nothing.
std::string words(const Parameter& parameter, std::uint32_t raw);

/// The same of what the profile marks as a fault; empty: no fault is known.
std::string fault_words(const Parameter& parameter, std::uint32_t raw);

}  // namespace profile
