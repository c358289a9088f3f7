#include "client/src/link.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>

#include "dds/incompatible.h"
#include "dds/security.h"

namespace cansync::client::detail {
namespace {

/// 16 random bytes: no two clients have the same.
std::array<std::uint8_t, 16> random_identity() {
  std::array<std::uint8_t, 16> identity;
  // So few bytes never come in part.
  if (getrandom(identity.data(), identity.size(), 0) != static_cast<ssize_t>(identity.size())) {
    throw SetupError("the system gave no random numbers for the client's identity");
  }
  return identity;
}

dds::ParticipantOptions participant_options(const Options& options) {
  return {options.domain,   options.bus, options.interface,  options.xml,
          options.security, false,       options.final_types};
}

template <class R>
void end_all(const std::vector<std::shared_ptr<JobState<R>>>& jobs, const std::string& reason) {
  for (const auto& job : jobs) job->end(ReplyCode::no_reply, reason);
}

}  // namespace

Link::Link(const Options& options)
    : options_(options), identity_(random_identity()), participant_(participant_options(options)) {
  if (!options.security.empty()) engineer_writer_.emplace(participant_, dds::kEngineerCommandTopic, &signal_);
}

Link::~Link() {
  close();
}

void Link::connect(std::chrono::milliseconds wait) {
  // These come through the readers that are announced last: when the daemon has sent both here, it knows
  // every reply reader too, and no reply can get lost.
  open<MasterStatus>();
  open<GatewayStatus>();
  receiver_ = std::thread([this] { receive(); });
  using Clock = std::chrono::steady_clock;
  const auto began = Clock::now();
  std::unique_lock lock(mutex_);
  while (!ready_) {
    const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - began);
    lock.unlock();
    if (waited >= wait || !go_on()) throw NoDaemon(not_found(std::min(waited, wait)));
    lock.lock();
    ready_changed_.wait_until(lock, began + std::min(wait, waited + kAsk), [&] { return ready_; });
  }
}

bool Link::go_on() const {
  return !options_.go_on || options_.go_on();
}

void Link::close() {
  stop_ = true;
  signal_.raise();
  if (receiver_.joinable()) receiver_.join();
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  end_lost_jobs({});
}

bool Link::daemon_present() const {
  const std::lock_guard lock(mutex_);
  return !daemons_.empty();
}

Validity Link::validity(MappingBytes* mapping) const {
  Validity validity;
  (void)master_.wait(std::chrono::milliseconds(0), [&](const std::vector<MasterStatus>& known) {
    if (known.empty()) return true;
    std::copy(std::begin(known.front().daemon), std::end(known.front().daemon), validity.daemon.begin());
    validity.mapping_number = known.front().mapping_number;
    if (mapping != nullptr)
      std::copy(std::begin(known.front().reference_mapping), std::end(known.front().reference_mapping),
                mapping->begin());
    return true;
  });
  return validity;
}

std::string Link::not_found(std::chrono::milliseconds waited) const {
  const std::string place = fmt::format("looked for {} on {}", waited, participant_.place());
  const auto wrong = dds::find_incompatible(participant_, participant_.type_mismatches() != 0, 1);
  if (!wrong.empty()) {
    return fmt::format(
        "no usable daemon found: {}; {}; {}", place, to_string(wrong.front()),
        wrong.front().policy == "data representation"
            ? fmt::format("this program has {} types: are they what the daemon's dds.types says "
                          "(--types, CANSYNC_TYPES, Options::final_types)?",
                          options_.final_types ? "final" : "appendable")
            : "has the other program the version of this one?");
  }
  if (parameter_reader_.matched() == 0 && parameter_writer_.matched() == 0 && !options_.security.empty()) {
    return fmt::format(
        "no daemon found: {}, with DDS Security as {}; is cansyncd running for bus {} with dds.security set, "
        "and an identity of the same authority?",
        place, dds::security_subject(options_.security), options_.bus);
  }
  if (parameter_reader_.matched() == 0 && parameter_writer_.matched() == 0) {
    return fmt::format(
        "no daemon found: {}; is cansyncd running for bus {} (systemctl status cansyncd@{}), with the same "
        "domain and interface in its [dds] section? A daemon with DDS Security is not seen without an "
        "identity (--security)",
        place, options_.bus, options_.bus);
  }
  return fmt::format(
      "no usable daemon found: {}; one is there, but its topics do not all match: has it the same version as "
      "this program?",
      place);
}

