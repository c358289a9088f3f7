#pragma once

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <vector>

#include "daemon/desk/writer_arbiter.h"
#include "dds/bounded_text.h"

namespace cansyncd {

/// What the status tells of who has something. `Ownership`: the struct of a protocol's IDL.
template <class Ownership>
void put_ownership(const WriterArbiter& arbiter, Ownership& out) noexcept {
  const gateway::dds::WriterIdentity& owner = arbiter.owner().identity;
  gateway::dds::copy_text(owner.who, out.writer);
  out.strength = owner.strength;
  std::copy(owner.guid.begin(), owner.guid.end(), std::begin(out.writer_guid));
  gateway::dds::copy_text(arbiter.waiting(), out.waiting_writer);
  out.refused = arbiter.refused();
}

/// Finds whether something has another owner, or another writer waits for it, than was told last.
class OwnershipChanges {
 public:
  /// True: something of it is another than at the last call. Always of the same `Arbiters`, in the same order.
  template <class... Arbiters>
  bool take(const Arbiters&... arbiters) {
    std::array<Told, sizeof...(Arbiters)> now{
        Told{arbiters.owner().handle, std::string(arbiters.waiting())}...};
    if (std::equal(now.begin(), now.end(), told_.begin(), told_.end())) return false;
    told_.assign(now.begin(), now.end());
    return true;
  }

 private:
  struct Told {
    WriterHandle owner = 0;
    std::string waiting;
    bool operator==(const Told&) const = default;
  };
  std::vector<Told> told_;
};

}  // namespace cansyncd
