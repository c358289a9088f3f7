#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "cansync/cluster/lead_axis.h"
#include "cansync/cluster/sub_slaves.h"
#include "config/print.h"
#include "config/rows.h"
#include "daemon_config/daemon_config.h"

/// The options of a cluster beside those of its slave and its master. Main thread.
namespace cansyncd {

/// Value of `bus.protocol`.
inline constexpr std::string_view kClusterProtocol = "cansync-cluster";

/// One [[sub_slave]].
struct SubSlaveDraft {
  std::optional<unsigned> slave;  ///< of the lower bus
  bool gateway = false;           ///< that slave is a gateway on the way to it
};

/// One [[lead]].
struct LeadDraft {
  cansync::LeadSource::Kind from = cansync::LeadSource::Kind::reference;
  std::optional<unsigned> value;
  std::optional<unsigned> slave;
  bool is_signed = true;
};

/// Configuration while it is being read.
struct ClusterDraft {
  DaemonConfig daemon;
  std::uint16_t own_number = 0;
  std::chrono::milliseconds monitoring{2000};
  std::chrono::milliseconds block_monitoring{20'000};
  std::chrono::milliseconds asker_gone{5000};
  std::chrono::milliseconds transfer_gone{30'000};
  std::chrono::microseconds lead_reserve{50};
  std::map<unsigned, SubSlaveDraft> sub_slaves;  ///< by CANsync number
  std::map<unsigned, LeadDraft> leads;           ///< by reference value of the lower bus
  unsigned number = 0;                           ///< of the section an option belongs to
};

/// Every row: the daemon's that both buses have, and those of a cluster.
const config::Rows<ClusterDraft>& cluster_option_rows();

/// The table of the rows.
const config::Table& cluster_options();

/// What its documents begin with.
extern const config::DocumentHeads cluster_document_heads;

}  // namespace cansyncd
