#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cansync.h"
#include "cansync/mapping.h"
#include "cansync/settings.h"

/// What a request of a client would change, in words. Pure functions; not for the realtime thread
/// (allocates).
namespace cansyncd {

/// A change that a client asked for. Its fields may be out of range: refused requests are recorded too.
struct Change {
  std::string_view action;  ///< stable word; a literal
  int slave = -1;           ///< 0..31 and whatever a client gave; -1: none
  std::string what;         ///< which parameter, address or slaves; may be empty
  std::string new_value;    ///< what was asked for
  int parameter = -1;       ///< number, whatever a client gave; -1: none
};

/// Nothing for a read, which changes nothing.
std::optional<Change> change_of(const cansync_ParameterRequest& sample);
/// Nothing for an upload. What is downloaded is in `data_text`, once the data is there.
std::optional<Change> change_of(const cansync_TransferRequest& sample);
/// Every command is a change.
std::optional<Change> change_of(const cansync_Command& sample);

/// "12 bytes, SHA-256 0123…": which data was downloaded.
std::string data_text(const std::uint8_t* data, std::size_t size);

std::string polling_text(const std::string& one, const std::string& two, const std::string& maximum_slave);
std::string cursors_text(const std::string& control_word, const std::string& parameter,
                         const std::string& transfer);
/// Eight register bytes, hexadecimal.
std::string mapping_text(const std::uint8_t (&bytes)[8]);
std::string mapping_text(const cansync::ProcessMapping& mapping);

}  // namespace cansyncd
