#pragma once

#include <cansync/function_blocks.h>
#include <cansync/slave_connection.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "cansync_slave/dds/topics.h"
#include "client/function_blocks/fake_daemon.h"
#include "dds/daemon_identity.h"
#include "dds/guard/writer_guid.h"

/// The function blocks of a slave against a daemon without a bus.
namespace cansync::client::function_blocks {

/// Says what the daemon of slave 5 would say, when the test wants it: active, at 1 Mbit/s, status word in
/// parameter 301, listening to slave 7. Each object is a start of its own.
class FakeSlaveDaemon : public FakeDaemon {
 public:
  /// Since when it writes jobs: DDS finds the endpoints of a program one by one.
  enum class WritesJobs { at_once, later };

  explicit FakeSlaveDaemon(const gateway::dds::ParticipantOptions& place,
                           WritesJobs jobs = WritesJobs::at_once)
      : FakeDaemon(place, "cansync-slave") {
    if (jobs == WritesJobs::at_once) write_jobs();
    status.slave_number = 5;
    status.option_status = 0x0020;
    status.interval_length = 1'000'000;
    status.status_parameter = 301;
    set({0x01, 0x03, 0x05, 0x07, 0x11, 0x13, 0x15, 0x17}, status.reference_mapping);
    set({0x01, 0x03, 0, 0, 0x1D, 0, 0, 0}, status.actual_mapping);
    tell();
    cansync_slave_MonitoredValues other = {};
    other.slave = 7;
    set({0x01, 0x03, 0x05, 0x07, 0, 0, 0, 0}, other.mapping);
    (void)monitored_writer_.write(other);
  }

  void tell() { (void)status_writer_.write(status); }
  /// Writes jobs from now on.
  void write_jobs() {
    job_writer_.emplace(participant_);
    block_writer_.emplace(participant_);
  }
  /// A program is known that may say what it takes over.
  bool hears() const { return answer_reader_.matched() != 0; }
  /// Each telegram comes a microsecond after the one before.
  void references(std::uint8_t telegram, std::uint32_t first, std::uint64_t interval) {
    put(telegram, first, interval, references_);
    references_.receive_time += 1000;
    write_to_client(references_writer_, references_);
  }
  void monitored(std::uint8_t slave, std::uint8_t telegram, std::uint32_t first, std::uint64_t interval) {
    monitored_[slave].slave = slave;
    put(telegram, first, interval, monitored_[slave]);
    monitored_[slave].receive_time += 1000;
    write_to_client(monitored_writer_, monitored_[slave]);
  }
  void action(cansync_slave_ActionKind kind, std::uint8_t command, std::uint8_t byte, std::uint16_t word) {
    cansync_slave_ActionReceived sample = {};
    sample.number = ++actions_;
    sample.kind = kind;
    sample.command = command;
    sample.data_byte = byte;
    sample.data_word = word;
    write_to_client(action_writer_, sample);
  }
  /// The status names the application that spoke last, or another one.
  void name_application(bool other) {
    gateway::dds::WriterGuid guid = application;
    if (other) guid[0] = static_cast<std::uint8_t>(guid[0] ^ 0xFF);
    std::copy(guid.begin(), guid.end(), std::begin(status.application_writer));
    tell();
  }
  /// Gives a job to the application that spoke last, or to another one.
  template <class Job>
  Job given(Job sample, bool other) const {
    gateway::dds::WriterGuid guid = application;
    if (other) guid[0] = static_cast<std::uint8_t>(guid[0] ^ 0xFF);
    std::copy(guid.begin(), guid.end(), std::begin(sample.application));
    return sample;
  }
  cansync_slave_ParameterJob job(std::uint64_t number, cansync_slave_JobStep step) const {
    cansync_slave_ParameterJob sample = {};
    sample.job = number;
    sample.step = step;
    sample.element = 7;
    gateway::dds::set_daemon(identity_, sample);
    return sample;
  }
  void write(const cansync_slave_ParameterJob& sample) { write_to_client(*job_writer_, sample); }
  cansync_slave_BlockJob block(std::uint64_t number, cansync_slave_BlockStep step) const {
    cansync_slave_BlockJob sample = {};
    sample.job = number;
    sample.step = step;
    sample.whole = true;
    sample.address = 0x100;
    gateway::dds::set_daemon(identity_, sample);
    return sample;
  }
  void write(cansync_slave_BlockJob sample, std::vector<std::uint8_t> data = {}) {
    sample.data._buffer = data.data();
    sample.data._length = sample.data._maximum = static_cast<std::uint32_t>(data.size());
    write_to_client(*block_writer_, sample);
  }

