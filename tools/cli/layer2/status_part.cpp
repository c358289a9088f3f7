#include "cli/layer2/status_part.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

#include "cli/connect/bus_verb.h"
#include "layer2/client/frame_client.h"
#include "layer2_members.h"

namespace cansync::cli {
namespace {

/// Throws client::NoDaemon.
layer2_FrameStatus frame_status(Session& session) {
  layer2::client::FrameClient client = connect_bus<layer2::client::FrameClient>(session);
  return expect_told(client.status(session.search_time()), "FrameStatus", client.place());
}

std::vector<Explained> lines_of_frames(Session& session) {
  const layer2_FrameStatus status = frame_status(session);
  std::string received = fmt::format("{} of others, {} taken by a range, {} of them not published",
                                     status.received, status.taken, status.lost);
  if (status.taken_by_objects != 0)
    received += fmt::format(", {} by message objects", status.taken_by_objects);
  if (status.taken_by_mapping != 0)
    received += fmt::format(", {} by the process image", status.taken_by_mapping);
  if (status.dropped_by_mapping != 0)
    received += fmt::format(", {} dropped, for nothing is mapped for them", status.dropped_by_mapping);
  return {{"frames received", std::move(received)},
          {"frames sent", fmt::format("{}; {} not seen on the bus, {} not sent, {} waiting", status.sent,
                                      status.unanswered, status.not_sent, status.waiting)},
          {"bus load", fmt::format("{:.1f} %", status.bus_load / 10.0)},
          {"module", fmt::format("{}; LED BF {}", status.running ? "in run" : "in stop",
                                 std::string_view(status.bus_fault))}};
}

void add_frame_members(Session& session, JsonObject& object) {
  text::add_members(object, frame_status(session));
}

std::vector<Explained> frame_lines_help() {
  return {
      {"frames received", "frames of other nodes, since the start"},
      {"frames sent", "what became of requests to send, since the start; and how many wait now"},
      {"bus load", "share of the last second in which the bus was busy"},
      {"module",
       "run or stop; why the LED BF of a CAN 300 PRO would be lit: bus-off, stopped, passive, errors, overflow; "
       "off: it would not"}};
}

}  // namespace

const StatusPart kFrameStatusPart = {"layer2",
                                     lines_of_frames,
                                     add_frame_members,
                                     frame_lines_help,
                                     nullptr,
                                     nullptr,
                                     false,
                                     "cansync can reset-controller"};

}  // namespace cansync::cli
