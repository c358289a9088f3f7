#include "daemon/cansync/texts/profile_rules.h"

#include <fmt/format.h>

#include "profile/scaling.h"

namespace cansyncd {
namespace {

const profile::Parameter* find(const Config& config, std::uint32_t slave, std::uint32_t number) noexcept {
  if (slave >= config.slaves.size() || config.slaves[slave].parameters == nullptr) return nullptr;
  return config.slaves[slave].parameters->find(number);
}

}  // namespace

std::string parameter_label(const Config& config, unsigned slave, std::uint32_t number) {
  const profile::Parameter* parameter = find(config, slave, number);
  return parameter != nullptr ? profile::label(*parameter) : fmt::format("parameter {}", number);
}

std::string parameter_text(const Config& config, const cansync_ParameterRequest& sample) {
  if (sample.sub_slave == 0) return parameter_label(config, sample.slave, sample.number);
  return fmt::format("parameter {} of sub-slave {}", sample.number, sample.sub_slave);
}

gateway::dds::Problem profile_refusal(const Request& request, const Config& config) {
  const auto* job = std::get_if<cansync::ParameterRequest>(&request);
  if (job == nullptr || !job->write || job->sub_slave.value != 0 || !config.access.profile_rules) {
    return std::nullopt;
  }
  const profile::Parameter* parameter = find(config, job->slave.value(), job->number.value());
  if (parameter == nullptr) return std::nullopt;
  const auto refused = profile::write_problem(*parameter, job->value);
  if (!refused) return std::nullopt;
  return gateway::dds::Denial{gateway_CAUSE_PROFILE,
                              refused->text + "; by its drive profile, see access.profile_rules"};
}

}  // namespace cansyncd
