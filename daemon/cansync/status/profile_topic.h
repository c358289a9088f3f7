#pragma once

#include <map>
#include <string>

#include "cansync/config/config.h"
#include "dds/endpoint.h"
#include "dds/overview/overview_topics.h"
#include "dds/participant.h"

namespace cansyncd {

/// Publishes the files of the drive profiles that slaves have (topic DriveProfile), each once; one that is
/// longer than the topic has room for without its text. Gateway thread only.
class ProfileTopic {
 public:
  /// Throws gateway::dds::SetupError.
  explicit ProfileTopic(const gateway::dds::Participant& participant) : writer_(participant) {}

  /// Tells those of `config` that are new, and takes back those that no slave has any more.
  void tell(const Config& config);

 private:
  gateway::dds::Writer<gateway_DriveProfile> writer_;
  std::map<std::string, gateway_DriveProfile> told_;  ///< by SHA-256; without the text
};

}  // namespace cansyncd
