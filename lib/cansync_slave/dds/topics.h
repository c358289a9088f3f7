#pragma once

#include <dds/dds.h>

#include <span>

#include "cansync_slave.h"
#include "cansync_slave_final.h"
#include "dds/gateway_topics.h"

/// Topics of cansync_slave.idl; with those of gateway.idl all that the bus of a slave has.
/// docs/cansync-slave.md shows the same table; a test compares both.
namespace gateway::dds {

template <>
inline constexpr TopicInfo topic_info<cansync_slave_ReferencesReceived> = {
    "ReferencesReceived", &cansync_slave_ReferencesReceived_desc, kFromDaemon, kind::state(),
    &cansync_slave_ReferencesReceived_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_MonitoredValues> = {
    "MonitoredValues", &cansync_slave_MonitoredValues_desc, kFromDaemon, kind::state(),
    &cansync_slave_MonitoredValues_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_ActualRelease> = {
    "ActualRelease", &cansync_slave_ActualRelease_desc, kFromClients, kind::exclusive(),
    &cansync_slave_ActualRelease_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_ActionReceived> = {
    "ActionReceived", &cansync_slave_ActionReceived_desc, kFromDaemon, kind::events(),
    &cansync_slave_ActionReceived_final_desc};
/// A step of a job counts for who is there; nobody answers what is over.
inline constexpr TopicQos kStepQos = {.depth = 100};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_ParameterJob> = {
    "ParameterJob", &cansync_slave_ParameterJob_desc, kFromDaemon, kStepQos,
    &cansync_slave_ParameterJob_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_BlockJob> = {
    "BlockJob", &cansync_slave_BlockJob_desc, kFromDaemon, kStepQos, &cansync_slave_BlockJob_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_ApplicationAnswer> = {
    "ApplicationAnswer", &cansync_slave_ApplicationAnswer_desc, kFromClients, kind::exclusive(),
    &cansync_slave_ApplicationAnswer_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_SlaveCommand> = {
    "SlaveCommand", &cansync_slave_SlaveCommand_desc, kFromClients, kind::request(),
    &cansync_slave_SlaveCommand_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_SlaveCommandReply> = {
    "SlaveCommandReply", &cansync_slave_SlaveCommandReply_desc, kFromDaemon, kind::reply(256, 128),
    &cansync_slave_SlaveCommandReply_final_desc};
template <>
inline constexpr TopicInfo topic_info<cansync_slave_SlaveSideStatus> = {
    "SlaveSideStatus", &cansync_slave_SlaveSideStatus_desc, kFromDaemon, kind::state(),
    &cansync_slave_SlaveSideStatus_final_desc};

}  // namespace gateway::dds

namespace cansync_slave::dds {

using namespace gateway::dds;  // what every protocol has

/// Every row, in the order of the IDL. Any thread; realtime safe.
std::span<const TopicInfo* const> all_topics() noexcept;

}  // namespace cansync_slave::dds
