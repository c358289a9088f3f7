#pragma once

#include <cansync/topics.h>

#include <array>
#include <map>
#include <string>
#include <vector>

namespace cansync::cli {

/// What names meant at one instant: who bears which, and with them the profile that names a slave's parameters and the
/// names of the values. A reload of the daemon changes all of it while the daemon runs.
class HeldNames {
 public:
  HeldNames(const client::MasterStatus& master, const std::vector<client::SlaveStatus>& slaves);

  /// What is different in `now`, such as "slave 3 was 'winder' and is 'infeed'"; empty: nothing. A slave that is new is no
  /// difference.
  std::string change_to(const HeldNames& now) const;

 private:
  using ValueNames = std::array<std::string, 8>;
  struct Slave {
    std::string name;
    std::string profile;  ///< the SHA-256 of its file
    ValueNames values;    ///< its actual values
  };

  std::map<unsigned, Slave> slaves_;  ///< by number
  ValueNames references_;
};

}  // namespace cansync::cli
