#pragma once

#include <array>
#include <bitset>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "layer2/timers.h"

namespace layer2 {

/// Identifiers by a pattern (Saia 4.2.2): a frame of the width is taken when its identifier is that of the
/// rule in every bit of the mask. Mask bits of 0 do not count: mask 0 takes every identifier.
struct MaskRule {
  std::uint32_t identifier = 0;     ///< 0..0x7FF; extended 0..0x1FFFFFFF
  std::uint32_t mask = 0xFFFFFFFF;  ///< bits above those of the width do not count
  bool extended = false;            ///< 29-bit identifiers; false: 11-bit ones

  friend bool operator==(const MaskRule&, const MaskRule&) = default;
};

/// Data and remote frames, never error frames. Pure and realtime safe.
bool takes(const MaskRule& rule, const can::Frame& frame) noexcept;

/// One message object.
struct ObjectSettings {
  MaskRule rule;          ///< of an object that sends, its identifier and width
  bool transmit = false;  ///< it sends; false: it receives
  Time timeout{0};        ///< of a job to send, until it is aborted; 0: never
  bool tell = false;      ///< each frame that it sent or received is an event

  friend bool operator==(const ObjectSettings&, const ObjectSettings&) = default;
};

/// What an object is to send.
struct ObjectJob {
  can::Frame frame;        ///< data; its width must be the object's
  bool on_remote = false;  ///< held until a remote frame of its identifier asks for it
  bool every_time =
      false;  ///< with `on_remote`: each remote frame is answered, until another job replaces it
};

/// How far the job of an object is.
enum class JobState : std::uint8_t {
  none,       ///< no job was given, or its end was told
  under_way,  ///< waits, or is in the controller
  done,       ///< its frame stood on the bus; of `every_time`, since the last look
  aborted,    ///< taken back before it was sent
  timed_out,  ///< not sent in time
};

/// Why an object does not do what it is told.
enum class ObjectProblem : std::uint8_t {
  none,
  number,     ///< no such object
  reserved,   ///< it belongs to the data mapping or to the queues
  direction,  ///< it receives, or sends, or is not configured
  pending,    ///< it has a job that has not ended
  frame,      ///< identifier or length too large, or of another width
};

/// Where the job of an object is.
enum class JobPlace : std::uint8_t { none, waits_for_remote, ready, in_controller };

/// What an object had received.
struct ObjectReading {
  can::Frame frame;
  Time end{};            ///< of its last bit
  bool overrun = false;  ///< a frame came while it was full, and went on to the next that takes it
};

/// An object as it is.
struct ObjectState {
  bool configured = false;
  ObjectSettings settings;
  JobPlace place = JobPlace::none;     ///< of its job; of an object that receives, of the frame that asks
  bool every_time = false;             ///< its job answers each remote frame
  JobState ended_as = JobState::none;  ///< how its last job ended
  bool open = false;                   ///< takes the next frame that fits
  bool full = false;                   ///< holds a frame that was not read
  bool overrun = false;                ///< another one came while it was full
  can::Frame frame;                    ///< what its job sends, or what it received last
  Time time{};                         ///< end of the frame that it sent or received last; 0: none yet
  std::uint64_t sent = 0;              ///< frames, since the start
  std::uint64_t job_number = 0;        ///< of its job or its last one, from 1 on since the start; 0: none yet
  std::uint64_t job_sent = 0;          ///< of `sent`, frames of that job
  std::uint64_t received = 0;          ///< likewise
  std::uint64_t overruns = 0;          ///< likewise: frames that came while it was full

  friend bool operator==(const ObjectState&, const ObjectState&) = default;
};

/// The 32 message objects of direct access (Saia 3.2, 4.2.2, 4.3): each holds one frame, which it sends or
/// has received. The lowest number sends first, and receives first.
///
/// An object that receives is closed until it is released, and when it was read without being released anew.
/// Open, it takes one frame; while that was not read it is full, and another frame that it would take is
/// offered to the next object, with the first object's overrun told by the next reading. Realtime safe; one
/// thread.
class MessageObjects {
 public:
  static constexpr unsigned kMost = 32;

