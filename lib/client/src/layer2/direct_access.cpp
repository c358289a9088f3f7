#include "client/src/layer2/direct_access.h"

#include <cansync/function_blocks/layer2/can_status.h>

#include <vector>

#include "layer2/dds/convert.h"

namespace cansync::client::detail {
namespace {

namespace status = function_blocks::can_status;

/// Status of a request that was refused, or not answered.
std::uint16_t code_of(const layer2::client::SendResult& result) {
  if (!result.replied || result.code != gateway_REPLY_REFUSED) return status::refused;
  switch (result.cause) {
    case gateway_CAUSE_WRONG_STATE:
      return status::denied;
    case gateway_CAUSE_QUEUE_FULL:
    case gateway_CAUSE_CLIENT_LIMIT:
    case gateway_CAUSE_SHARED_LIMIT:
      return status::full;
    case gateway_CAUSE_FIELD:
      return status::wrong_identifier;
    default:
      return status::refused;
  }
}

/// How a job ended that the daemon took.
JobStatus end_of(const layer2::client::SendResult& result, bool has_timeout) {
  const std::string reason = "daemon: " + result.reason;
  if (result.replied && result.code == gateway_REPLY_DONE) return {.code = status::done, .done = true};
  if (result.replied && result.code == gateway_REPLY_CANCELLED)
    return {.code = status::aborted, .reason = reason};
  const bool late = result.replied && (result.code == gateway_REPLY_TIMEOUT ||
                                       (result.code == gateway_REPLY_NO_ANSWER && has_timeout));
  return {.code = late ? status::timed_out : code_of(result), .reason = reason};
}

}  // namespace

bool DirectAccess::begin(layer2_ObjectRequest& wanted, Requests::Ended ended) {
  if (requests_.full()) return false;
  return requests_.begin([&](layer2::client::FrameClient& client) { return client.begin_object(wanted); },
                         std::move(ended));
}

bool DirectAccess::configure(std::span<const layer2_ObjectSettings> settings,
                             std::function<void(const Result&)> ended) {
  layer2_ObjectRequest wanted = {};
  wanted.action = layer2_OBJECT_CONFIGURE;
  std::vector<layer2_ObjectSettings> entries(settings.begin(), settings.end());
  wanted.settings._buffer = entries.data();
  wanted.settings._length = wanted.settings._maximum = static_cast<std::uint32_t>(entries.size());
  const std::uint64_t set_up = ++generations_;
  const bool begun = begin(wanted, [this, set_up, ended = std::move(ended)](const Result& result) {
    was_set_up(set_up, result);
    ended(result);
  });
  if (!begun) return false;
  for (const layer2_ObjectSettings& one : settings) {
    Object& object = objects_[one.number];
    const layer2_ObjectStatus newest = object.newest;
    object = {.configured = true, .setting_up = true, .set_up = set_up, .settings = one, .newest = newest};
    object.taken = newest.received;
    object.taken_time = newest.time;
  }
  return true;
}

void DirectAccess::was_set_up(std::uint64_t set_up, const Result& result) {
  const bool taken = result.replied && result.code == gateway_REPLY_DONE;
  for (unsigned number = 0; number < kObjects; ++number) {
    Object& object = objects_[number];
    if (object.set_up != set_up) continue;
    if (!taken) {
      object = {.newest = object.newest};
      continue;
    }
    object.setting_up = false;
    push_job(number);
  }
}

void DirectAccess::take_back() {
  std::vector<layer2_ObjectSettings> closed;
  for (unsigned number = 0; number < kObjects; ++number) {
    // One that receives and was never released takes nothing.
    if (objects_[number].configured) closed.push_back({.number = static_cast<std::uint8_t>(number)});
  }
  if (!closed.empty()) (void)configure(closed, [](const Result&) {});
  for (Object& object : objects_) object = {.newest = object.newest};
}

void DirectAccess::note(const layer2_ObjectStatus& status) {
  if (status.number >= kObjects) return;
  Object& object = objects_[status.number];
  object.newest = status;
  if (!object.configured) return;
  if (!object.settings.transmit) return note_received(status.number);
  note_held(status.number);
}

// --- an object that sends

JobStatus DirectAccess::send(unsigned number, const can::Frame& frame, bool on_remote, bool every_time) {
  Object& object = objects_[number];
  if (object.job == Job::sending)
    return {.code = status::full,
            .reason = "client: the object has a job; call again when it has ended, or abort it"};
  if (requests_.full())
    return {.code = status::full,
            .reason = "client: too many requests are open; call again when some have ended"};
  layer2_ObjectRequest wanted = {};
  wanted.action = layer2_OBJECT_SEND;
  wanted.number = static_cast<std::uint8_t>(number);
  wanted.content = layer2::dds::to_idl(frame);
  wanted.on_remote = on_remote;
  wanted.every_time = on_remote && every_time;
  object.generation = ++generations_;
  object.job = on_remote ? Job::held : Job::sending;
  object.every_time = wanted.every_time;
  object.aborting = false;
  object.job_number = object.answered = 0;
  object.answers = 0;
  object.end.reset();
  object.wanted_job = wanted;
  push_job(number);
  if (object.end) return *std::exchange(object.end, std::nullopt);
  return {.code = status::in_execution};
}

/// A daemon may take jobs before settings that were asked for earlier.
void DirectAccess::push_job(unsigned number) {
  Object& object = objects_[number];
  if (!object.wanted_job || object.setting_up) return;
  layer2_ObjectRequest wanted = *std::exchange(object.wanted_job, std::nullopt);
  const std::uint64_t generation = object.generation;
  if (begin(wanted, [this, number, generation](const Result& result) { sent(number, generation, result); }))
    return;
  object.job = Job::none;
  object.end = JobStatus{.code = status::refused, .reason = "client: " + requests_.problem()};
}

void DirectAccess::sent(unsigned number, std::uint64_t generation, const Result& result) {
  Object& object = objects_[number];
  const bool done = result.replied && result.code == gateway_REPLY_DONE;
  if (object.generation != generation) return;
  if (object.job == Job::held || object.job == Job::answering) {
    if (done) {
      object.job_number = result.job_number;
      return note_held(number);  // the daemon may have told of it before
    }
    object.end = end_of(result, object.settings.timeout != 0);
    object.job = Job::none;
    return;
  }
  if (object.job != Job::sending) return;
  object.job = Job::none;
  object.end = end_of(result, object.settings.timeout != 0);
  if (done && object.settings.tell) on_frame_(number, true);
}

/// No reply tells of its answers and its end: the one to the job came when the object held it. What the daemon tells
/// of another job of the object is not of this one.
void DirectAccess::note_held(unsigned number) {
  Object& object = objects_[number];
  if (object.job != Job::held && object.job != Job::answering) return;
  const layer2_ObjectStatus& newest = object.newest;
  if (object.job_number == 0 || newest.job_number < object.job_number) return;
  const bool replaced = newest.job_number > object.job_number;
  while (!replaced && object.job != Job::none && newest.job_sent > object.answered) {
    ++object.answered;
    ++object.answers;
    object.job = object.every_time ? Job::answering : Job::none;
    if (object.settings.tell) on_frame_(number, true);
  }
  if (object.job == Job::none || (!replaced && newest.job != layer2_OBJECT_JOB_NONE)) return;
  const bool timed_out = !replaced && newest.ended_as == layer2_OBJECT_END_TIMED_OUT;
  object.job = Job::none;
  const char* reason = "daemon: the job was aborted";
  if (replaced) reason = "daemon: a job of another program took its place; its last answers are not known";
  if (timed_out) {
    reason =
        object.settings.timeout == 0
            ? "daemon: its frame was handed over and not seen on the bus"
            : "daemon: nobody asked for the frame within the object's Timeout, or it was handed over and not "
              "seen on the bus";
  }
  object.end = JobStatus{.code = timed_out ? status::timed_out : status::aborted, .reason = reason};
}

void DirectAccess::abort(unsigned number) {
  Object& object = objects_[number];
  if (object.job == Job::none || object.aborting) return;
  if (object.wanted_job) {
    object.wanted_job.reset();
    object.job = Job::none;
    object.end = JobStatus{.code = status::aborted, .reason = "client: the job was aborted"};
    return;
  }
  layer2_ObjectRequest wanted = {};
  wanted.action = layer2_OBJECT_ABORT;
  wanted.number = static_cast<std::uint8_t>(number);
  const std::uint64_t generation = object.generation;
  object.aborting = begin(wanted, [this, number, generation](const Result& result) {
    Object& aborted = objects_[number];
    if (aborted.generation != generation) return;
    const bool done = result.replied && result.code == gateway_REPLY_DONE;
    aborted.aborting = done;
    const bool held = aborted.job == Job::held || aborted.job == Job::answering;
    if (!held || !done) return;
    aborted.job = Job::none;
    aborted.end = JobStatus{.code = status::aborted, .reason = "daemon: the job was aborted"};
  });
}

JobStatus DirectAccess::job(unsigned number) {
  Object& object = objects_[number];
  if (object.answers > 0) {
    --object.answers;
    return {.code = status::done, .done = true};
  }
  if (object.end) return *std::exchange(object.end, std::nullopt);
  const bool pending = object.job == Job::sending || object.job == Job::held;
  return {.code = pending ? status::in_execution : status::done};
}

// --- an object that receives

void DirectAccess::note_received(unsigned number) {
  Object& object = objects_[number];
  const layer2_ObjectStatus& newest = object.newest;
  if (!newest.full || !object.released) return;
  if (object.waiting && newest.received == object.taken) {
    object.overrun = object.overrun || newest.overrun;
    return;
  }
  if (object.waiting || newest.received <= object.taken) return;
  object.taken = newest.received;
  // A reply has brought it before.
  if (newest.time != 0 && std::exchange(object.taken_time, newest.time) == newest.time) return;
  object.waiting = layer2::dds::to_core(newest.content);
  object.overrun = object.overrun || newest.overrun;
  if (object.settings.tell) on_frame_(number, false);
}

Reading DirectAccess::read(unsigned number, std::size_t room, bool release, bool ask) {
  Object& object = objects_[number];
  Reading reading{.code = status::no_data};
  if (object.problem) {
    const JobStatus problem = *std::exchange(object.problem, std::nullopt);
    return {.code = problem.code, .reason = problem.reason};
  }
  if (object.waiting) {
    if (object.waiting->dlc > room)
      return {.code = status::wrong_parameter,
              .reason = "client: RxData: shorter than the frame, which waits; its length is " +
                        std::to_string(object.waiting->dlc)};
    reading.frame = std::exchange(object.waiting, std::nullopt);
    const bool overrun = std::exchange(object.overrun, false);
    reading.code = overrun ? status::full : status::done;
    object.wanted =
        WantedRead{.release = release, .ask = release && ask, .fetches = true, .overrun_told = overrun};
    object.released = release;
    object.asked = release && ask;
  } else if (release && !object.wanted && (!object.released || (object.asked && ask && !object.reading))) {
    object.wanted = WantedRead{.release = true, .ask = ask};
    object.released = true;
    object.asked = ask;
  }
  push_read(number);
  return reading;
}

void DirectAccess::push_read(unsigned number) {
  Object& object = objects_[number];
  if (!object.wanted || object.reading || object.setting_up) return;
  const WantedRead wanted = *object.wanted;
  layer2_ObjectRequest request = {};
  request.action = layer2_OBJECT_READ;
  request.number = static_cast<std::uint8_t>(number);
  request.release = wanted.release;
  request.ask = wanted.ask;
  const std::uint64_t set_up = object.set_up;
  object.reading = begin(request, [this, number, set_up, wanted](const Result& result) {
    if (objects_[number].set_up == set_up) was_read(number, wanted, result);
  });
  if (object.reading) object.wanted.reset();
}

/// The frame that a request took out of the daemon, when nobody has told of it before.
void DirectAccess::take_fetched(unsigned number, const Result& result) {
  Object& object = objects_[number];
  if (!result.fresh || object.waiting || result.sent_time == 0 || result.sent_time == object.taken_time)
    return;
  object.taken_time = result.sent_time;
  object.waiting = result.content;
  object.overrun = object.overrun || result.overrun;
  if (object.settings.tell) on_frame_(number, false);
}

void DirectAccess::was_read(unsigned number, const WantedRead& wanted, const Result& result) {
  Object& object = objects_[number];
  object.reading = false;
  if (result.replied && result.code == gateway_REPLY_DONE) {
    // Told with the frame that comes next: the one that was fetched is given already.
    object.overrun = object.overrun || (wanted.fetches && result.overrun && !wanted.overrun_told);
    return take_fetched(number, result);
  }
  const bool asks_already = result.replied && result.cause == gateway_CAUSE_QUEUE_FULL;
  if (asks_already) {
    if (wanted.fetches && !object.wanted) object.wanted = wanted;
    return;
  }
  object.released = false;
  object.problem = JobStatus{.code = code_of(result), .reason = "daemon: " + result.reason};
}

}  // namespace cansync::client::detail
