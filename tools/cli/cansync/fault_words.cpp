#include "cli/cansync/fault_words.h"

#include <exception>

#include "profile/meaning.h"

namespace cansync::cli {
namespace {

/// Null when there is none that can be read: those that need it say why.
ProfilePointer readable_profile(Session& session, const client::SlaveStatus& slave,
                                const std::string& folder) {
  try {
    return named_profile(session, slave, folder).profile;
  } catch (const std::exception&) {
    return nullptr;
  }
}

}  // namespace

std::string FaultWords::of(const client::SlaveStatus& slave) {
  const std::string_view hash = client::text(slave.profile_hash);
  if (!slave.status_known || slave.status_error != 0 || hash.empty() || slave.slave >= known_.size())
    return "";
  Known& known = known_.at(slave.slave);
  if (known.hash != hash) known = {std::string(hash), readable_profile(session_, slave, session_.profiles())};
  if (known.profile == nullptr) return "";
  const profile::Parameter* parameter = known.profile->find(std::uint32_t{slave.status_parameter});
  return parameter == nullptr ? "" : profile::fault_words(*parameter, slave.status_word);
}

}  // namespace cansync::cli
