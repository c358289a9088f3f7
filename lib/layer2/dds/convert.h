#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "can/frame.h"
#include "dds/denial.h"
#include "dds/request_key.h"
#include "layer2.h"
#include "layer2/dds/topics.h"
#include "layer2/module.h"

/// Between the structs of the IDL and those of the core, in one file. Requests must have passed `check`
/// (validate.h); a field out of range is cut to its type and never read out of bounds. No function allocates
/// or throws; any thread.
namespace layer2::dds {

/// What of the frame is not sent (bytes beyond its length, data of a remote frame) is zero.
can::Frame to_core(const layer2_CanFrame& frame) noexcept;
/// `default_timeout` (over 0) counts for a request that names none. `following` must have been converted by
/// `following_of`, and outlive the order. The deadline is not looked at.
SendOrder to_core(const layer2_SendRequest& request, OrderId id, Time default_timeout,
                  std::span<const can::Frame> following = {}) noexcept;
/// The frames after the first one. Allocates.
std::vector<can::Frame> following_of(const layer2_SendRequest& request);

/// The order of a request, its timer's frame included.
ControlOrder to_core(const layer2_ControlRequest& request, OrderId id) noexcept;

/// `settings` must have been converted by `entries_of`, and outlive the order.
ObjectOrder to_core(const layer2_ObjectRequest& request, OrderId id,
                    std::span<const ObjectEntry> settings) noexcept;
/// Settings of message objects as the core has them. Allocates.
std::vector<ObjectEntry> entries_of(const layer2_ObjectRequest& request);

/// As the core has it; an error frame is no frame for clients and must not come here.
layer2_CanFrame to_idl(const can::Frame& frame) noexcept;
/// `receive_time` is CLOCK_REALTIME (ns) of the last bit; `range` the position of the range, 0..63.
layer2_ReceivedFrame received_frame(const can::Frame& frame, std::int64_t receive_time, std::uint8_t range,
                                    bool high_priority) noexcept;

/// The code by which an outcome is told.
gateway_ReplyCode to_reply_code(Outcome outcome) noexcept;
/// What an outcome means and what helps; empty when done.
std::string_view reason_of(Outcome outcome, Obstacle obstacle) noexcept;

/// Terminal reply to a request of so many `frames`; `sent_time` is CLOCK_REALTIME (ns) of the last bit and
/// counts when done alone.
layer2_SendReply send_reply(const RequestKey& key, const Answer& answer, std::int64_t sent_time,
                            std::size_t frames = 1);
/// Nothing was sent, for this cause and reason.
layer2_SendReply send_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept;

/// Likewise of a request to message objects; `time` as the members of the reply say.
layer2_ObjectReply object_reply(const RequestKey& key, const ObjectAnswer& answer,
                                std::int64_t time) noexcept;
/// Nothing was done, for this cause and reason.
layer2_ObjectReply object_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept;
/// A message object as it is; `time` is CLOCK_REALTIME (ns) of its last frame.
layer2_ObjectStatus object_status(unsigned number, const ObjectState& state, std::int64_t time) noexcept;
/// An event, its number left out.
layer2_ModuleEvent module_event(const ModuleEvent& event, std::int64_t time) noexcept;

/// Likewise of a request to control; `outcome` of one that was taken.
layer2_ControlReply control_reply(const RequestKey& key, Outcome outcome) noexcept;
/// Nothing was done, for this cause and reason.
layer2_ControlReply control_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept;

}  // namespace layer2::dds
