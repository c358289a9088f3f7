#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cansync/telegram/telegram.h"
#include "course.h"
#include "small/which_drive_plan.h"

namespace cansyncd::campaign {

/// What a drive of the plan is and does, as it can be seen at the drive itself.
struct DriveSeen {
  const Unit* unit = nullptr;
  bool expected = false;  ///< it has what `expect` says of its number
  bool plugged = false;
  bool synchronized = false;  ///< takes the reference values that go to every drive
  bool hidden = false;        ///< was activated as a second drive that was not known yet
  bool unnoticed =
      false;  ///< took the place of one that had not said it is synchronized, before a command was missed
  can::Time told = can::Time::max();  ///< its first status word reached the daemon
  bool told_synchronized = false;     ///< so said the last one
  can::Frame last_sent;
  can::Time last_end{};
};

/// What the daemon promises about drives that are not the ones expected (docs/operations.md, "Which drive is it"),
/// by what the drives are and hold, and by what stood on the bus:
/// - While reference values go out, no such drive is synchronized: none takes them. But for a second drive of a number
///   that came so shortly before the activation that both have answered fewer than `kHidden` questions.
/// - No such drive is activated, with the same exception. Nor is a number that is not configured.
/// - A control word that enables goes to no such drive that is alone, once its status word has reached the daemon:
///   before that nothing tells that another drive is there than the one which was asked. But for one that took the
///   place of a drive that had not said it is synchronized, within `kShortestAbsence`: its status word tells nothing new, and it
///   is asked before it is activated.
/// - Where two drives of one number have answered `kDoubles` questions, both of them, no control word that enables goes
///   there, and run does not begin. Until then a second drive is not known.
/// - The drive expected is used.
class WhichDriveTruth {
 public:
  /// So many questions tell two drives for sure: eight, and those that each of four answers owed may hide.
  static constexpr unsigned kDoubles = 16;
  /// So few may be taken for answers owed, and one for a frame that came twice.
  static constexpr unsigned kHidden = 5;

  /// `plan` must outlive the object.
  explicit WhichDriveTruth(const WhichDrivePlan& plan);

  std::vector<DriveSeen> drives;  ///< as in the plan

  /// A drive is plugged in, or unplugged. A second one of its number may still get an activation that is on its way.
  void plugged_in(DriveSeen& drive, can::Time now) noexcept;
  void unplugged(DriveSeen& drive, can::Time now) noexcept;
  /// A drive's frame was on the bus until `end`; and a frame with that end has reached the daemon.
  void sent(std::size_t drive, const can::Frame& frame, can::Time end) noexcept;
  void received(const can::Frame& frame, can::Time end) noexcept;
  /// An operator says that the slave may be used again, or begins anew: what was known of two drives is forgotten.
  void released(unsigned number) noexcept { doubles_[number] = 0; }
  /// The bus took a telegram of ours.
  void handed_over(const can::Frame& frame, can::Time now);

  void violated(const char* invariant, const std::string& what, can::Time now);
  const std::optional<Violation>& violation() const noexcept { return violation_; }
  std::map<std::string, std::uint64_t> met;

 private:
  void activation(const cansync::ActionCommand& action, can::Time now);
  void enabling(const cansync::ActionCommand& action, can::Time now);
  void references(can::Time now);
  void question(unsigned number) noexcept;
  bool judged(const DriveSeen& drive) const noexcept;
  bool twin(const DriveSeen& drive) const noexcept;
  unsigned plugged(unsigned number) const noexcept;

  const WhichDrivePlan& plan_;
  bool expects_ = false;
  std::array<unsigned, cansync::kSlaves> answers_ = {};     ///< to the last question
  std::array<unsigned, cansync::kSlaves> doubles_ = {};     ///< questions with two answers
  std::array<can::Time, cansync::kSlaves> activated_ = {};  ///< when last
  std::array<can::Time, cansync::kSlaves> left_ =
      {};  ///< when one was unplugged that had not said it is synchronized
  can::Time last_reference_;
  std::optional<Violation> violation_;
};

}  // namespace cansyncd::campaign