  /// Gives an object (0..kMost-1) its settings, anew: whatever it held is gone, and a job ends as aborted, or as
  /// timed out when its frame is in the controller: it may be sent yet.
  ObjectProblem configure(unsigned number, const ObjectSettings& settings) noexcept;
  /// What would be wrong with such settings of an object; nothing changes.
  ObjectProblem check(unsigned number, const ObjectSettings& settings) const noexcept;
  /// Takes an object's settings away; a job ends as by `configure`. False: there is no such object.
  bool forget(unsigned number) noexcept;
  /// From now on the object belongs to another service.
  void reserve(unsigned number) noexcept;
  /// The object is free for settings again.
  void unreserve(unsigned number) noexcept;
  /// Forgets every object's settings; what is reserved stays, and so do the counters.
  void reset() noexcept;

  // --- sending

  /// Gives an object a job. One that waits for a remote frame, or answers each, is replaced; another job must
  /// have ended.
  ObjectProblem start(unsigned number, const ObjectJob& job, Time now) noexcept;
  /// Takes a job back that is not in the controller. False: there is none.
  bool abort(unsigned number) noexcept;
  /// How far the job of an object is; its end, and each answer to a remote frame, is told once.
  JobState take_state(unsigned number) noexcept;

  /// The object whose frame goes next, the lowest number; nothing: none has one ready.
  std::optional<unsigned> next() const noexcept;
  /// What the object that `next` said sends.
  const can::Frame& frame(unsigned number) const noexcept { return objects_[number].job.frame; }
  /// The bus took the frame of an object. The number of this handing over, by which `sent` knows it again.
  std::uint32_t handed_over(unsigned number) noexcept;
  /// The frame of an object stood on the bus until `end`; `handing` is what `handed_over` said. One that was
  /// handed over before the object was configured anew is counted, and nobody's. True: it was the object's.
  bool sent(unsigned number, std::uint32_t handing, Time end = {}) noexcept;
  /// The echo of an object's frame does not come: it may have been sent. Its job ends as timed out; one that
  /// answers each remote frame goes on. `handing`: as of `sent`.
  void lost(unsigned number, std::uint32_t handing) noexcept;
  /// What was handed over is gone from the controller, and may have been sent: such jobs end as timed out.
  void controller_emptied() noexcept;
  /// Nothing more is to be sent: jobs end as aborted, those in the controller when it has sent their frame.
  void stop() noexcept;

  // --- receiving

  /// Opens an object that receives. With `request` a remote frame of its identifier is sent besides, whose
  /// answer comes to it.
  ObjectProblem release(unsigned number, bool request = false) noexcept;
  /// A frame of another node came. The object that has taken it; nothing: none, and the next service is
  /// asked. A remote frame makes objects ready that wait for it, and goes on, too. `end`: of its last bit.
  std::optional<unsigned> receive(const can::Frame& frame, Time end = {}) noexcept;
  /// What an object has received, once; `release` opens it anew at once.
  std::optional<ObjectReading> read(unsigned number, bool release) noexcept;

  // --- time

  /// It is `now`: ends jobs whose time has passed, but for those in the controller.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max(): nothing waits for time.
  Time next_deadline() const noexcept;

  // --- state

  /// An object (0..kMost-1) as it is.
  ObjectState state(unsigned number) const noexcept;
  /// Where the job of an object (0..kMost-1) is.
  JobPlace place(unsigned number) const noexcept { return objects_[number].phase; }
  /// Frames of an object are events; any number.
  bool tells(unsigned number) const noexcept { return number < kMost && objects_[number].settings.tell; }
  /// Rises with everything that happens to an object.
  std::uint64_t changes() const noexcept { return changes_; }

 private:
  using Phase = JobPlace;
  struct Object {
    ObjectSettings settings;
    bool configured = false;
    bool reserved = false;
    std::uint32_t handings = 0;
    std::uint32_t on_its_way = 0;  ///< handing of a frame handed over before the settings; 0: none
    ObjectState count;             ///< of it only `ended_as`, `time` and the counters
    // sending
    ObjectJob job;
    Phase phase = Phase::none;
    JobState told = JobState::none;  ///< what is to be told next; none: as `phase`
    Time until = Time::max();
    bool asked_again = false;  ///< every_time: a remote frame came while an answer was on its way
    // receiving
    bool open = false;
    bool full = false;
    bool overrun = false;
    bool request = false;  ///< a remote frame is to be sent, or is in the controller
    ObjectReading received;
  };

  ObjectProblem access(unsigned number, bool transmit) const noexcept;
  void answer_remote(const can::Frame& frame) noexcept;
  void renew(Object& object) noexcept;
  void end_job(Object& object, JobState as) noexcept;
  void give_up(Object& object) noexcept;

  std::array<Object, kMost> objects_ = {};
  std::uint64_t changes_ = 0;
};

}  // namespace layer2
