#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "j1939/claim_state.h"
#include "j1939/identifier.h"
#include "j1939/name.h"

namespace j1939 {

/// What a controller application is called, and which addresses it may take.
struct ClaimSettings {
  std::optional<Address> preferred;  ///< 0..253; nothing: it only listens
  Name name = 0;                     ///< of all on the bus its alone; lower is stronger
  Address first_other =
      128;                   ///< 0..253: with an arbitrary address in its NAME, the first it may take instead
  Address last_other = 247;  ///< at least `first_other`
  bool takes_commands = true;  ///< another may command it to an address (PGN 65240)
  /// From its request for all addresses on the bus to its own claim: who has answered by then keeps its
  /// address, however weak its NAME. 0: it claims at once, and contests.
  Time ask_time{0};
};

/// Who has claimed which address, as was heard.
class ClaimTable {
 public:
  static constexpr unsigned kAddresses = 254;

  /// Somebody of this NAME claims `address`; what it had before is free. An address over 253 frees alone.
  void claimed(Address address, Name name) noexcept;
  /// What was heard so far counts no more.
  void clear() noexcept;
  /// The NAME that claimed the address last; nothing: none was heard.
  std::optional<Name> at(Address address) const noexcept;
  /// Rises with each change.
  std::uint64_t revision() const noexcept { return revision_; }

 private:
  std::array<std::optional<Name>, kAddresses> names_ = {};
  std::uint64_t revision_ = 0;
};

/// Address claiming after SAE J1939-81: claims, keeps, loses, takes another, says that it cannot.
///
/// Sans-IO and bounded: of what it has to say each kind waits at most once. Realtime safe; one thread.
class AddressClaim {
 public:
  /// From a claim on the bus to the right to send.
  static constexpr Time kClaimTime = std::chrono::milliseconds(250);
  /// When others send with its own address, it claims that anew no more often than so.
  static constexpr Time kDefenceTime = std::chrono::seconds(5);

  /// Nothing is claimed before `start`.
  explicit AddressClaim(const ClaimSettings& settings) noexcept : settings_(settings) {}

  /// Asks all for their addresses and claims its own after `ClaimSettings::ask_time`; again, when the
  /// controller forgot what it was given: who does not answer then has no address any more.
  void start(Time now) noexcept;

  /// Another claims `source` (or says with kNullAddress that it has none).
  void claim_received(Address source, Name name, Time now) noexcept;
  /// Somebody asked it, or all, for the address claimed.
  void claim_requested(Time now) noexcept;
  /// Commands the one with this NAME to an address. False: another is meant, or it takes none.
  bool commanded(Name name, Address address, Time now) noexcept;
  /// Another node sent something that is no claim with the address that is its own.
  void own_address_used(Time now) noexcept;

  /// What is to be sent next, if anything is due at the time last told; then `handed_over`.
  std::optional<can::Frame> next_frame() const noexcept;
  /// The bus took what `next_frame` said.
  void handed_over() noexcept;
  /// A frame of its own stood on the bus until `end`.
  void sent(const can::Frame& frame, Time end) noexcept;
  /// A frame of its own is not waited for any more; nobody knows whether it stood on the bus.
  void unseen(const can::Frame& frame) noexcept;

  /// It is `now`.
  void advance(Time now) noexcept;
  /// When `advance` must be called at the latest; Time::max(): no time is waited for.
  Time next_deadline() const noexcept;

  /// As of now.
  ClaimState state() const noexcept { return state_; }
  /// With which it may send; nothing unless claimed.
  std::optional<Address> address() const noexcept;
  /// Claimed, or on the way to it; nothing: none.
  std::optional<Address> wanted() const noexcept;
  /// Another has the same NAME: no claim can be kept.
  bool name_twice() const noexcept { return name_twice_; }
  /// Times another with a stronger NAME took its address.
  std::uint64_t losses() const noexcept { return losses_; }
  /// Messages of others that had its own address as their source, claims apart.
  std::uint64_t intruders() const noexcept { return intruders_; }
  /// Those whose claims were heard.
  const ClaimTable& table() const noexcept { return table_; }

 private:
  void enter(ClaimEvent event) noexcept;
  void claim(Address address) noexcept;
  void claim_what_is_free(Time now) noexcept;
  bool own_name_heard() const noexcept;
  void give_up(Time now) noexcept;
  std::optional<Address> another() const noexcept;
  Time answer_delay() const noexcept;

  ClaimSettings settings_;
  ClaimTable table_;
  ClaimState state_ = ClaimState::listening;
  Address address_ = kNullAddress;
  bool ask_ = false;                ///< the request for all addresses is to be sent
  Time asked_until_ = Time::max();  ///< asking, and the request was on the bus: end of `ask_time`
  bool say_ = false;                ///< the claim, or that it cannot, is to be sent
  Time say_not_before_{};           ///< of `say_`
  Time claimed_at_ = Time::max();   ///< claiming, and its claim was on the bus: end of kClaimTime
  Time defended_ = Time::min();     ///< when it last claimed against an intruder
  Time now_{};
  bool name_twice_ = false;
  std::uint64_t losses_ = 0;
  std::uint64_t intruders_ = 0;
};

}  // namespace j1939