std::string Link::not_permitted(std::string_view topic) const {
  return fmt::format(
      "the identity {} has no right to write topic {}, nothing was sent; control words, broadcasts and "
      "reference values need the role operator, everything else engineer: cansync-security add",
      dds::security_subject(options_.security), topic);
}

bool Link::everything_matched(std::size_t daemons) const {
  const auto heard_by = [&](const auto& reader) { return reader.matched() >= daemons; };
  // What the identity may not write will never be matched.
  const auto hear = [&](const auto& writer) { return !writer.permitted() || writer.matched() >= daemons; };
  return hear(parameter_writer_) && hear(transfer_writer_) && hear(command_writer_) && hear(cancel_writer_) &&
         (!engineer_writer_ || hear(*engineer_writer_)) && heard_by(parameter_reader_) &&
         heard_by(transfer_reader_) && heard_by(command_reader_) && master_.heard() >= daemons &&
         gateway_.heard() >= daemons;
}

Daemons Link::matched_daemons() const {
  constexpr std::size_t kMost = 64;
  Daemons daemons(kMost);
  const dds_return_t count = dds_get_matched_publications(parameter_reader_.handle(), daemons.data(), kMost);
  daemons.resize(std::min<std::size_t>(static_cast<std::size_t>(std::max(count, 0)), kMost));
  return daemons;
}

void Link::receive() {
  // Signals wake the loop; the period is for what might never signal, and for replies that do not come.
  constexpr std::int64_t kPeriodMs = 500;
  const auto period = static_cast<int>(std::clamp<std::int64_t>(options_.grace.count() / 4, 1, kPeriodMs));
  while (!stop_) {
    (void)signal_.wait(period);
    signal_.clear();
    // Looked at before the replies: what a daemon wrote before it left is taken first.
    const Daemons alive = matched_daemons();
    take_progress();
    take_replies();
    dispatch_feeds();
    end_lost_jobs(alive);
    end_overdue_jobs();
    // A request is written only when every daemon hears it, and its reply gets here: one that has just
    // started may be known by half of its topics.
    const bool ready = !alive.empty() && everything_matched(alive.size());
    const std::lock_guard lock(mutex_);
    daemons_ = alive;
    reachable_ = ready;
    if (ready && !ready_) {
      ready_ = true;
      ready_changed_.notify_all();
    }
  }
}

void Link::end_overdue_jobs() {
  constexpr std::chrono::milliseconds kLook(100);
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_at_time_ < std::min(kLook, options_.grace / 8)) return;
  looked_at_time_ = now;
  std::vector<std::uint64_t> late;
  std::vector<std::shared_ptr<JobState<ParameterReply>>> parameters;
  std::vector<std::shared_ptr<JobState<TransferReply>>> transfers;
  std::vector<std::shared_ptr<JobState<CommandReply>>> commands;
  {
    const std::lock_guard lock(mutex_);
    parameter_jobs_.look_at_time(now, late, parameters);
    transfer_jobs_.look_at_time(now, late, transfers);
    command_jobs_.look_at_time(now, late, commands);
  }
  // A daemon that takes no cancel is not asked again and again: each may take a second.
  (void)std::all_of(late.begin(), late.end(), [this](std::uint64_t request) { return cancel(request); });
  const auto end = [](const auto& jobs) {
    for (const auto& job : jobs) job->end_unheard();
  };
  end(parameters);
  end(transfers);
  end(commands);
}

void Link::dispatch_feeds() {
  gateway_.dispatch();
  master_.dispatch();
  slaves_.dispatch();
  actual_.dispatch();
  events_.dispatch();
  timing_.dispatch();
  interval_.dispatch();
}

void Link::end_lost_jobs(const Daemons& alive) {
  std::unique_lock lock(mutex_);
  const auto parameters = parameter_jobs_.remove_lost(alive);
  const auto transfers = transfer_jobs_.remove_lost(alive);
  const auto commands = command_jobs_.remove_lost(alive);
  const std::string reason =
      closed_ ? "the client was closed before the reply came; the daemon goes on with the request"
              : fmt::format("the daemon is gone ({}); whether the request was done is not known",
                            participant_.place());
  lock.unlock();
  end_all(parameters, reason);
  end_all(transfers, reason);
  end_all(commands, reason);
}

}  // namespace cansync::client::detail
