#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/service/event_codes.h"

namespace cansyncd {

/// A change that a client asked for, in words. Its fields may be out of range: refused requests are recorded
/// too.
struct Change {
  std::string_view action;      ///< stable word; a literal
  int slave = -1;               ///< number, whatever a client gave; -1: none
  std::string what;             ///< which parameter, address or slaves; may be empty
  std::string new_value;        ///< what was asked for
  int parameter = -1;           ///< number, whatever a client gave; -1: none
  bool hashed = false;          ///< the SHA-256 of the request's data is recorded behind `new_value`
  std::string slave_name = {};  ///< its configured name; empty: none
  std::string series = {};      ///< what is sent again and again, such as an identifier; empty: it is not

  /// "slave 3 'winder'"; empty without a slave.
  std::string slave_text() const;
};

/// Who gave a request.
struct Requester {
  std::string name;         ///< what the client calls itself
  std::string label;        ///< the same with the beginning of its identity, for people
  std::string participant;  ///< DDS participant, 32 hexadecimal digits; empty: not known. With DDS Security
                            ///< its first 12 come from the certificate and cannot be chosen
  std::uint64_t request = 0;
};

/// A request as the journal has it.
struct RecordedRequest {
  Requester who;
  Change change;
  std::string before;  ///< the value it replaced, or would have
  std::string result;  ///< in words
  EventCode code = "request_done";
};

}  // namespace cansyncd