  /// What applications have said, and their data; signs of presence apart.
  struct Answer {
    cansync_slave_ApplicationAnswer sample;
    std::vector<std::uint8_t> data;
  };
  std::vector<Answer> answers;
  std::optional<std::vector<std::uint16_t>> parameters;  ///< taken over, as said last; none: no application
  bool blocks = false;
  gateway::dds::WriterGuid application = {};  ///< writer of the newest sign of presence
  std::vector<cansync_slave_ActualRelease> releases;
  void take() {
    (void)answer_reader_.take_batch([this](const cansync_slave_ApplicationAnswer& sample,
                                           const dds_sample_info_t& info) {
      if (!info.valid_data) return;
      if (sample.kind == cansync_slave_ANSWER_PRESENT)
        application = gateway::dds::guid_of_matched(answer_reader_.handle(), info.publication_handle);
      if (sample.kind == cansync_slave_ANSWER_GIVEN_UP) {
        parameters.reset();
        blocks = false;
      } else if (sample.kind == cansync_slave_ANSWER_PRESENT) {
        parameters.emplace(sample.parameters._buffer, sample.parameters._buffer + sample.parameters._length);
        blocks = sample.blocks;
      } else {
        expect_meant(sample);
        Answer& answer = answers.emplace_back();
        answer.sample = sample;
        answer.data.assign(sample.data._buffer, sample.data._buffer + sample.data._length);
      }
    });
    (void)command_reader_.take([this](const cansync_slave_SlaveCommand& sample) {
      expect_meant(sample);
      commands.push_back(sample);
      obey(sample);
    });
    (void)release_reader_.take([this](const cansync_slave_ActualRelease& sample) {
      if (!sample.given_up && gateway::dds::daemon_of(sample) == identity_) releases.push_back(sample);
    });
  }

  cansync_slave_SlaveSideStatus status = {};
  std::vector<cansync_slave_SlaveCommand> commands;
  std::string refuses;  ///< why it refuses commands; empty: it does what they say

 private:
  /// Does it, tells of it, and replies.
  void obey(const cansync_slave_SlaveCommand& sample) {
    auto reply = reply_to<cansync_slave_SlaveCommandReply>(sample, gateway_REPLY_DONE, refuses);
    if (!refuses.empty()) {
      reply.code = gateway_REPLY_REFUSED;
      reply.cause = gateway_CAUSE_WRONG_STATE;
    } else if (sample.kind == cansync_slave_SLAVE_COMMAND_MODE) {
      if (sample.mode == cansync_slave_SLAVE_MODE_SETUP) status.option_status = 0x0013;
      if (sample.mode == cansync_slave_SLAVE_MODE_RUN) status.option_status = 0x0020;
      if (sample.mode == cansync_slave_SLAVE_MODE_RESTART) status.option_status = 0x0003;
    } else if (sample.kind == cansync_slave_SLAVE_COMMAND_MAPPING) {
      std::copy(std::begin(sample.reference_mapping), std::end(sample.reference_mapping),
                std::begin(status.reference_mapping));
      std::copy(std::begin(sample.actual_mapping), std::end(sample.actual_mapping),
                std::begin(status.actual_mapping));
    } else {
      cansync_slave_MonitoredValues other = {};
      other.slave = sample.other;
      std::copy(std::begin(sample.actual_mapping), std::end(sample.actual_mapping),
                std::begin(other.mapping));
      write_to_client(monitored_writer_, other);
    }
    tell();
    write_to_client(reply_writer_, reply);
  }

  static void set(const std::array<std::uint8_t, 8>& from, std::uint8_t (&to)[8]) {
    std::copy(from.begin(), from.end(), std::begin(to));
  }
  /// Values first, first + 1 and so on.
  template <class Sample>
  static void put(std::uint8_t telegram, std::uint32_t first, std::uint64_t interval, Sample& sample) {
    const unsigned place = telegram - 1u;
    for (unsigned i = 0; i < 4; ++i) sample.raw[4 * place + i] = first + i;
    sample.arrived = static_cast<std::uint8_t>(1u << place);
    sample.ever = static_cast<std::uint8_t>(sample.ever | sample.arrived);
    sample.interval[place] = interval;
  }

  gateway::dds::Writer<cansync_slave_SlaveSideStatus> status_writer_{participant_};
  gateway::dds::Writer<cansync_slave_ReferencesReceived> references_writer_{participant_};
  gateway::dds::Writer<cansync_slave_MonitoredValues> monitored_writer_{participant_};
  gateway::dds::Writer<cansync_slave_ActionReceived> action_writer_{participant_};
  std::optional<gateway::dds::Writer<cansync_slave_ParameterJob>> job_writer_;
  std::optional<gateway::dds::Writer<cansync_slave_BlockJob>> block_writer_;
  gateway::dds::Reader<cansync_slave_ApplicationAnswer> answer_reader_{participant_};
  gateway::dds::Reader<cansync_slave_ActualRelease> release_reader_{participant_};
  gateway::dds::Reader<cansync_slave_SlaveCommand> command_reader_{participant_};
  gateway::dds::Writer<cansync_slave_SlaveCommandReply> reply_writer_{participant_, clients_, nullptr};
  cansync_slave_ReferencesReceived references_ = {};
  std::array<cansync_slave_MonitoredValues, 32> monitored_ = {};
  std::uint64_t actions_ = 0;
};

class SlaveBlockTest : public ::testing::Test {
 protected:
  /// Calls the block and lets the daemon listen until `condition` holds.
  template <class Block, class Condition>
  bool call_until(Block& block, Condition&& condition) {
    return repeat_until(
        [&] {
          cycle(block, now);
          daemon->take();
          std::this_thread::yield();
        },
        condition);
  }
  template <class Block>
  void call_often(Block& block) {
    for (int i = 0; i < 50; ++i) {
      cycle(block, now);
      daemon->take();
    }
  }

  TwoPlaces places;
  std::optional<FakeSlaveDaemon> daemon{std::in_place, places.here};
  SlaveConnection connection = SlaveConnection::connect(options_at(places.there));
  Clock::time_point now = Clock::now();
};

}  // namespace cansync::client::function_blocks
