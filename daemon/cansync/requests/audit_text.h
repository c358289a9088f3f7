#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cansync.h"
#include "cansync/settings/settings.h"
#include "cansync/telegram/mapping.h"
#include "daemon/desk/audit.h"

/// What a request of a client would change, in words. Pure functions; not for the realtime thread
/// (allocates).
namespace cansyncd {

/// Nothing for a read, which changes nothing.
std::optional<Change> change_of(const cansync_ParameterRequest& sample);
/// Nothing for an upload. What is downloaded is told by the desk, once the data is there.
std::optional<Change> change_of(const cansync_TransferRequest& sample);
/// Every command is a change.
std::optional<Change> change_of(const cansync_Command& sample);

std::string polling_text(const std::string& one, const std::string& two, const std::string& maximum_slave);
std::string cursors_text(const std::string& control_word, const std::string& parameter,
                         const std::string& transfer);
/// Eight register bytes, hexadecimal.
std::string mapping_text(const std::uint8_t (&bytes)[8]);
std::string mapping_text(const cansync::ProcessMapping& mapping);

}  // namespace cansyncd
