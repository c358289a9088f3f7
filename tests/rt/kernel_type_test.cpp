#include "rt/kernel_type.h"

#include <gtest/gtest.h>

namespace {

TEST(KernelType, TellsHowAKernelPreemptsItself) {
  EXPECT_EQ(rt::preemption_of("#1 SMP PREEMPT_RT Debian 6.1.140-1 (2025-05-22)"), "PREEMPT_RT");
  EXPECT_EQ(rt::preemption_of("#1 SMP PREEMPT_DYNAMIC Debian 6.1.140-1 (2025-05-22)"), "PREEMPT_DYNAMIC");
  EXPECT_EQ(rt::preemption_of("#41 SMP PREEMPT Tue Jan 1"), "PREEMPT");
  EXPECT_EQ(rt::preemption_of("#1 SMP Debian 4.19"), "no preemption");
  EXPECT_NE(rt::kernel_type().find(" ("), std::string::npos);
}

}  // namespace
