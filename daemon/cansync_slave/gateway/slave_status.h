#pragma once

#include <string>
#include <string_view>

#include "cansync_slave.h"
#include "cansync_slave/config/config.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/desk/writer_arbiter.h"

namespace cansyncd {

/// The sample of SlaveSideStatus that tells a snapshot. Pure; any thread.
cansync_slave_SlaveSideStatus slave_side_status(const SlaveSnapshot& snapshot,
                                                const SlaveRoleConfig& config) noexcept;

/// Who stands behind the slave, and what it has taken over.
void put_application(const WriterArbiter& arbiter, const TakeOver& taken,
                     cansync_slave_SlaveSideStatus& sample) noexcept;

/// The words of a fault and of what is to be done about it, as SlaveSideStatus has them.
std::string_view word_of(cansync::SlaveFault fault) noexcept;
std::string_view word_of(cansync::SlaveReaction reaction) noexcept;

/// The slave in one sentence, for `systemctl status`: what keeps the bus from being used, else operating state, what is wrong
/// with it, bus and bit rate. Pure; allocates.
std::string slave_sentence(const SlaveSnapshot& snapshot, const SlaveRoleConfig& config);

/// Does `to` differ from `from` in more than counters, so that clients are told at once?
bool differs(const SlaveSnapshot& from, const SlaveSnapshot& to) noexcept;

}  // namespace cansyncd
