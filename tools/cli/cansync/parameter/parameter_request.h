#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/consent.h"
#include "cli/base/session.h"
#include "cli/cansync/profiles.h"

/// What is typed about a parameter, and the request for each slave that it makes.
namespace cansync::cli {

/// The arguments of `read` and `write` as they were typed.
struct ParameterOptions {
  std::string slave;
  std::string parameter;  ///< write; read: the one that is being looked at
  std::string value;      ///< write
  std::string element = "7";
  std::string sub_slave = "0";
  std::string format = "auto";
  std::string profile;
  bool raw = false;
  bool scaled = false;
  Consent consent;  ///< write
};

/// Adds all of them but slave, parameter and value.
void add_parameter_options(CLI::App& verb, ParameterOptions& options);

/// A request, and what the profile says of its parameter.
struct KnownRequest {
  client::ParameterRequest job;
  ProfilePointer profile;                     ///< keeps `known`
  const profile::Parameter* known = nullptr;  ///< null: nothing is known, or it does not apply
  bool scaled = false;                        ///< values are typed and shown in engineering units
};

/// Is the value that of the parameter, which its profile tells of?
bool has_known_value(const KnownRequest& request);

/// Throws UsageError.
client::ParameterFormat parse_format(std::string_view text);

/// Everything but slave and value. Numbers are checked before the slave's name, so that a wrong one is told
/// without a daemon. Throws UsageError.
KnownRequest parse_numbers(Session& session, const ParameterOptions& options);

/// The request for each slave of the list, all of them checked. `check` completes one. Throws UsageError.
std::vector<KnownRequest> parse_requests(Session& session, const ParameterOptions& options,
                                         const std::function<void(KnownRequest&)>& check);

}  // namespace cansync::cli
