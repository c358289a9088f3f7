#pragma once

#include <dds/dds.h>

#include <span>

#include "cansync.h"
#include "cansync_final.h"
#include "dds/gateway_topics.h"

/// Topics of cansync.idl; with those of gateway.idl all that a bus of CANsync has. docs/dds-api.md shows the
/// same table; a test compares both.
namespace gateway::dds {

template <>
inline constexpr TopicInfo topic_info<cansync_ActualValues> = {
    "ActualValues", &cansync_ActualValues_desc, kFromDaemon, kind::state(), &cansync_ActualValues_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_ReferenceValues> = {
    "ReferenceValues", &cansync_ReferenceValues_desc, kFromClients, kind::exclusive(),
    &cansync_ReferenceValues_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_Interval> = {"Interval", &cansync_Interval_desc, kFromDaemon,
                                                           kind::latest(), &cansync_Interval_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_ParameterRequest> = {
    "ParameterRequest", &cansync_ParameterRequest_desc, kFromClients, kind::request(),
    &cansync_ParameterRequest_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_ParameterReply> = {
    "ParameterReply", &cansync_ParameterReply_desc, kFromDaemon, kind::reply(4096, 2048),
    &cansync_ParameterReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_TransferRequest> = {
    "TransferRequest", &cansync_TransferRequest_desc, kFromClients, kind::request(),
    &cansync_TransferRequest_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_TransferProgress> = {
    "TransferProgress", &cansync_TransferProgress_desc, kFromDaemon, kind::latest(),
    &cansync_TransferProgress_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_TransferReply> = {"TransferReply", &cansync_TransferReply_desc,
                                                                kFromDaemon, kind::reply(16, 64),
                                                                &cansync_TransferReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_Command> = {"Command", &cansync_Command_desc, kFromClients,
                                                          kind::request(), &cansync_Command_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_CommandReply> = {"CommandReply", &cansync_CommandReply_desc,
                                                               kFromDaemon, kind::reply(4096, 2048),
                                                               &cansync_CommandReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_MasterStatus> = {
    "MasterStatus", &cansync_MasterStatus_desc, kFromDaemon, kind::state(), &cansync_MasterStatus_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_SlaveStatus> = {
    "SlaveStatus", &cansync_SlaveStatus_desc, kFromDaemon, kind::state(), &cansync_SlaveStatus_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_Timing> = {"Timing", &cansync_Timing_desc, kFromDaemon,
                                                         kind::latest(), &cansync_Timing_final_desc};

}  // namespace gateway::dds

namespace cansync::dds {

using namespace gateway::dds;  // what every protocol has

/// Commands that only engineers may give, of the type of Command; used with DDS Security alone, whose
/// permissions are by topic.
inline constexpr TopicInfo kEngineerCommandTopic = {"EngineerCommand", &cansync_Command_desc, kFromClients,
                                                    kind::request(), &cansync_Command_final_desc};

/// Does the command go over that topic when DDS Security is on? True also for kinds that are not known.
bool for_engineers(cansync_CommandKind kind) noexcept;

/// Every row, in the order of the IDL.
std::span<const TopicInfo* const> all_topics() noexcept;

}  // namespace cansync::dds
