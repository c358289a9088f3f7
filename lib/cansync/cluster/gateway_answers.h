#pragma once

#include "cansync/channel/jobs.h"
#include "cansync/slave/slave.h"

/// What a job of the lower bus means to who asked on the upper one. Pure; realtime safe.
namespace cansync {

/// Value, format and error code of a slave go up unchanged. Without an answer of a slave: 0xFFFA when nothing
/// was written, 0xFFFF for a write of which nobody knows whether the slave has taken it.
ParameterAnswer answer_above(bool write, const ParameterResult& result) noexcept;
/// Of a job that the lower master did not take; `queue_full` is busy, so that the asker asks again.
ParameterAnswer answer_above_parameter(Refusal refused) noexcept;

/// A slave's error code goes up unchanged; without its answer 0x0103, which closes the block.
SlaveApplication::BlockAnswer answer_above(const TransferResult& result) noexcept;
/// Of a block that the lower master did not take; `queue_full` is busy. 0x0103 while the slave or its bus is away,
/// 0x0104 for what is not in the table.
SlaveApplication::BlockAnswer answer_above_transfer(Refusal refused) noexcept;

}  // namespace cansync
