#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "can/frame.h"
#include "client/src/open_requests.h"
#include "layer2/client/frame_client.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// What a call of SFB 401 tells of a job.
struct JobStatus {
  std::uint16_t code = 0;  ///< Status
  std::string reason;      ///< of an error
  bool done = false;
};

/// What a call of SFB 400 tells.
struct Reading {
  std::uint16_t code = 0;  ///< Status
  std::string reason;      ///< of an error
  std::optional<can::Frame> frame;
};

/// The message objects that a program has set up in the daemon (Saia 4.2.2), and how far they are, as its
/// replies and ObjectStatus say. Ends, answers and frames are told once. One thread.
class DirectAccess {
 public:
  static constexpr unsigned kObjects = layer2_OBJECTS;
  using Result = layer2::client::SendResult;
  using Requests = OpenRequests<layer2::client::FrameClient, Result>;
  /// Called for each frame of an object with an interrupt.
  using OnFrame = std::function<void(unsigned number, bool transmit)>;

  /// `requests` must outlive this.
  DirectAccess(Requests& requests, OnFrame on_frame) : requests_(requests), on_frame_(std::move(on_frame)) {}

  /// Sets objects up anew; numbers and ranges must have been checked. `ended` is called once. False: the
  /// daemon was not asked.
  bool configure(std::span<const layer2_ObjectSettings> settings, std::function<void(const Result&)> ended);
  /// What was set up is taken back: such objects neither send nor receive.
  void take_back();
  /// An object belongs to another service from now on.
  void forget(unsigned number) { objects_[number] = {}; }
  /// Nothing is set up in the daemon that is there now.
  void daemon_restarted() { objects_ = {}; }
  /// It is set up, and sends, or receives.
  bool ready(unsigned number, bool transmit) const noexcept {
    return objects_[number].configured && objects_[number].settings.transmit == transmit;
  }
  const layer2_ObjectSettings& settings(unsigned number) const noexcept { return objects_[number].settings; }

  /// What the daemon told of an object.
  void note(const layer2_ObjectStatus& status);

  // --- an object that sends

  /// Gives a job; one that is held for remote frames is replaced.
  JobStatus send(unsigned number, const can::Frame& frame, bool on_remote, bool every_time);
  /// Aborts its job, if it has one.
  void abort(unsigned number);
  /// How far its job is; an end, and each answer to a remote frame, is told once.
  JobStatus job(unsigned number);

  // --- an object that receives

  /// Takes a frame of at most `room` bytes out, and opens the object as SFB 400 says.
  Reading read(unsigned number, std::size_t room, bool release, bool ask);

 private:
  enum class Job : std::uint8_t { none, sending, held, answering };
  struct WantedRead {
    bool release = false;
    bool ask = false;
    bool fetches = false;  ///< a frame was given, which the daemon still holds
    bool overrun_told = false;
  };
  struct Object {
    bool configured = false;
    bool setting_up = false;       ///< the daemon has not answered: what is asked for waits here
    std::uint64_t set_up = 0;      ///< number of its settings: how older ones end is nobody's
    std::uint64_t generation = 0;  ///< likewise of its job
    layer2_ObjectSettings settings = {};
    layer2_ObjectStatus newest = {};
    // sending
    Job job = Job::none;
    std::optional<layer2_ObjectRequest> wanted_job;
    bool aborting = false;
    std::uint64_t job_number =
        0;  ///< of the job that is held, as the daemon counts; 0: it has not answered yet
    std::uint64_t answered = 0;  ///< its answers that are accounted for
    unsigned answers = 0;        ///< to be told
    bool every_time = false;
    std::optional<JobStatus> end;  ///< to be told
    // receiving
    bool released = false;
    bool asked = false;    ///< it was released for the answer to a remote frame
    bool reading = false;  ///< a request is open
    std::optional<WantedRead> wanted;
    std::uint64_t taken = 0;      ///< frames received before the one that waits
    std::int64_t taken_time = 0;  ///< CLOCK_REALTIME of the frame that waits, or was given last; 0: not known
    std::optional<can::Frame> waiting;
    bool overrun = false;
    std::optional<JobStatus> problem;  ///< to be told
  };

  bool begin(layer2_ObjectRequest& wanted, Requests::Ended ended);
  void note_held(unsigned number);
  void note_received(unsigned number);
  void take_fetched(unsigned number, const Result& result);
  void was_set_up(std::uint64_t number, const Result& result);
  void push_job(unsigned number);
  void sent(unsigned number, std::uint64_t generation, const Result& result);
  void push_read(unsigned number);
  void was_read(unsigned number, const WantedRead& wanted, const Result& result);

  Requests& requests_;
  OnFrame on_frame_;
  std::array<Object, kObjects> objects_ = {};
  std::uint64_t generations_ = 0;
};

}  // namespace cansync::client::detail
