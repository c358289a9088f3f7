#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cansync.h"
#include "cansync/config/config.h"
#include "cansync/dds/convert.h"
#include "cansync/dds/topics.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/desk/job_protocol.h"

/// CANsync's topics of requests, a row each (see daemon/desk/job_protocol.h). Gateway thread only.
namespace cansyncd {

/// What CANsync's requests need to know of the rest of the gateway.
struct JobContext {
  Exchange& exchange;
  const Config& config;
  RefusalContext line;  ///< newest state of the line
  SteadyTime now;
  RequestRules rules;
};

/// How a job ended that was taken; of one that was refused it says nothing.
cansync::Outcome outcome_of(const Terminal& terminal);

/// Topic Command: control words, broadcasts, and what takes effect at once.
struct CommandTopic {
  using Sample = cansync_Command;
  using Reply = cansync_CommandReply;
  static constexpr Right kRight = Right::operate;
  static constexpr bool kUrgent = true;
  static constexpr gateway::dds::TopicInfo kEngineerTopic = cansync::dds::kEngineerCommandTopic;

  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    return cansync::dds::command_refused(key, denial);
  }
  static Reply ended(const gateway::dds::RequestKey& key, cansync::Outcome outcome) {
    return cansync::dds::command_reply(key, outcome);
  }
  static Reply answer(const gateway::dds::RequestKey& key, const Terminal& terminal, const Request& request,
                      std::span<std::uint8_t> data, const JobContext& context);
};

/// Topic ParameterRequest.
struct ParameterTopic {
  using Sample = cansync_ParameterRequest;
  using Reply = cansync_ParameterReply;
  static constexpr Right kRight = Right::engineer;
  static constexpr std::size_t kAtOnce = 16;

  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    return cansync::dds::parameter_refused(key, denial);
  }
  static Reply ended(const gateway::dds::RequestKey& key, cansync::Outcome outcome);
  static Reply answer(const gateway::dds::RequestKey& key, const Terminal& terminal, const Request& request,
                      std::span<std::uint8_t> data, const JobContext& context);
};

/// Topic TransferRequest.
struct TransferTopic {
  using Sample = cansync_TransferRequest;
  using Reply = cansync_TransferReply;
  using Progress = cansync_TransferProgress;
  static constexpr Right kRight = Right::engineer;

  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    return cansync::dds::transfer_refused(key, denial);
  }
  static Reply ended(const gateway::dds::RequestKey& key, cansync::Outcome outcome);
  static Reply answer(const gateway::dds::RequestKey& key, const Terminal& terminal, const Request& request,
                      std::span<std::uint8_t> data, const JobContext& context);
  static std::size_t bytes_of(const Sample& sample) noexcept {
    return sample.direction == cansync_DIRECTION_DOWNLOAD ? sample.data._length : sample.length;
  }
  static Progress progress(const gateway::dds::RequestKey& key, std::uint32_t done, std::uint32_t total) {
    return cansync::dds::transfer_progress(key, done, total);
  }
};

}  // namespace cansyncd
