#include "client/src/c_face/slave_events.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "dds/bounded_text.h"

namespace cansync::client::c_face {
namespace {

template <class Sample>
void take_values(const Sample& sample, cansync_slave_event& event) {
  std::copy(std::begin(sample.raw), std::end(sample.raw), std::begin(event.values));
  event.time_ns = sample.receive_time;
  event.interval = std::max(sample.interval[0], sample.interval[1]);
  event.words = sample.words;
  event.arrived = sample.arrived;
  event.ever = sample.ever;
}

int kind_of(cansync_slave_BlockStep step) noexcept {
  switch (step) {
    case cansync_slave_BLOCK_BEGUN:
      return CANSYNC_SLAVE_BLOCK;
    case cansync_slave_BLOCK_COMPLETE:
      return CANSYNC_SLAVE_BLOCK_DATA;
    case cansync_slave_BLOCK_TELEGRAM:
      return CANSYNC_SLAVE_BLOCK_STEP;
    case cansync_slave_BLOCK_ENDED:
      break;
  }
  return CANSYNC_SLAVE_BLOCK_END;
}

}  // namespace

cansync_slave_event event_of(const cansync_slave_ReferencesReceived& sample) {
  cansync_slave_event event = {};
  event.kind = CANSYNC_SLAVE_REFERENCES;
  take_values(sample, event);
  return event;
}

cansync_slave_event event_of(const cansync_slave_MonitoredValues& sample) {
  cansync_slave_event event = {};
  event.kind = CANSYNC_SLAVE_MONITORED;
  event.number = sample.slave;
  take_values(sample, event);
  return event;
}

cansync_slave_event event_of(const cansync_slave_ActionReceived& sample) {
  cansync_slave_event event = {};
  event.kind = sample.kind == cansync_slave_ACTION_CONTROL_WORD ? CANSYNC_SLAVE_CONTROL_WORD
               : sample.kind == cansync_slave_ACTION_SYNC_MODE  ? CANSYNC_SLAVE_SYNC_MODE
                                                                : CANSYNC_SLAVE_ACTION;
  event.time_ns = sample.time;
  event.interval = sample.interval;
  event.number = sample.command;
  event.data_byte = sample.data_byte;
  event.data_word = sample.data_word;
  return event;
}

cansync_slave_event event_of(const cansync_slave_ParameterJob& sample) {
  cansync_slave_event event = {};
  event.time_ns = sample.time;
  event.interval = sample.interval;
  event.job = sample.job;
  if (sample.step != cansync_slave_JOB_ASKED) {
    event.kind = CANSYNC_SLAVE_PARAMETER_END;
    event.answered = sample.step == cansync_slave_JOB_ANSWERED ? 1 : 0;
    return event;
  }
  event.kind = CANSYNC_SLAVE_PARAMETER;
  event.number = sample.parameter;
  event.element = sample.element;
  event.sub_slave = sample.sub_slave;
  event.write = sample.write ? 1 : 0;
  event.doubleword = sample.doubleword ? 1 : 0;
  event.value = sample.value;
  return event;
}

cansync_slave_event event_of(const cansync_slave_BlockJob& sample) {
  cansync_slave_event event = {};
  event.kind = kind_of(sample.step);
  event.time_ns = sample.time;
  event.interval = sample.interval;
  event.job = sample.job;
  const bool ended = sample.step == cansync_slave_BLOCK_ENDED;
  event.answered = ended && sample.result == cansync_slave_BLOCK_DONE ? 1 : 0;
  event.download = sample.download ? 1 : 0;
  event.whole = sample.whole ? 1 : 0;
  event.number = sample.address;
  event.length = sample.length;
  event.offset = sample.offset;
  event.telegram_bytes = sample.bytes;
  event.data_size = static_cast<std::uint32_t>(std::min<std::size_t>(sample.data._length, sizeof event.data));
  std::copy_n(sample.data._buffer, event.data_size, std::begin(event.data));
  return event;
}

cansync_slave_state state_of(const cansync_slave_SlaveSideStatus& status) {
  cansync_slave_state state = {};
  state.slave_number = status.slave_number;
  state.option_status = status.option_status;
  state.cansync_status = status.cansync_status;
  state.status_word = status.status_word;
  state.activated = status.activated ? 1 : 0;
  state.synchronized = status.synchronized ? 1 : 0;
  const std::string_view fault = gateway::dds::text(status.fault);
  state.fault = fault == "sync_lost"            ? CANSYNC_SLAVE_FAULT_SYNC_LOST
                : fault == "references_missing" ? CANSYNC_SLAVE_FAULT_REFERENCES_MISSING
                                                : CANSYNC_SLAVE_FAULT_NONE;
  const std::string_view reaction = gateway::dds::text(status.reaction);
  state.reaction = reaction == "quick_stop" ? 1 : (reaction == "pulse_inhibit" ? 2 : 0);
  state.interval = status.interval;
  state.interval_ns = status.interval_length;
  state.missing_edges = status.missing_edges;
  state.missing_references = status.missing_references;
  std::copy(std::begin(status.actual_sent), std::end(status.actual_sent), std::begin(state.actual_sent));
  std::copy(std::begin(status.actual_late), std::end(status.actual_late), std::begin(state.actual_late));
  state.status_parameter = status.status_parameter;
  std::copy(std::begin(status.reference_mapping), std::end(status.reference_mapping),
            std::begin(state.reference_mapping));
  std::copy(std::begin(status.actual_mapping), std::end(status.actual_mapping),
            std::begin(state.actual_mapping));
  gateway::dds::copy_text(gateway::dds::text(status.application), state.application);
  return state;
}

}  // namespace cansync::client::c_face
