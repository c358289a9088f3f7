#include "dds/participant.h"

#include <fmt/format.h>
#include <net/if.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <list>
#include <map>
#include <mutex>
#include <span>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

#include "dds/loopback.h"
#include "dds/loopback_holders.h"
#include "dds/loopback_ports.h"
#include "dds/security.h"
#include "dds/topic.h"
#include "system/descriptor.h"

namespace gateway::dds {
namespace {

/// One of Cyclone's domains, shared by the participants of this process that have the same configuration.
/// Several can be the same domain on the network.
struct Domain {
  Entity entity;
  std::uint32_t id = 0;    ///< in this process
  std::uint32_t port = 0;  ///< of one that serves on `lo`, the only one; else 0
  unsigned users = 0;
};

struct OpenDomains {
  std::mutex mutex;
  std::map<std::string, Domain> domain;  ///< by configuration

  bool has(std::uint32_t id) const {
    return std::any_of(domain.begin(), domain.end(), [id](const auto& one) { return one.second.id == id; });
  }
};

OpenDomains& open_domains() {
  static OpenDomains open;
  return open;
}

/// The buses of the participant.
std::span<const std::string> buses_of(const ParticipantOptions& options) {
  return options.all_partitions.empty() ? std::span(&options.partition, 1)
                                        : std::span(options.all_partitions);
}

/// Does the built configuration keep to this computer?
bool on_loopback(const ParticipantOptions& options) {
  return options.xml.empty() && options.interface == "lo";
}

std::string place_of(const ParticipantOptions& options) {
  return fmt::format("DDS domain {}, partition {}, interface {}", options.domain, options.partition,
                     options.xml.empty() ? options.interface : "as in the given Cyclone DDS configuration");
}

[[noreturn]] void fail_at(const ParticipantOptions& options, const std::string& what, dds_return_t code,
                          const std::string& remedy) {
  throw SetupError(
      fmt::format("{} failed: {} ({}); {}", what, dds_strretcode(code), place_of(options), remedy));
}

/// Throws when the DDS library could not open what it needs: without it, it ends the process.
void expect_descriptors(const ParticipantOptions& options) {
  constexpr std::size_t kNeeded = 8;
  std::array<sys::Descriptor, kNeeded> probe;
  for (std::size_t i = 0; i < kNeeded; ++i) {
    probe[i].reset(::eventfd(0, EFD_CLOEXEC));
    if (probe[i].is_open()) continue;
    throw SetupError(fmt::format(
        "DDS needs {} file descriptors, {} are left ({}); raise the limit (LimitNOFILE=, ulimit -n)", kNeeded,
        i, place_of(options)));
  }
}

/// Opens the domain under this number of this process; instead of the entity a negative DDS return code when
/// that cannot be done, and the port of `Domain`.
std::pair<dds_entity_t, std::uint32_t> open_domain(const ParticipantOptions& options, std::uint32_t id) {
  const auto open = [&](std::uint32_t place) {
    std::string text = configuration(options, place);
    if (id != options.domain) {
      constexpr std::string_view kDiscovery = "<Discovery>";
      text.insert(text.find(kDiscovery) + kDiscovery.size(),
                  fmt::format("<ExternalDomainId>{}</ExternalDomainId>", options.domain));
    }
    return dds_create_domain(id, text.c_str());
  };
  if (!on_loopback(options) || !options.serves) return {open(0), 0};
  for (std::uint32_t place = 0; place < kPlaces; ++place) {
    const std::uint32_t port =
        serving_port(options.domain, index_of_place(place_owner(buses_of(options)), place));
    if (!is_free(port)) continue;
    const dds_entity_t handle = open(place);
    // Another program may have taken it in between.
    if (handle >= 0 || is_free(port)) return {handle, port};
  }
  return {DDS_RETCODE_OUT_OF_RESOURCES, 0};
}

/// One participant's share of a domain; the last one closes it.
class DomainShare {
 public:
  explicit DomainShare(const ParticipantOptions& options)
      : key_(fmt::format("{} {} {}", options.domain, options.link, configuration(options))) {
    OpenDomains& open = open_domains();
    const std::lock_guard lock(open.mutex);
    if (const auto known = open.domain.find(key_); known != open.domain.end()) {
      ++known->second.users;
      id_ = known->second.id;
      port_ = known->second.port;
      return;
    }
    id_ = options.domain;
    if (open.has(id_) && !options.xml.empty()) {
      throw SetupError(fmt::format(
          "DDS domain {} is already open in this process with another configuration ({}); use the same "
          "interface for every connection, or another domain",
          options.domain, place_of(options)));
    }
    if (open.has(id_)) id_ = kMaximumDomain + 1;
    while (open.has(id_)) ++id_;
    expect_descriptors(options);
    const auto [handle, port] = open_domain(options, id_);
    if (handle < 0) {
      fail_at(
          options, "creating the DDS domain", handle,
          options.xml.empty()
              ? fmt::format("is the interface up, and is the domain in no use by other code of this process? "
                            "In it {}; end some of them, or use another domain",
                            text_of(places_taken(options.domain)))
              : "check the given Cyclone DDS configuration");
    }
    port_ = port;
    open.domain[key_] = {Entity(handle), id_, port, 1};
  }
  ~DomainShare() {
    OpenDomains& open = open_domains();
    const std::lock_guard lock(open.mutex);
    const auto entry = open.domain.find(key_);
    if (--entry->second.users == 0) open.domain.erase(entry);
  }
  DomainShare(const DomainShare&) = delete;
  DomainShare& operator=(const DomainShare&) = delete;

