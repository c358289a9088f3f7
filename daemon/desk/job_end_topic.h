#pragma once

#include <string_view>

#include "daemon/desk/access.h"
#include "daemon/desk/request_topic.h"
#include "dds/bounded_text.h"
#include "dds/denial.h"
#include "dds/overview/overview_topics.h"
#include "dds/request_key.h"

namespace cansyncd {

/// Topic JobEnd, which the desk of every protocol answers by itself: ends a request of anybody.
struct JobEndTopic {
  using Sample = gateway_JobEnd;
  using Reply = gateway_JobEndReply;
  static constexpr Right kRight = Right::engineer;
  /// In the audit trail.
  static constexpr std::string_view kAction = "job_end";

  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    Reply reply = to(key);
    gateway::dds::refuse(reply, denial);
    return reply;
  }
  /// `what` ends.
  static Reply done(const gateway::dds::RequestKey& key, std::string_view what) {
    Reply reply = to(key);
    reply.code = gateway_REPLY_DONE;
    gateway::dds::copy_text(what, reply.ended);
    return reply;
  }

 private:
  static Reply to(const gateway::dds::RequestKey& key) {
    Reply reply = {};
    std::copy(key.client.begin(), key.client.end(), std::begin(reply.client));
    reply.request = key.request;
    return reply;
  }
};

}  // namespace cansyncd
