#pragma once

#include <string>
#include <string_view>

namespace rt {

/// How a kernel preempts itself, out of its version text (`uname -v`): "PREEMPT_RT", "PREEMPT_DYNAMIC",
/// "PREEMPT", or "no preemption". Pure.
std::string_view preemption_of(std::string_view version) noexcept;

/// The running kernel for people, e.g. "6.1.0-37-amd64 (PREEMPT_DYNAMIC)". Asks the system; allocates.
std::string kernel_type();

}  // namespace rt
