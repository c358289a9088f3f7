#pragma once

#include <string>

namespace cansyncd {

/// Where DDS is for the buses of a file.
struct NetworkPlace {
  std::string interface;  ///< network interface; empty: it stays where it is
  std::string link;       ///< what the interface is: another text after a change, such as of its address
  std::string reason;     ///< why it is `lo` and not the interface that is configured; empty: it is that one
  friend bool operator==(const NetworkPlace&, const NetworkPlace&) = default;
};

/// What is true around the buses of a file, whatever their protocol. Members of GatewayStatus.
struct Surroundings {
  /// Why another configuration than the file on disk is in force; empty: it is that file.
  std::string configuration_reason;
  NetworkPlace network = {};
  std::string name_taken_by =
      {};  ///< computer whose daemon has the name of a bus on the network; empty: none
};

}  // namespace cansyncd
