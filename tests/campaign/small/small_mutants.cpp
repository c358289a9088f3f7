#include <algorithm>
#include <deque>
#include <variant>

#include "cansync/telegram/telegram.h"
#include "small/small_course.h"

namespace cansyncd::campaign {
namespace {

// --- another master

class ListensTooShortly final : public Tamper {
 public:
  cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) override {
    cansync::MasterSettings settings = of_plan;
    settings.startup.listen = can::Time(1);
    return settings;
  }
};

/// Does not notice that the bus was away.
class AlwaysThere final : public Tamper {
 public:
  can::ControllerStatus status() noexcept override {
    can::ControllerStatus status = below().status();
    status.state = can::ControllerState::error_active;
    status.link = can::LinkState::up;
    status.delivery = can::Delivery::normal;
    status.restarts = 0;
    return status;
  }
};

bool is_reference(const can::Frame& frame) noexcept {
  return (frame.id & 0x700u) == cansync::identifier::reference_one;
}

/// Does not hear the reference values of another master.
class DeafToReferences final : public Tamper {
 public:
  bool receive(can::ReceivedFrame& out) noexcept override {
    while (below().receive(out)) {
      if (out.own || !is_reference(out.frame)) return true;
    }
    return false;
  }
};

/// Looks at what has come after an edge, and not again once it has sent something.
class LooksAtEdgesAlone final : public Tamper {
 public:
  void sync_edge(can::Time due) noexcept override {
    looks_ = true;
    wire().sync_edge(due);
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    looks_ = false;
    return below().send(frame);
  }
  bool receive(can::ReceivedFrame& out) noexcept override {
    can::ReceivedFrame frame;
    while (below().receive(frame)) came_.push_back(frame);
    if (!looks_ || came_.empty()) return false;
    out = came_.front();
    came_.pop_front();
    return true;
  }

 private:
  std::deque<can::ReceivedFrame> came_;
  bool looks_ = true;
};

class OnlyReportsInRun final : public Tamper {
 public:
  cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) override {
    cansync::MasterSettings settings = of_plan;
    settings.startup.on_second_master = cansync::OnSecondMaster::report;
    return settings;
  }
};

class NeedsNoCommand final : public Tamper {
 public:
  AfterOtherMaster after_other_master(AfterOtherMaster) override { return AfterOtherMaster::resume; }
};

/// Waits for a command that nobody knows of.
class NeverResumes final : public Tamper {
 public:
  AfterOtherMaster after_other_master(AfterOtherMaster) override { return AfterOtherMaster::command; }
};

// --- which drive

/// Expects of each drive so many parameters at most.
template <std::uint8_t Most>
class ExpectsLess final : public Tamper {
 public:
  cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) override {
    cansync::MasterSettings settings = of_plan;
    for (cansync::SlaveSettings& slave : settings.slaves)
      slave.expect_count = std::min(slave.expect_count, Most);
    return settings;
  }
};

class ExpectsOthers final : public Tamper {
 public:
  cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) override {
    cansync::MasterSettings settings = of_plan;
    for (cansync::SlaveSettings& slave : settings.slaves) slave.expect[0].value += 7;
    return settings;
  }
};

class KnowsNoWordThatEnables final : public Tamper {
 public:
  cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) override {
    cansync::MasterSettings settings = of_plan;
    settings.startup.enabling_control_bits = 0;
    return settings;
  }
};

class OnlyReportsTwo final : public Tamper {
 public:
  cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) override {
    cansync::MasterSettings settings = of_plan;
    settings.startup.on_duplicate = cansync::OnDuplicate::report;
    return settings;
  }
};

/// Takes every drive for synchronized.
class SeesNoLossOfSync final : public Tamper {
 public:
  bool receive(can::ReceivedFrame& out) noexcept override {
    if (!below().receive(out)) return false;
    const cansync::Decoded decoded = cansync::decode(out.frame);
    const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
    const auto* reply = telegram != nullptr ? std::get_if<cansync::ParameterReply>(telegram) : nullptr;
    const bool is_status = reply != nullptr && !reply->busy && !reply->error &&
                           reply->number.value() == sim::parameter::status_word;
    if (is_status) out.frame.data[3] |= 0x80;
    return true;
  }
};

template <class T>
std::unique_ptr<Tamper> make() {
  return std::make_unique<T>();
}

constexpr const char* kReleased = "nothing_is_released_to_a_drive_that_is_not_the_one_expected";
constexpr const char* kEnabled = "no_word_that_enables_to_a_drive_that_is_not_the_one_expected";
constexpr const char* kListens = "it_listens_before_its_first_frame";
constexpr const char* kSilent = "no_frame_of_ours_while_another_master_is_there";

constexpr SmallMutant kMutants[] = {
    {"listens too shortly", &kOtherMasterCourse, kListens, &make<ListensTooShortly>},
    {"does not notice that the bus was away", &kOtherMasterCourse, kListens, &make<AlwaysThere>},
    {"deaf to reference values of others", &kOtherMasterCourse, kSilent, &make<DeafToReferences>},
    {"looks at edges alone", &kOtherMasterCourse, kSilent, &make<LooksAtEdgesAlone>},
    {"only reports in run", &kOtherMasterCourse, kSilent, &make<OnlyReportsInRun>},
    {"needs no command", &kOtherMasterCourse, "after_another_master_it_waits_for_the_command",
     &make<NeedsNoCommand>},
    {"never resumes", &kOtherMasterCourse, "it_begins_when_the_other_master_has_gone", &make<NeverResumes>},
    {"expects any drive", &kWhichDriveCourse, kReleased, &make<ExpectsLess<0>>},
    {"expects one parameter alone", &kWhichDriveCourse, kReleased, &make<ExpectsLess<1>>},
    {"expects other drives", &kWhichDriveCourse, "the_drive_expected_is_used", &make<ExpectsOthers>},
    {"knows no word that enables", &kWhichDriveCourse, kEnabled, &make<KnowsNoWordThatEnables>},
    {"sees no loss of SYNC", &kWhichDriveCourse, kEnabled, &make<SeesNoLossOfSync>},
    {"only reports two drives", &kWhichDriveCourse, "nothing_begins_with_two_drives_of_one_number",
     &make<OnlyReportsTwo>},
};

constexpr const SmallCourse* kCourses[] = {&kOtherMasterCourse, &kWhichDriveCourse};

}  // namespace

std::span<const SmallMutant> small_mutants() noexcept {
  return kMutants;
}

std::span<const SmallCourse* const> small_courses() noexcept {
  return kCourses;
}

}  // namespace cansyncd::campaign
