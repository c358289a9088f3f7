#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <map>
#include <vector>

#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/writer_identity.h"

namespace cansyncd {

/// Which writers of one reader live, and who they are. Gateway thread only.
///
/// DDS tells that a key's last writer is gone, but not that one of several who share a key has died; that is
/// found here.
class WriterWatch {
 public:
  /// Both must outlive this object.
  WriterWatch(const gateway::dds::Participant& participant, const gateway::dds::ReaderBase& reader)
      : participant_(participant), reader_(reader) {}

  /// Looks what has changed; false: nothing since the last look.
  bool look();

  /// After a look that found something: has this writer left or died? When several died at once, DDS does not
  /// say which: then yes for one that `shares` its key; of another DDS has told that the key's last writer is
  /// gone.
  bool gone(dds_instance_handle_t writer, bool shares) const;

  /// The writers that are matched now.
  std::vector<dds_instance_handle_t> living() const;

  /// Has the writer left?
  bool left(dds_instance_handle_t writer) const;

  /// Who it is; also of writers that have left, when they were asked for before.
  const gateway::dds::WriterIdentity& identify(dds_instance_handle_t writer);

 private:
  struct Counts {
    dds_entity_t reader = 0;  ///< another one: all that was known has gone with it
    std::uint32_t matched = 0;
    std::uint32_t matched_ever = 0;
    std::uint32_t alive = 0;
    std::uint32_t dead = 0;
    friend bool operator==(const Counts&, const Counts&) = default;
  };

  const gateway::dds::Participant& participant_;
  const gateway::dds::ReaderBase& reader_;
  Counts counts_;
  bool some_died_ = false;          ///< between the last two looks
  dds_instance_handle_t dead_ = 0;  ///< the one that died; 0: it cannot be told which
  std::map<dds_instance_handle_t, gateway::dds::WriterIdentity> known_;
};

}  // namespace cansyncd
