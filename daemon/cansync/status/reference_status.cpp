#include "daemon/cansync/status/reference_status.h"

#include <algorithm>
#include <iterator>

#include "cansync/dds/convert.h"
#include "cansync/dds/lead_axis_writer.h"

namespace cansyncd {
namespace {

using cansync::ReleaseStatus;

std::string_view name(ReleaseStatus::State state) noexcept {
  switch (state) {
    case ReleaseStatus::State::stopped:
      return "stopped";
    case ReleaseStatus::State::released:
      return "released";
    case ReleaseStatus::State::held:
      return "held";
  }
  return "unknown";
}

std::string_view name(ReleaseStatus::Cause cause) noexcept {
  switch (cause) {
    case ReleaseStatus::Cause::none:
      return "none_given";
    case ReleaseStatus::Cause::used_up:
      return "used_up";
    case ReleaseStatus::Cause::too_old:
      return "too_old";
    case ReleaseStatus::Cause::withdrawn:
      return "withdrawn";
    case ReleaseStatus::Cause::mapping_changed:
      return "mapping_changed";
    case ReleaseStatus::Cause::bus_lost:
      return "bus_lost";
  }
  return "unknown";
}

}  // namespace

std::string_view release_cause(const ReleaseStatus& release, Loss loss) noexcept {
  if (release.state == ReleaseStatus::State::released) return "";
  switch (loss) {
    case Loss::writer_lost:
      return "writer_lost";
    case Loss::given_up:
      return "given_up";
    case Loss::mapping_changed:
      return "mapping_changed";
    case Loss::deadline_missed:
      return "deadline_missed";
    case Loss::too_old:
      return "too_old";
    case Loss::none:
      break;
  }
  return name(release.cause);
}

void fill_references(const std::array<ReleaseStatus, cansync::kChannels>& release,
                     const std::array<bool, cansync::kChannels>& lead_axis,
                     const std::array<ReferenceGiver, cansync::kChannels>& givers,
                     cansync_MasterStatus& sample) {
  namespace dds = cansync::dds;
  for (unsigned i = 0; i < cansync::kChannels; ++i) {
    cansync_ReferenceRelease& out = sample.reference_release[i];
    // Of a program that tried nothing is told: it has no part in such a telegram.
    static const ReferenceGiver axis{std::string(dds::kLeadAxisWriter)};
    const ReferenceGiver& giver = lead_axis[i] ? axis : givers[i];
    dds::copy_text(giver.who, out.writer);
    out.strength = giver.strength;
    std::copy(giver.guid.begin(), giver.guid.end(), std::begin(out.writer_guid));
    dds::copy_text(giver.waiting, out.waiting_writer);
    out.refused = giver.refused + release[i].beyond_limits;
    dds::copy_text(giver.refused_reason, out.refused_reason);
    dds::copy_text(name(release[i].state), out.state);
    dds::copy_text(release_cause(release[i], giver.loss), out.cause);
    out.interval = release[i].given;
    out.updates = release[i].updates;
    out.too_old = release[i].too_old;
  }
}

}  // namespace cansyncd
