#include "cansync_slave/client/release_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "dds/owner_seen.h"
#include "dds/security.h"

namespace cansync_slave::client {

namespace {

gateway::dds::OwnerSeen owner_of(SlaveClient& client, std::uint8_t telegram) {
  const auto& status = client.take_status();
  if (!status || (telegram != 1 && telegram != 2)) return {};
  const cansync_slave_Ownership& owner = status->actual_ownership[telegram - 1u];
  return gateway::dds::owner_seen(owner.writer, owner.strength, owner.writer_guid);
}

}  // namespace

ReleaseWriter::ReleaseWriter(SlaveClient& client, std::int32_t strength)
    : client_(client),
      strength_(gateway::dds::strength_over(strength, {owner_of(client, 1), owner_of(client, 2)})),
      writer_(client.participant(), strength_, nullptr, client.name()) {
  take_up();
}

ReleaseWriter::~ReleaseWriter() {
  for (const std::uint8_t telegram : {std::uint8_t{1}, std::uint8_t{2}}) {
    if (written_[telegram - 1u]) give_up(telegram);
  }
}

std::string ReleaseWriter::write(std::uint8_t telegram, const std::array<std::uint32_t, 4>& raw,
                                 std::uint8_t valid, std::uint32_t wait_intervals) {
  std::string had = gateway::dds::had_by_another(fmt::format("telegram {} of the actual values", telegram),
                                                 owner_of(client_, telegram), writer_, strength_);
  waits_ = !had.empty();
  if (waits_) return had;
  cansync_slave_ActualRelease sample = {};
  sample.telegram = telegram;
  gateway::dds::set_writer(writer_, sample);
  std::copy(raw.begin(), raw.end(), std::begin(sample.raw));
  sample.valid = valid;
  sample.wait_intervals = wait_intervals;
  gateway::dds::set_daemon(daemon_, sample);
  const auto code = writer_.write(sample);
  if (code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY)
    return gateway::dds::no_right(gateway::dds::topic_info<cansync_slave_ActualRelease>.name, "operator");
  if (code != DDS_RETCODE_OK) return fmt::format("the values could not be written: {}", dds_strretcode(code));
  if (telegram == 1 || telegram == 2) written_[telegram - 1u] = true;
  return {};
}

void ReleaseWriter::give_up(std::uint8_t telegram) {
  if (telegram != 1 && telegram != 2) return;
  cansync_slave_ActualRelease sample = {};
  sample.telegram = telegram;
  gateway::dds::set_writer(writer_, sample);
  sample.given_up = true;
  gateway::dds::set_daemon(daemon_, sample);
  (void)writer_.write(sample);
  (void)writer_.unregister(sample);
  written_[telegram - 1u] = false;
}

bool ReleaseWriter::daemon_restarted() const noexcept {
  return gateway::dds::daemon_of(client_.gateway_status()) != daemon_;
}

void ReleaseWriter::take_up() noexcept {
  daemon_ = gateway::dds::daemon_of(client_.gateway_status());
}

}  // namespace cansync_slave::client
