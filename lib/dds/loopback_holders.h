#pragma once

#include <cstdint>
#include <string>

namespace gateway::dds {

/// Who has the places of a domain on this computer (dds/loopback_ports.h), whatever its interface.
struct PlacesTaken {
  std::uint32_t serving = 0;  ///< of daemons, of `kPlaces`
  std::uint32_t asking = 0;   ///< of clients, likewise
  std::string holders;        ///< "cansync 85, python3 2": programs by how many they have; empty: not known
};

/// Looks into /proc. Of other users' programs only the number is known, but not to root. Any thread; takes
/// some milliseconds.
PlacesTaken places_taken(std::uint32_t domain);

/// "3 of 120 places of daemons and 120 of 120 of clients are taken (cansync 85, python3 2)"
std::string text_of(const PlacesTaken& taken);

}  // namespace gateway::dds