  /// Its number in this process.
  std::uint32_t id() const noexcept { return id_; }
  /// The only one it listens at, of one that serves on `lo`; else 0.
  std::uint32_t port() const noexcept { return port_; }

 private:
  std::string key_;
  std::uint32_t id_ = 0;
  std::uint32_t port_ = 0;
};

void check_options(const ParticipantOptions& options) {
  if (options.domain > kMaximumDomain) {
    throw SetupError(
        fmt::format("DDS domain {} is out of range; allowed: 0..{}", options.domain, kMaximumDomain));
  }
  if (options.partition.empty() || options.partition.size() > 63 ||
      options.partition.find_first_of("*?[") != std::string::npos) {
    throw SetupError(fmt::format(
        "'{}' is no bus name (DDS partition); allowed: 1 to 63 characters without * ? [", options.partition));
  }
  if (options.xml.empty() && if_nametoindex(options.interface.c_str()) == 0) {
    throw SetupError(
        fmt::format("network interface '{}' does not exist (DDS domain {}, partition {}); `ip link` lists "
                    "those there are, `lo` keeps to this computer",
                    options.interface, options.domain, options.partition));
  }
  if (options.security.empty()) return;
  if (const auto problem = security_problem(options.security, options.partition)) {
    throw SetupError("DDS Security: " + *problem);
  }
}

/// What DDS told of endpoints that do not match.
struct Mismatches {
  std::atomic<std::uint64_t> count{0};
  std::atomic<std::uint64_t> of_types{0};

