#include <cansync/function_blocks/pd_comm_read_sl.h>
#include <cansync/function_blocks/pd_comm_sl.h>

#include <algorithm>
#include <utility>

#include "cansync_slave/client/release_writer.h"
#include "client/src/cansync_slave/slave_side.h"
#include "client/src/set_up.h"

namespace cansync::client::function_blocks {
namespace {

constexpr SINT kReleased = 5;  // M 4.22

using Telegrams = detail::SlaveSide::Telegrams;

/// Takes the values of the telegrams that came since the last look. Bit 0/1: telegram 1/2 did.
template <std::size_t N>
unsigned take_fresh(const Telegrams& from, std::array<std::uint64_t, 2>& seen, std::array<DINT, N>& values) {
  unsigned came = 0;
  for (unsigned telegram = 0; telegram < 2; ++telegram) {
    if (std::exchange(seen[telegram], from.count[telegram]) == from.count[telegram]) continue;
    came |= 1u << telegram;
    for (unsigned i = 4 * telegram; i < 4 * telegram + 4; ++i) values[i] = from.values[i];
  }
  return came;
}

/// What has come so far does not count.
template <class Seen>
void pass_over(detail::SlaveSide& side, Seen& seen) {
  side.look();
  for (std::size_t slave = 0; slave < seen.size(); ++slave) seen[slave] = side.monitored(slave).count;
}

}  // namespace

/// The writer of the actual values, with the lock after a restart of the daemon.
class PD_COMM_SL::Releases {
 public:
  Releases(detail::SlaveSide& side, std::int32_t strength)
      : writer(detail::set_up([&] {
          return std::make_unique<cansync_slave::client::ReleaseWriter>(side.client(), strength);
        })) {}
  std::unique_ptr<cansync_slave::client::ReleaseWriter> writer;
};

PD_COMM_SL::PD_COMM_SL(SlaveConnection& connection, std::int32_t strength)
    : connection_(&connection), releases_(std::make_unique<Releases>(connection.side(), strength)) {
  pass_over(connection.side(), actuals_seen_);
  references_seen_ = connection.side().references().count;
  for (unsigned telegram = 0; telegram < 2; ++telegram)
    heard_[telegram] = connection.side().heard(telegram).count;
}

PD_COMM_SL::~PD_COMM_SL() = default;

void PD_COMM_SL::call() {
  connection_->side().look();
  receive();
  error_.clear();
  if (!may_release()) return;
  release(si_RDC1_SEND, 1);
  release(si_RDC2_SEND, 2);
}

void PD_COMM_SL::receive() {
  const detail::SlaveSide& side = connection_->side();
  const unsigned came = take_fresh(side.references(), references_seen_, a_WR_VALUES_RECEIVED);
  si_WRC1_RECEIVED = (came & 1u) != 0 ? SINT{1} : SINT{0};
  si_WRC2_RECEIVED = (came & 2u) != 0 ? SINT{2} : SINT{0};
  const auto newest = [&](unsigned telegram) {
    const detail::SlaveSide::Heard& heard = side.heard(telegram);
    const bool none = std::exchange(heard_[telegram], heard.count) == heard.count;
    return none ? kAutomaticNumber : static_cast<SINT>(heard.slave);
  };
  si_RD_SL_NR1_RECEIVED = newest(0);
  si_RD_SL_NR2_RECEIVED = newest(1);
  for (std::size_t slave = 0; slave < a_RD_ARRAY.size(); ++slave) {
    DINT_16_BMARRAY passed_over = {};
    (void)take_fresh(side.monitored(slave), actuals_seen_[slave],
                     x_COPY_TO_RD_ARRAY ? a_RD_ARRAY[slave] : passed_over);
  }
}

/// False: nothing may be released in this call; `error_` says why when it is wanted.
bool PD_COMM_SL::may_release() {
  const bool wanted = si_RDC1_SEND == kReleased || si_RDC2_SEND == kReleased;
  if (!connection_->side().daemon_present()) {
    if (wanted) error_ = "client: no daemon serves the bus";
    return false;
  }
  if (!releases_->writer->daemon_restarted()) return wanted;
  if (!wanted) {
    releases_->writer->take_up();
    return false;
  }
  error_ =
      "client: the daemon was started anew: nothing is released until si_RDC1_SEND and si_RDC2_SEND had "
      "another value than 5 in a call";
  return false;
}

void PD_COMM_SL::release(SINT command, std::uint8_t telegram) {
  if (command != kReleased) return;
  std::array<std::uint32_t, 4> raw = {};
  for (std::size_t i = 0; i < raw.size(); ++i)
    raw[i] = static_cast<std::uint32_t>(a_RD_VALUES_SEND[4 * (telegram - std::size_t{1}) + i]);
  constexpr std::uint8_t kAll = 0b1111;
  if (std::string failed = releases_->writer->write(telegram, raw, kAll, u_WAIT_INTERVALS); !failed.empty())
    error_ = "client: " + failed;
}

PD_COMM_READ_SL::PD_COMM_READ_SL(SlaveConnection& connection) : connection_(&connection) {
  pass_over(connection.side(), seen_);
}

void PD_COMM_READ_SL::call() {
  connection_->side().look();
  si_RD_SL_NR1_RECEIVED = si_RD_SL_NR2_RECEIVED = 0;
  if (si_SL_NR < 0 || static_cast<std::size_t>(number(si_SL_NR)) >= seen_.size()) return;
  const auto slave = static_cast<std::size_t>(number(si_SL_NR));
  const unsigned came = take_fresh(connection_->side().monitored(slave), seen_[slave], a_RD_VALUES);
  if ((came & 1u) != 0) si_RD_SL_NR1_RECEIVED = 1;
  if ((came & 2u) != 0) si_RD_SL_NR2_RECEIVED = 2;
}

}  // namespace cansync::client::function_blocks
