#include "cansync_slave/client/application.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "dds/daemon_identity.h"
#include "dds/owner_seen.h"
#include "dds/security.h"

namespace cansync_slave::client {
namespace {

using std::chrono::steady_clock;

/// A quarter of what the daemon waits.
constexpr std::chrono::milliseconds kPresencePeriod{500};

std::string no_right() {
  return gateway::dds::no_right(gateway::dds::topic_info<cansync_slave_ApplicationAnswer>.name, "engineer");
}

template <class Job>
cansync_slave_ApplicationAnswer answer_to(const Job& job, cansync_slave_AnswerKind kind) noexcept {
  cansync_slave_ApplicationAnswer sample = {};
  sample.kind = kind;
  sample.job = job.job;
  gateway::dds::set_daemon(gateway::dds::daemon_of(job), sample);
  return sample;
}

gateway::dds::OwnerSeen owner_of(SlaveClient& client) {
  const auto& status = client.take_status();
  if (!status) return {};
  return gateway::dds::owner_seen(status->application, status->application_strength,
                                  status->application_writer);
}

}  // namespace

Application::Application(SlaveClient& client, Duties duties, std::int32_t strength)
    : client_(client),
      duties_(std::move(duties)),
      strength_(gateway::dds::strength_over(strength, {owner_of(client)})),
      writer_(client.participant(), strength_, nullptr, client.name()),
      guid_(gateway::dds::guid_of(writer_.handle())) {
  (void)keep();
}

Application::~Application() {
  Sample sample = {};
  gateway::dds::set_writer(writer_, sample);
  sample.kind = cansync_slave_ANSWER_GIVEN_UP;
  (void)writer_.write(sample);
  (void)writer_.unregister(sample);
}

bool Application::is_application(const cansync_slave_SlaveSideStatus& status) const noexcept {
  return std::equal(guid_.begin(), guid_.end(), std::begin(status.application_writer));
}

std::string Application::take_over(Duties duties) {
  duties_ = std::move(duties);
  said_.reset();
  return keep();
}

std::string Application::keep() {
  if (!writer_.permitted()) return no_right();
  const auto now = steady_clock::now();
  const std::uint32_t daemons = writer_.matched();
  if (!gateway::dds::had_by_another("the place of the application", owner_of(client_), writer_, strength_)
           .empty()) {
    said_.reset();
    return {};
  }
  if (daemons == 0 || (daemons == daemons_ && said_ && now - *said_ < kPresencePeriod)) return {};
  if (!client_.receives_jobs()) return {};
  daemons_ = daemons;
  said_ = now;
  Sample sample = {};
  sample.kind = cansync_slave_ANSWER_PRESENT;
  sample.parameters._buffer = duties_.parameters.data();
  sample.parameters._length = static_cast<std::uint32_t>(duties_.parameters.size());
  sample.parameters._maximum = sample.parameters._length;
  sample.sub_slaves = duties_.sub_slaves;
  sample.blocks = duties_.blocks;
  return write(sample);
}

std::string Application::write(Sample& sample, std::span<const std::uint8_t> data) {
  gateway::dds::set_writer(writer_, sample);
  std::vector<std::uint8_t> bytes(data.begin(), data.end());  // DDS wants to own what it may not change
  sample.data._buffer = bytes.data();
  sample.data._length = static_cast<std::uint32_t>(bytes.size());
  sample.data._maximum = sample.data._length;
  const auto code = writer_.write(sample);
  if (code == DDS_RETCODE_OK) return {};
  if (code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) return no_right();
  return fmt::format("what the application says could not be written: {}", dds_strretcode(code));
}

std::string Application::answer(const cansync_slave_ParameterJob& job, std::uint32_t value, bool doubleword) {
  Sample sample = answer_to(job, cansync_slave_ANSWER_PARAMETER);
  sample.value = value;
  sample.doubleword = doubleword;
  return write(sample);
}

std::string Application::refuse(const cansync_slave_ParameterJob& job, std::uint16_t error) {
  Sample sample = answer_to(job, cansync_slave_ANSWER_PARAMETER);
  sample.error = error;
  return write(sample);
}

std::string Application::allow(const cansync_slave_BlockJob& job, std::span<const std::uint8_t> upload,
                               std::uint16_t length) {
  Sample sample = answer_to(job, cansync_slave_ANSWER_BLOCK_ALLOWED);
  sample.length = length;
  return write(sample, upload);
}

std::string Application::take(const cansync_slave_BlockJob& job) {
  Sample sample = answer_to(job, cansync_slave_ANSWER_BLOCK_TAKEN);
  return write(sample);
}

std::string Application::step(const cansync_slave_BlockJob& job, std::span<const std::uint8_t> upload) {
  Sample sample = answer_to(job, cansync_slave_ANSWER_BLOCK_STEP);
  return write(sample, upload);
}

std::string Application::refuse(const cansync_slave_BlockJob& job, std::uint16_t error) {
  Sample sample = answer_to(job, cansync_slave_ANSWER_BLOCK_REFUSED);
  sample.error = error;
  return write(sample);
}

}  // namespace cansync_slave::client