  void add(std::uint32_t policy) noexcept {
    if (policy == DDS_PARTITION_QOS_POLICY_ID) return;  // those of other buses
    if (policy == DDS_TYPE_CONSISTENCY_ENFORCEMENT_QOS_POLICY_ID || policy == DDS_INVALID_QOS_POLICY_ID)
      ++of_types;
    ++count;
  }
};

/// Hears of every endpoint of a participant: those below take over what they do not hear themselves.
Listener mismatch_listener(Mismatches& mismatches) {
  Listener listener(dds_create_listener(&mismatches));
  dds_lset_inconsistent_topic(
      listener.get(), [](dds_entity_t /*topic*/, const dds_inconsistent_topic_status_t /*status*/,
                         void* all) { static_cast<Mismatches*>(all)->add(DDS_INVALID_QOS_POLICY_ID); });
  dds_lset_offered_incompatible_qos(
      listener.get(), [](dds_entity_t /*writer*/, const dds_offered_incompatible_qos_status_t status,
                         void* all) { static_cast<Mismatches*>(all)->add(status.last_policy_id); });
  dds_lset_requested_incompatible_qos(
      listener.get(), [](dds_entity_t /*reader*/, const dds_requested_incompatible_qos_status_t status,
                         void* all) { static_cast<Mismatches*>(all)->add(status.last_policy_id); });
  return listener;
}

}  // namespace

std::string configuration(const ParticipantOptions& options, std::uint32_t place) {
  if (!options.xml.empty()) return options.xml;
  // A peer that vanishes without a word is noticed after LeaseDuration. Heartbeats stay at Cyclone's own
  // pace: at 10 ms those of 60 participants that find each other keep two processors busy for more than a
  // minute.
  constexpr std::string_view kFrame =
      "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface "
      "name=\"{}\"/></Interfaces><AllowMulticast>{}</AllowMulticast></General><Discovery><LeaseDuration>5 "
      "s</LeaseDuration>{}</Discovery>{}</Domain></CycloneDDS>";
  // Without hashes of keys, other implementations do not take Cyclone's word that an endpoint has gone, and
  // notice it when its lease is over. No sample is larger than a transfer's.
  constexpr std::string_view kServes =
      "<Internal><GenerateKeyhash>true</GenerateKeyhash><MaxSampleSize>17 "
      "MiB</MaxSampleSize><Watermarks><WhcHigh>64 MiB</WhcHigh><WhcHighInit>64 "
      "MiB</WhcHighInit><WhcAdaptive>false</WhcAdaptive></Watermarks>{}</Internal>";
  // Cyclone ends each receiving thread by a packet to itself, which never comes by an interface that is gone;
  // the one that waits for all sockets it ends without.
  constexpr std::string_view kOneReceiver = "<MultipleReceiveThreads>false</MultipleReceiveThreads>";
  const bool loopback = options.interface == "lo";
  const auto discovery = [&] {
    if (options.serves) return serving_discovery(options.domain, buses_of(options), place);
    return options.all_partitions.empty() ? asking_discovery(options.domain, options.partition)
                                          : asking_all_discovery(options.domain);
  };
  return fmt::format(kFrame, options.interface, loopback ? "false" : "default", loopback ? discovery() : "",
                     options.serves ? fmt::format(kServes, loopback ? "" : kOneReceiver) : "");
}

/// What is one participant on the network.
struct Participant::Shared {
  explicit Shared(const ParticipantOptions& options) : domain(options) {
    const Qos rights(dds_create_qos());
    if (!options.security.empty()) add_security(rights.get(), options.security);
    participant =
        Entity(dds_create_participant(domain.id(), rights.get(), mismatch_listener(mismatches).get()));
    if (!participant) {
      fail_at(options, "creating the DDS participant", participant.get(),
              options.security.empty()
                  ? "is the interface up, and are UDP ports free?"
                  : "with DDS Security: is it switched on for every participant of this domain in this "
                    "program, and do the files of " +
                        options.security + " fit together?");
    }
    if (!on_loopback(options)) return;
    // Others of a program that serves may be on a network.
    if (domain.port() != 0) {
      keep_to_loopback(domain.port(), 1);
    } else {
      keep_to_loopback(kFirstPort + kPortsOfDomain * options.domain, kPortsOfDomain);
    }
  }
  Mismatches mismatches;  // declared before what is listened to
  DomainShare domain;     // declared before its participant: goes after it
  Entity participant;
};

struct Participant::Impl {
  /// What moves.
  struct Place {
    ParticipantOptions options;
    std::shared_ptr<Shared> shared;  // declared before its publisher and subscriber: goes after them
    Entity publisher;
    Entity subscriber;
  };

  explicit Impl(Place at) : place(std::move(at)) {}

  std::mutex mutex;  ///< of `place`, which other threads may ask for while it moves
  Place place;
  std::shared_ptr<Movables> movables = std::make_shared<Movables>();
  std::vector<std::future<void>> leaving;  ///< each deletes what was before a move

