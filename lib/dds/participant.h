#pragma once

#include <cstdint>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "dds/entity.h"

namespace gateway::dds {

/// Domains above this have no room for unicast discovery ports below 65536.
inline constexpr std::uint32_t kMaximumDomain = 230;

class Participant;

/// Where topics are looked for and offered.
struct ParticipantOptions {
  std::uint32_t domain = 0;      ///< DDS domain, 0..230
  std::string partition;         ///< the bus's name, 1..63 characters, without '*', '?' and '['
  std::string interface = "lo";  ///< network interface; `lo`: this computer alone, without multicast
  std::string xml;               ///< Cyclone DDS configuration used instead of the built one; empty: none
  std::string security;          ///< folder of an identity (dds/security.h); empty: without DDS Security
  /// It answers others: on `lo` those that look for the bus find it (dds/loopback_ports.h), and its writers
  /// go on while readers have not acknowledged up to 64 MiB of a topic, so that one that stands still, is
  /// dead or slow holds nobody else up. False: it finds those that serve the bus, and up to 500 KiB, as
  /// Cyclone has it.
  bool serves = false;
  /// Topics are of final types and go over the wire as XCDR1, which every implementation of DDS knows. All
  /// participants of a bus must have the same: those of the other kind do not match. False: appendable types,
  /// XCDR2.
  bool final_types = false;
  /// With `serves`: all its buses, this one among them; else not empty: it looks for all. Empty: this one.
  std::vector<std::string> all_partitions;
  /// What the interface is: another text is another one, such as after a change of its address.
  std::string link = {};
};

/// What is made anew when its participant moves.
class Movable {
 public:
  virtual ~Movable() = default;
  /// Makes it anew at `participant`. What it was before goes into `left`, to be deleted in this order. Throws
  /// SetupError, and is nothing for DDS then.
  virtual void move_to(const Participant& participant, std::list<Entity>& left) = 0;

 protected:
  Movable() = default;
  Movable(const Movable&) = default;
  Movable& operator=(const Movable&) = default;
};

/// Everything of a participant that moves with it. Any thread.
class Movables {
 public:
  void add(Movable& one);
  /// Waits for a move in progress.
  void remove(Movable& one) noexcept;
  /// Moves all, in the order in which they were made. Returns the first SetupError; null: there was none.
  std::exception_ptr move_to(const Participant& participant, std::list<Entity>& left);

 private:
  std::mutex mutex_;
  std::list<Movable*> all_;
};

/// The Cyclone DDS configuration for these options: the interface alone; on `lo` no multicast, so that it
/// works where multicast on `lo` is off, and the ports of dds/loopback_ports.h. `place`: of one that serves,
/// there.
std::string configuration(const ParticipantOptions& options, std::uint32_t place = 0);

/// One participant in one domain with a publisher and a subscriber in one partition. Several of one program
/// can be the same participant on the network (`participants`).
///
/// Participants of one process with the same domain and configuration share one of Cyclone's domains. With
/// `xml`, the domain's number is taken for it in this process. Functions may be called from any thread.
class Participant {
 public:
  /// Throws SetupError when an option is out of range, the interface does not exist, `xml` is for a domain
  /// that is already open in this process with another configuration, no port is left, or the files of
  /// `security` cannot be used.
  explicit Participant(const ParticipantOptions& options);
  ~Participant();
  Participant(Participant&&) noexcept;
  Participant& operator=(Participant&&) noexcept;
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// The same participant of DDS with a publisher and a subscriber of its own, for who takes the place of
  /// what has this one. Throws SetupError.
  Participant once_more() const;

  /// Becomes another participant of DDS, on this interface, with every reader and writer that was made with
  /// it; what late readers are to be told is told again. To the others that is one that has left and one that
  /// has come. What was not taken from readers is lost. What was before is deleted by a thread of its own,
  /// which the destructor waits for. Throws SetupError: nothing has changed when the interface cannot be used,
  /// else some readers and writers are without function until the next move. By the thread that alone uses the
  /// readers and writers; not with `xml`.
  void move_to(const std::string& interface, const std::string& link) const;

  /// What moves with it.
  const std::shared_ptr<Movables>& movables() const noexcept;

  const ParticipantOptions& options() const noexcept;
  dds_entity_t handle() const noexcept;
  dds_entity_t publisher() const noexcept;
  dds_entity_t subscriber() const noexcept;

  /// Other participants known in the domain now, of whatever program; discovery takes some 100 ms. 0 when
  /// that cannot be asked.
  std::uint32_t others() const noexcept;

  /// How often an endpoint of others did not match one of this participant's because of its QoS or type, here
  /// or in another partition. Any thread; does not ask DDS.
  std::uint64_t mismatches() const noexcept;

  /// How many of them were because of the type. Any thread; does not ask DDS.
  std::uint64_t type_mismatches() const noexcept;

  /// "DDS domain 3, partition can0, interface lo", for messages.
  std::string place() const;

  /// Throws SetupError with `what`, the meaning of `code`, the place and `remedy`.
  [[noreturn]] void fail(const std::string& what, dds_return_t code, const std::string& remedy) const;

 private:
  struct Shared;
  struct Impl;
  Participant(const ParticipantOptions& options, std::shared_ptr<Shared> shared);
  friend std::vector<Participant> participants(std::vector<ParticipantOptions> options);
  std::unique_ptr<Impl> impl_;
};

/// What a program needs that serves several buses, in their order: those whose options differ in nothing but
/// the partition are one participant on the network, and cost others what one bus does. All have `serves`;
/// `all_partitions` is filled in. Throws SetupError as the constructor of Participant does.
std::vector<Participant> participants(std::vector<ParticipantOptions> options);

}  // namespace gateway::dds
