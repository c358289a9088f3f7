#include "cli/cansync/parameter/parameter_request.h"

#include <fmt/format.h>

namespace cansync::cli {
namespace {

constexpr std::uint32_t kElementOfValue = 7;

/// Puts the slave in, and what its profile says of the parameter.
KnownRequest for_slave(Session& session, KnownRequest request, unsigned slave,
                       const ParameterOptions& options) {
  client::ParameterRequest& job = request.job;
  job.slave = slave;
  if (job.sub_slave != 0) return request;
  const SlaveProfile found = find_profile(session, job.slave, options.profile);
  const NamedParameter parameter = find_parameter(options.parameter, found);
  job.number = parameter.number;
  request.profile = found.profile;
  request.known = parameter.known;
  request.scaled = (parameter.by_name ? !options.raw : options.scaled) && job.element == kElementOfValue;
  if (request.scaled && request.known == nullptr) {
    throw UsageError(fmt::format("--scaled: slave {}: no profile tells the unit of parameter {}{}{}", slave,
                                 job.number, found.problem.empty() ? "" : ": ", found.problem));
  }
  return request;
}

}  // namespace

void add_parameter_options(CLI::App& verb, ParameterOptions& options) {
  auto* raw =
      verb.add_flag("--raw", options.raw, "with a name: the value as on the bus instead of in its unit");
  verb.add_flag("--scaled", options.scaled, "with a number: the value in the unit of the slave's profile")
      ->excludes(raw);
  verb.add_option("--element", options.element, "element 0..7 of the parameter; 7 = the value (default)")
      ->type_name("E");
  verb.add_option("--sub-slave", options.sub_slave,
                  "participant below the slave, 0..65535; 0 = the slave itself (default)")
      ->type_name("S");
  verb.add_option("--format", options.format, "width of the value; auto = as the slave says (default)")
      ->type_name("word|doubleword|auto");
  add_profile_option(verb, options.profile);
}

bool has_known_value(const KnownRequest& request) {
  return request.known != nullptr && request.job.element == kElementOfValue;
}

client::ParameterFormat parse_format(std::string_view text) {
  if (text == "word") return client::ParameterFormat::word;
  if (text == "doubleword") return client::ParameterFormat::doubleword;
  if (text == "auto") return client::ParameterFormat::as_slave_says;
  throw UsageError(fmt::format("--format: found '{}'; allowed: word, doubleword, auto", text));
}

KnownRequest parse_numbers(Session& session, const ParameterOptions& options) {
  KnownRequest request;
  client::ParameterRequest& job = request.job;
  const bool by_number = looks_like_number(options.parameter);
  if (by_number) job.number = find_parameter(options.parameter, {}).number;
  job.element = static_cast<std::uint32_t>(parse_integer(options.element, "--element", 0, 7));
  job.sub_slave = static_cast<std::uint32_t>(parse_integer(options.sub_slave, "--sub-slave", 0, 65535));
  job.format = parse_format(options.format);
  job.timeout_ms = session.monitoring_ms();
  if (!by_number && job.sub_slave != 0) {
    throw UsageError(
        "PARAMETER: a profile names the parameters of the slave itself; allowed with --sub-slave: 0..4095");
  }
  return request;
}

std::vector<KnownRequest> parse_requests(Session& session, const ParameterOptions& options,
                                         const std::function<void(KnownRequest&)>& check) {
  const KnownRequest common = parse_numbers(session, options);
  std::vector<KnownRequest> requests;
  for (const unsigned slave : session.slaves(options.slave)) {
    requests.push_back(for_slave(session, common, slave, options));
    check(requests.back());
  }
  return requests;
}

}  // namespace cansync::cli