  /// Throws SetupError.
  static Place make_place(const ParticipantOptions& options, std::shared_ptr<Shared> shared);
};

Participant::Participant(const ParticipantOptions& options) {
  check_options(options);
  *this = Participant(options, std::make_shared<Shared>(options));
}

Participant::Participant(const ParticipantOptions& options, std::shared_ptr<Shared> shared)
    : impl_(std::make_unique<Impl>(Impl::make_place(options, std::move(shared)))) {}

Participant::Impl::Place Participant::Impl::make_place(const ParticipantOptions& options,
                                                       std::shared_ptr<Shared> shared) {
  Place place{options, std::move(shared), {}, {}};
  const dds_entity_t participant = place.shared->participant.get();
  const Qos qos(dds_create_qos());
  const char* partition = place.options.partition.c_str();
  dds_qset_partition(qos.get(), 1, &partition);
  const dds_entity_t publisher = dds_create_publisher(participant, qos.get(), nullptr);
  if (publisher < 0) fail_at(options, "creating the DDS publisher", publisher, "check the bus name");
  place.publisher = Entity(publisher);
  const dds_entity_t subscriber = dds_create_subscriber(participant, qos.get(), nullptr);
  if (subscriber < 0) fail_at(options, "creating the DDS subscriber", subscriber, "check the bus name");
  place.subscriber = Entity(subscriber);
  return place;
}

Participant::~Participant() = default;
Participant::Participant(Participant&&) noexcept = default;
Participant& Participant::operator=(Participant&&) noexcept = default;

Participant Participant::once_more() const {
  const std::lock_guard lock(impl_->mutex);
  return Participant(impl_->place.options, impl_->place.shared);
}

void Participant::move_to(const std::string& interface, const std::string& link) const {
  ParticipantOptions options = impl_->place.options;
  options.interface = interface;
  options.link = link;
  check_options(options);
  Impl::Place place = Impl::make_place(options, std::make_shared<Shared>(options));
  {
    const std::lock_guard lock(impl_->mutex);
    std::swap(place, impl_->place);
  }
  // A writer waits up to a second for readers that have not acknowledged everything, and those of an interface
  // that is gone never do.
  struct Left {
    Impl::Place place;
    std::list<Entity> endpoints;  // go before their place, the first at first
  };
  auto left = std::make_shared<Left>();
  left->place = std::move(place);
  const std::exception_ptr failed = impl_->movables->move_to(*this, left->endpoints);
  std::erase_if(impl_->leaving, [](const std::future<void>& one) {
    return one.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  });
  // Should there be no thread for it, it is deleted here.
  try {
    impl_->leaving.push_back(
        std::async(std::launch::async, [left = std::move(left)]() mutable { left.reset(); }));
  } catch (const std::system_error&) {
  }
  if (failed) std::rethrow_exception(failed);
}

const std::shared_ptr<Movables>& Participant::movables() const noexcept {
  return impl_->movables;
}

void Movables::add(Movable& one) {
  const std::lock_guard lock(mutex_);
  all_.push_back(&one);
}

void Movables::remove(Movable& one) noexcept {
  const std::lock_guard lock(mutex_);
  all_.remove(&one);
}

std::exception_ptr Movables::move_to(const Participant& participant, std::list<Entity>& left) {
  const std::lock_guard lock(mutex_);
  std::exception_ptr failed;
  for (Movable* one : all_) {
    try {
      one->move_to(participant, left);
    } catch (const SetupError&) {
      if (!failed) failed = std::current_exception();
    }
  }
  return failed;
}

const ParticipantOptions& Participant::options() const noexcept {
  return impl_->place.options;
}
dds_entity_t Participant::handle() const noexcept {
  return impl_->place.shared->participant.get();
}
dds_entity_t Participant::publisher() const noexcept {
  return impl_->place.publisher.get();
}
dds_entity_t Participant::subscriber() const noexcept {
  return impl_->place.subscriber.get();
}
std::uint32_t Participant::others() const noexcept {
  const Entity reader(dds_create_reader(handle(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
  if (!reader) return 0;
  std::array<void*, 256> samples = {};  // a domain has room for fewer
  std::array<dds_sample_info_t, samples.size()> infos;
  const dds_return_t count = dds_read_mask(reader.get(), samples.data(), infos.data(), samples.size(),
                                           samples.size(), DDS_ALIVE_INSTANCE_STATE);
  if (count <= 0) return 0;
  (void)dds_return_loan(reader.get(), samples.data(), count);
  return static_cast<std::uint32_t>(count - 1);
}

std::uint64_t Participant::mismatches() const noexcept {
  return impl_->place.shared->mismatches.count;
}

std::uint64_t Participant::type_mismatches() const noexcept {
  return impl_->place.shared->mismatches.of_types;
}

std::string Participant::place() const {
  return place_of(impl_->place.options);
}

std::vector<Participant> participants(std::vector<ParticipantOptions> options) {
  const auto network = [](const ParticipantOptions& one) {
    return std::tie(one.domain, one.interface, one.xml, one.security, one.final_types);
  };
  for (ParticipantOptions& one : options) {
    one.all_partitions.clear();
    for (const ParticipantOptions& other : options) {
      if (network(other) == network(one)) one.all_partitions.push_back(other.partition);
    }
    check_options(one);
  }
  std::vector<Participant> made;
  made.reserve(options.size());
  for (const ParticipantOptions& one : options) {
    const auto known = std::find_if(made.begin(), made.end(), [&](const Participant& each) {
      return network(each.options()) == network(one);
    });
    made.push_back(Participant(
        one, known == made.end() ? std::make_shared<Participant::Shared>(one) : known->impl_->place.shared));
  }
  return made;
}

void Participant::fail(const std::string& what, dds_return_t code, const std::string& remedy) const {
  fail_at(impl_->place.options, what, code, remedy);
}

}  // namespace gateway::dds
