#include "client/src/link.h"

#include <fmt/format.h>

#include <algorithm>

#include "dds/incompatible.h"
#include "dds/reply_partition.h"
#include "dds/security.h"
#include "dds/writer_identity.h"
#include "text/counts.h"
#include "text/unit_name.h"

namespace cansync::client::detail {
namespace {

dds::ParticipantOptions participant_options(const Options& options) {
  return {options.domain,     dds::bus_address(options.bus).bus,
          options.interface,  options.xml,
          options.security,   false,
          options.final_types};
}

/// Where the replies to a client come, and no others.
dds::Partitions own_partition(const dds::Participant& participant,
                              const std::array<std::uint8_t, 16>& identity) {
  return {dds::reply_partition(participant.options().partition, identity)};
}

/// What a bus of CANsync calls its protocol (GatewayStatus.protocol).
constexpr std::string_view kProtocol = "cansync-master";

template <class R>
void end_all(const std::vector<std::shared_ptr<JobState<R>>>& jobs, const std::string& reason) {
  for (const auto& job : jobs) job->end(ReplyCode::no_reply, reason);
}

}  // namespace

Link::Requests::Requests(const dds::Participant& participant, const Identity& identity,
                         dds::DataSignal* signal, bool secured)
    : parameter_writer(participant, 0, signal),
      transfer_writer(participant, 0, signal),
      command_writer(participant, 0, signal),
      cancel_writer(participant, 0, signal),
      parameter_reader(participant, own_partition(participant, identity), signal),
      transfer_reader(participant, own_partition(participant, identity), signal),
      progress_reader(participant, own_partition(participant, identity), signal),
      command_reader(participant, own_partition(participant, identity), signal) {
  if (secured) engineer_writer.emplace(participant, dds::kEngineerCommandTopic, signal);
}

Link::Link(const Options& options)
    : options_(options),
      address_(dds::bus_address(options.bus)),
      identity_(dds::random_client_identity()),
      participant_(participant_options(options)) {
  gateway_.set_first_look([this](const GatewayStatus& status, dds_instance_handle_t writer) {
    constexpr std::size_t kMost = 64;  // daemons of a bus
    const std::lock_guard lock(heard_mutex_);
    if (heard_.size() == kMost) heard_.erase(heard_.begin());
    heard_.push_back(
        {writer, dds::daemon_of(status), std::string(text(status.host)), std::string(text(status.protocol))});
  });
  with_feeds([&](auto& feed) { feed.set_go_on(options.go_on); });
  const auto where = [this](dds_entity_t reader, dds_instance_handle_t writer) {
    return place_of(reader, writer);
  };
  const auto set_place_of = [&where](auto&... feeds) { (feeds.set_place_of(where), ...); };
  set_place_of(gateway_, bus_, realtime_, master_, slaves_, actual_);
  if (options.requests) requests_.emplace(participant_, identity_, &signal_, !options.security.empty());
}

Link::~Link() {
  close();
}

void Link::connect(std::chrono::milliseconds wait) {
  // These come through the readers that are announced last: when the daemon has sent both here, it knows
  // every reply reader too, and no reply can get lost.
  if (requests_) open<MasterStatus>();
  open<GatewayStatus>();
  receiver_ = std::thread([this] { receive(); });
  using Clock = std::chrono::steady_clock;
  const auto began = Clock::now();
  std::unique_lock lock(mutex_);
  const auto several = [&] { return choice_.view() == dds::DaemonChoice::View::several; };
  // Without requests every protocol will do.
  const auto another = [&] {
    return requests_ && choice_.view() == dds::DaemonChoice::View::one && !protocol_.empty() &&
           protocol_ != kProtocol;
  };
  while (!ready_) {
    if (several()) throw SeveralDaemons(several_text());
    if (another()) throw OtherProtocol(address_.bus, protocol_, std::string(kProtocol));
    const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - began);
    lock.unlock();
    if (waited >= wait || !go_on()) throw NoDaemon(not_found(std::min(waited, wait)));
    lock.lock();
    ready_changed_.wait_until(lock, began + std::min(wait, waited + kAsk),
                              [&] { return ready_ || several() || another(); });
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
  end_lost_jobs();
}

bool Link::daemon_present() const {
  const std::lock_guard lock(mutex_);
  return present_;
}

std::string Link::several_daemons() const {
  const std::lock_guard lock(mutex_);
  return choice_.view() == dds::DaemonChoice::View::several ? several_text() : on_other_computer();
}

bool Link::is_there(const dds::DaemonIdentity& start) const {
  const std::lock_guard lock(mutex_);
  return present_ && choice_.view() == dds::DaemonChoice::View::one && choice_.daemon() == start;
}

bool Link::asks(const dds::DaemonIdentity& start) const {
  const std::lock_guard lock(mutex_);
  return choice_.view() == dds::DaemonChoice::View::one && choice_.daemon() == start && reachable_ &&
         on_other_computer().empty();
}

void Link::program_told_of(const dds::DaemonIdentity& start) {
  const std::lock_guard lock(mutex_);
  choice_.program_told_of(start);
}

std::string Link::names_of_living() const {
  std::string names;
  for (const Place place : choice_.living()) {
    if (!names.empty()) names += "; ";
    const auto seen = seen_.find(place);
    names += seen == seen_.end() ? "an unknown program" : seen->second.name;
  }
  return names;
}

std::string Link::on_other_computer() const {
  if (address_.computer.empty() || choice_.view() != dds::DaemonChoice::View::one) return {};
  const auto seen = seen_.find(choice_.living().front());
  // One of which nothing is known yet is not asked either.
  if (seen != seen_.end() && address_.is_on(seen->second.host)) return {};
  return dds::on_other_computer(address_, participant_.place(), names_of_living());
}

std::string Link::several_text() const {
  return fmt::format(
      "several daemons serve bus {} ({}): {}; nothing was sent: stop all but one, or give each a bus.name of its own",
      address_.bus, participant_.place(), names_of_living());
}

std::optional<std::pair<ReplyCode, std::string>> Link::obstacle() {
  using View = dds::DaemonChoice::View;
  const auto told = [this](ReplyCode code, std::string text) {
    choice_.program_told();
    return std::pair(code, std::move(text));
  };
  const View view = choice_.view();
  if (view == View::several) return told(ReplyCode::refused, several_text());
  if (std::string other = on_other_computer(); !other.empty())
    return told(ReplyCode::refused, std::move(other));
  if (view == View::unsure) {
    return told(
        ReplyCode::refused,
        fmt::format("the daemon was started anew, or a second one serves bus {}: {}; nothing was sent; try "
                    "again later",
                    address_.bus, names_of_living()));
  }
  if (choice_.to_be_told()) {
    return told(
        ReplyCode::refused,
        "the daemon was started anew, and settings that clients had made are lost; nothing was sent: look at "
        "the line, then ask again; requests from now on are for the new one");
  }
  if (view == View::none || !reachable_) {
    return told(ReplyCode::no_daemon,
                fmt::format("no daemon is there ({}); nothing was sent", participant_.place()));
  }
  return std::nullopt;
}

std::optional<dds::DaemonIdentity> Link::told_start() const {
  std::optional<dds::DaemonIdentity> start;
  gateway_.look([&](const std::vector<GatewayStatus>& known) {
    if (!known.empty()) start = dds::daemon_of(known.front());
  });
  return start;
}

Validity Link::validity(MappingBytes* mapping) const {
  Validity validity;
  master_.look([&](const std::vector<MasterStatus>& known) {
    if (known.empty()) return;
    std::copy(std::begin(known.front().daemon), std::end(known.front().daemon), validity.daemon.begin());
    validity.mapping_number = known.front().mapping_number;
    if (mapping != nullptr)
      std::copy(std::begin(known.front().reference_mapping), std::end(known.front().reference_mapping),
                mapping->begin());
  });
  return validity;
}

std::string Link::not_found(std::chrono::milliseconds waited) const {
  if (std::string other = several_daemons(); !other.empty()) return other;
  const std::string place =
      fmt::format("looked for {} on {}", text::duration_text(waited), participant_.place());
  const auto wrong = dds::find_incompatible(participant_, participant_.type_mismatches() != 0, 1);
  const bool nobody = gateway_.matched().empty();
  const bool older_types =
      !wrong.empty() && wrong.front().policy == "type" && wrong.front().topic == "MasterStatus";
  if (nobody && (older_types || !master_.matched().empty())) {
    return fmt::format(
        "the daemon of bus {} has data model 6 or older, this program {}: the two do not understand each other ({}); "
        "update cansyncd, or use a program of its version",
        address_.bus, gateway_DATA_MODEL, place);
  }
  if (!wrong.empty()) {
    return fmt::format(
        "no usable daemon found: {}; {}; {}", place, to_string(wrong.front()),
        wrong.front().policy == "data representation"
            ? fmt::format("this program has {} types: are they what the daemon's dds.types says "
                          "(--types, CANSYNC_TYPES, Options::final_types)?",
                          options_.final_types ? "final" : "appendable")
            : "has the other program the version of this one?");
  }
  if (nobody && !options_.security.empty()) {
    return fmt::format(
        "no daemon found: {}, with DDS Security as {}; is cansyncd running for bus {} with dds.security set, "
        "and an identity of the same authority?",
        place, dds::security_subject(options_.security), address_.in_words());
  }
  if (nobody) {
    return fmt::format(
        "no daemon found: {}; is cansyncd running for bus {} (systemctl status {}), with the same "
        "domain and interface in its [dds] section? A daemon with DDS Security is not seen without an "
        "identity (the option security)",
        place, address_.in_words(), text::shell_word("cansyncd@" + text::unit_instance(address_.bus)));
  }
  const std::vector<GatewayStatus> known = gateway_.known();
  if (!known.empty() && known.front().data_model != gateway_DATA_MODEL) {
    const std::uint32_t number = known.front().data_model;
    return fmt::format(
        "the daemon of bus {} has data model {}, this program {}: the two do not understand each other ({}); update {}",
        address_.bus, number, gateway_DATA_MODEL, place,
        number < gateway_DATA_MODEL ? "cansyncd, or use a program of its version"
                                    : "this program: build it with the data model of the daemon's version");
  }
  return fmt::format("no usable daemon found: {}; one is there, but {}", place,
                     other_protocol().empty()
                         ? "its topics do not all match: has it the same version as this program?"
                         : other_protocol());
}

std::string Link::not_told(std::string_view topic) const {
  // A client finds a daemon of its own data model; another one may have taken its place.
  std::string why = other_protocol();
  const std::vector<GatewayStatus> known = gateway_.known();
  if (why.empty() && !known.empty() && known.front().data_model != gateway_DATA_MODEL)
    why = fmt::format("it has data model {}, this program {}", known.front().data_model, gateway_DATA_MODEL);
  return fmt::format("the daemon has told no {} in time ({}): {}", topic, participant_.place(),
                     why.empty() ? "it has just begun, or the computer is busy; ask again" : why);
}

std::string Link::gone() const {
  return fmt::format("no daemon is there ({})", participant_.place());
}

std::string Link::other_protocol() const {
  const std::vector<GatewayStatus> known = gateway_.known();
  if (known.empty() || text(known.front().protocol) == kProtocol) return {};
  return fmt::format("it speaks {} on this bus, not {}", text(known.front().protocol), kProtocol);
}

void Link::expect_own_protocol() const {
  const std::vector<GatewayStatus> known = gateway_.known();
  if (known.empty() || text(known.front().protocol) == kProtocol) return;
  throw OtherProtocol(address_.bus, std::string(text(known.front().protocol)), std::string(kProtocol));
}

std::string Link::not_permitted(std::string_view topic) const {
  return fmt::format(
      "the identity {} has no right to write topic {}, nothing was sent; control words, broadcasts and "
      "reference values need the role operator, everything else engineer: cansync-security add",
      dds::security_subject(options_.security), topic);
}

bool Link::everything_matched(const std::vector<Place>& daemons) {
  if (gateway_.heard() < daemons.size()) return false;
  if (!requests_) return true;
  if (master_.heard() < daemons.size()) return false;
  if (daemons == reached_) return true;
  const auto of_all = [&](auto&& is_matched) {
    return std::all_of(daemons.begin(), daemons.end(), is_matched);
  };
  // What the identity may not write will never be matched.
  const auto hear = [&](const dds::WriterBase& writer) {
    return !writer.permitted() || of_all([&](Place daemon) { return dds::is_read_by(writer, daemon); });
  };
  const auto heard_by = [&](const dds::ReaderBase& reader) {
    return of_all([&](Place daemon) { return dds::is_written_by(reader, daemon); });
  };
  const Requests& all = *requests_;
  const bool reached = hear(all.parameter_writer) && hear(all.transfer_writer) && hear(all.command_writer) &&
                       hear(all.cancel_writer) && (!all.engineer_writer || hear(*all.engineer_writer)) &&
                       heard_by(all.parameter_reader) && heard_by(all.transfer_reader) &&
                       heard_by(all.command_reader);
  if (reached) reached_ = daemons;
  return reached;
}

std::vector<Place> Link::matched_places(dds_entity_t reader) {
  constexpr std::size_t kMost = 64;
  std::vector<dds_instance_handle_t> writers(kMost);
  const dds_return_t count = dds_get_matched_publications(reader, writers.data(), kMost);
  writers.resize(std::min<std::size_t>(static_cast<std::size_t>(std::max(count, 0)), kMost));
  std::vector<Place> places;
  for (const dds_instance_handle_t writer : writers) {
    const Place place = place_of(reader, writer);
    if (place != 0 && std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
  }
  return places;
}

Place Link::place_of(dds_entity_t reader, dds_instance_handle_t writer) {
  constexpr std::size_t kMost = 1024;  // far more than daemons that live
  const std::lock_guard lock(places_mutex_);
  if (places_.size() >= kMost) places_.clear();
  const auto known = places_.find(writer);
  if (known != places_.end()) return known->second;
  const Place place = dds::participant_of_writer(reader, writer);
  if (place != 0) places_.emplace(writer, place);
  return place;
}

void Link::choose_daemon(const std::vector<Place>& matched) {
  std::map<Place, Seen> seen;
  std::vector<Heard> all;
  {
    const std::lock_guard lock(heard_mutex_);
    all.swap(heard_);
  }
  for (const Heard& heard : all) {
    const Place place = place_of(gateway_.reader(), heard.writer);
    if (place == 0 || seen_.contains(place)) continue;
    const auto who = dds::identify_writer(participant_, gateway_.reader(), heard.writer);
    if (who) seen.emplace(place, Seen{who->who, heard.host});
  }
  const std::lock_guard lock(mutex_);
  seen_.merge(seen);
  for (const Heard& heard : all) {
    choice_.heard(place_of(gateway_.reader(), heard.writer), heard.daemon);
    protocol_ = heard.protocol;
  }
  choice_.look(std::chrono::steady_clock::now(), matched);
  std::erase_if(seen_, [&](const auto& one) {
    return std::find(matched.begin(), matched.end(), one.first) == matched.end();
  });
}

void Link::receive() {
  // Signals wake the loop; the period is for what might never signal, and for replies that do not come.
  constexpr std::int64_t kPeriodMs = 500;
  receiver_id_ = std::this_thread::get_id();
  const auto period = static_cast<int>(std::clamp<std::int64_t>(options_.grace.count() / 4, 1, kPeriodMs));
  while (!stop_) {
    (void)signal_.wait(period);
    signal_.clear();
    // Looked at before the replies: what a daemon wrote before it left is taken first.
    std::vector<Place> there = matched_places(gateway_.reader());
    const std::vector<Place> alive = requests_ ? matched_places(requests_->parameter_reader.handle()) : there;
    there.insert(there.end(), alive.begin(), alive.end());
    if (requests_) take_replies();
    take_feeds(there, !alive.empty());
    tell_feeds();
    end_lost_jobs();
    end_overdue_jobs();
    // A request is written only when every daemon hears it, and its reply gets here: one that has just
    // started may be known by half of its topics.
    const bool reachable = !alive.empty() && everything_matched(alive);
    const std::lock_guard lock(mutex_);
    reachable_ = reachable;
    ready_ = ready_ ||
             (reachable && choice_.view() == dds::DaemonChoice::View::one && on_other_computer().empty());
    ready_changed_.notify_all();
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

template <class Use>
void Link::with_feeds(Use&& use) {
  const auto each = [&use](auto&... feeds) { (use(feeds), ...); };
  each(gateway_, bus_, realtime_, master_, slaves_, actual_, events_, timing_, interval_);
}

void Link::take_feeds(const std::vector<Place>& matched, bool present) {
  actual_.take();  // before the statuses that say what they are: the daemon tells those first
  const auto take = [](auto&... feeds) { (feeds.take(), ...); };
  take(gateway_, bus_, realtime_, master_, slaves_, events_, timing_, interval_);
  choose_daemon(matched);
  // A daemon is known by its GatewayStatus: of one that has not told it yet nothing is forgotten either.
  std::vector<Place> living;
  {
    const std::lock_guard lock(mutex_);
    present_ = present;
    living = choice_.living();
    if (choice_.view() != dds::DaemonChoice::View::one)
      living.insert(living.end(), matched.begin(), matched.end());
  }
  const auto set_living = [&](auto&... feeds) { (feeds.set_living(present ? living : matched), ...); };
  set_living(gateway_, bus_, realtime_, master_);
  if (!present) living.clear();
  const auto keep_of = [&](auto&... feeds) { (feeds.keep_of(living), ...); };
  keep_of(slaves_, actual_, timing_, interval_);
}

void Link::tell_feeds() {
  with_feeds([](auto& feed) { feed.tell(); });
}

void Link::end_lost_jobs() {
  std::unique_lock lock(mutex_);
  const auto may_answer = [this](const dds::DaemonIdentity& start) {
    return !closed_ && choice_.may_answer(start);
  };
  const auto parameters = parameter_jobs_.remove_lost(may_answer);
  const auto transfers = transfer_jobs_.remove_lost(may_answer);
  const auto commands = command_jobs_.remove_lost(may_answer);
  if (!parameters.empty() || !transfers.empty() || !commands.empty()) choice_.program_told();
  const std::string_view what =
      choice_.view() == dds::DaemonChoice::View::none ? "is gone" : "was started anew";
  const std::string reason =
      closed_ ? "the client was closed before the reply came; the daemon goes on with the request"
              : fmt::format("the daemon {} ({}); whether the request was done is not known", what,
                            participant_.place());
  lock.unlock();
  end_all(parameters, reason);
  end_all(transfers, reason);
  end_all(commands, reason);
}

}  // namespace cansync::client::detail
