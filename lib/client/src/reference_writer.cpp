#include <cansync/client.h>
#include <cansync/topics.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "cansync/dds/topics.h"
#include "client/src/link.h"
#include "client/src/set_up.h"
#include "dds/owner_seen.h"

namespace cansync::client {
namespace {

constexpr unsigned kTelegrams = 2;

std::string_view why(ReferenceStanding standing) {
  switch (standing) {
    case ReferenceStanding::daemon_restarted:
      return "the daemon was started anew, and settings that clients had made are lost";
    case ReferenceStanding::mapping_changed:
      return "the mapping of the reference values was changed";
    case ReferenceStanding::current:
      break;
  }
  return "";
}

}  // namespace

struct ReferenceWriter::Impl {
  Impl(std::shared_ptr<detail::Link> to, std::int32_t wanted)
      : link(std::move(to)),
        strength(link->with_owners([&](const dds::OwnerSeen& one, const dds::OwnerSeen& two) {
          return dds::strength_over(wanted, {one, two});
        })),
        writer(link->participant(), strength, &matched, link->name()) {}
  ~Impl() {
    for (std::uint8_t telegram = 1; telegram <= kTelegrams; ++telegram) give_up(telegram);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// What is over stays so until the telegrams are taken up: of two daemons now this, now that one is heard.
  ReferenceStanding standing() {
    const Validity now = link->validity();
    if (over == ReferenceStanding::current && now != meant_for) over = ReferenceStanding::mapping_changed;
    if (now.daemon != meant_for.daemon) over = ReferenceStanding::daemon_restarted;
    return over;
  }

  void take_up(const Validity& meant) {
    meant_for = meant;
    over = ReferenceStanding::current;
  }

  cansync_ReferenceValues sample_of(std::uint8_t telegram) const {
    cansync_ReferenceValues sample = {};
    sample.telegram = telegram;
    dds::set_writer(writer, sample);
    std::copy(meant_for.daemon.begin(), meant_for.daemon.end(), std::begin(sample.daemon));
    sample.mapping_number = meant_for.mapping_number;
    return sample;
  }

  /// Why nothing may be written, because another writer has the telegram; else empty.
  std::string had_by_another(std::uint8_t telegram) const {
    if (telegram < 1 || telegram > kTelegrams) return {};
    return link->with_owners([&](const dds::OwnerSeen& one, const dds::OwnerSeen& two) {
      return dds::had_by_another(fmt::format("telegram {} of the reference values", telegram),
                                 telegram == 1 ? one : two, writer, strength);
    });
  }

  /// Unregistering alone is a loss to the daemon: a last sample says before that it is meant.
  void give_up(std::uint8_t telegram) {
    if (!std::exchange(given[telegram - 1u], false)) return;
    cansync_ReferenceValues sample = sample_of(telegram);
    sample.given_up = true;
    constexpr int kTries = 3;  // each may wait for 100 ms
    for (int i = 0; i < kTries && writer.matched() != 0 && writer.write(sample) == DDS_RETCODE_TIMEOUT; ++i) {
    }
    (void)writer.unregister(sample);
  }

  std::shared_ptr<detail::Link> link;  // keeps the participant
  dds::DataSignal matched;
  const std::int32_t strength;
  dds::Writer<cansync_ReferenceValues> writer;
  Validity meant_for;
  ReferenceStanding over = ReferenceStanding::current;
  bool waits = false;                       ///< the last write was for a telegram that another writer has
  std::array<bool, kTelegrams> given = {};  ///< telegrams that were written
};

ReferenceWriter::ReferenceWriter(Client& client, std::int32_t strength)
    : impl_(detail::set_up([&] { return std::make_unique<Impl>(client.link_, strength); })) {
  if (!impl_->writer.permitted())
    throw SetupError(impl_->link->not_permitted(dds::topic_info<cansync_ReferenceValues>.name));
  constexpr std::chrono::seconds kWait(2);
  const auto end = std::chrono::steady_clock::now() + kWait;
  while (impl_->writer.matched() == 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0 || !impl_->link->go_on()) {
      throw NoDaemon(
          fmt::format("no daemon takes reference values: looked for {} s on {}; is cansyncd running?",
                      kWait.count(), impl_->link->participant().place()));
    }
    (void)impl_->matched.wait(static_cast<int>(std::min(left, detail::Link::kAsk).count()));
    impl_->matched.clear();
  }
  impl_->take_up(impl_->link->validity());
}

ReferenceWriter::~ReferenceWriter() = default;
ReferenceWriter::ReferenceWriter(ReferenceWriter&&) noexcept = default;
ReferenceWriter& ReferenceWriter::operator=(ReferenceWriter&&) noexcept = default;

std::string ReferenceWriter::write(std::uint8_t telegram, const std::array<std::int32_t, 4>& value,
                                   std::uint8_t valid, std::uint32_t release_intervals,
                                   std::uint64_t from_interval) {
  impl_->waits = false;
  if (const ReferenceStanding now = impl_->standing(); now != ReferenceStanding::current) {
    // Kept, the telegrams would keep others waiting.
    for (std::uint8_t each = 1; each <= kTelegrams; ++each) impl_->give_up(each);
    return fmt::format("{}: nothing is given until the program takes its telegrams up again (take_up)",
                       why(now));
  }
  if (std::string several = impl_->link->several_daemons(); !several.empty()) return several;
  if (impl_->writer.matched() == 0) {
    return fmt::format("no daemon takes reference values ({}); is cansyncd running?",
                       impl_->link->participant().place());
  }
  if (std::string had = impl_->had_by_another(telegram); !had.empty()) {
    impl_->waits = true;
    return had;
  }
  cansync_ReferenceValues sample = impl_->sample_of(telegram);
  std::copy(value.begin(), value.end(), std::begin(sample.value));
  sample.valid = valid;
  sample.from_interval = from_interval;
  sample.release_intervals = release_intervals;
  if (telegram >= 1 && telegram <= kTelegrams) impl_->given[telegram - 1u] = true;
  const dds_return_t code = impl_->writer.write(sample);
  if (code == DDS_RETCODE_OK) return "";
  return fmt::format("the reference values could not be written: {}; try again", dds_strretcode(code));
}

void ReferenceWriter::release(std::uint8_t telegram) {
  if (telegram >= 1 && telegram <= kTelegrams) impl_->give_up(telegram);
}

bool ReferenceWriter::waits() const {
  return impl_->waits;
}

std::int32_t ReferenceWriter::strength() const {
  return impl_->strength;
}

ReferenceStanding ReferenceWriter::standing() const {
  return impl_->standing();
}

void ReferenceWriter::take_up() {
  take_up(impl_->link->validity());
}

void ReferenceWriter::take_up(const Validity& meant_for) {
  impl_->take_up(meant_for);
  // Who takes up knows of the start.
  impl_->link->program_told_of(meant_for.daemon);
}

}  // namespace cansync::client
