#pragma once

#include <cansync/layer2_function_blocks.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/function_blocks/fake_daemon.h"
#include "layer2/dds/topics.h"

/// The function blocks of layer 2 against a daemon without a bus.
namespace cansync::client::function_blocks {

/// Says what a daemon at 500 kbit/s would say, when the test wants it. Each object is a start of its own.
class FakeFrameDaemon : public FakeDaemon {
 public:
  explicit FakeFrameDaemon(const gateway::dds::ParticipantOptions& place, Reads reads = Reads::at_once)
      : FakeDaemon(place, "layer2") {
    if (reads == Reads::at_once) read_sends();
    bus.bit_rate = 500'000;
    status.running = true;
    tell();
  }
  void read_sends() { send_reader_.emplace(participant_); }
  void tell() {
    tell_bus();
    (void)status_writer_.write(status);
  }

  /// A frame that came.
  static layer2_ReceivedFrame frame(std::uint32_t identifier, std::vector<std::uint8_t> data) {
    layer2_ReceivedFrame received = {};
    received.received.identifier = identifier;
    received.received.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), std::begin(received.received.data));
    return received;
  }
  /// Frames came in one batch; `lost` counts those that are in none.
  void came(std::vector<layer2_ReceivedFrame> frames, std::uint64_t lost = 0) {
    layer2_FrameBatch batch = {};
    batch.number = ++batches_;
    batch.lost = lost;
    batch.frames._buffer = frames.data();
    batch.frames._length = batch.frames._maximum = static_cast<std::uint32_t>(frames.size());
    write_to_client(batch_writer_, batch);
  }

  std::vector<layer2_SendRequest> sends;
  std::vector<layer2_ControlRequest> controls;  ///< their data are in `configured`
  std::vector<std::string> configured;
  std::vector<layer2_ObjectRequest> objects;       ///< their settings are in `settings`
  std::vector<layer2_ObjectSettings> settings;     ///< of the last request that has some
  std::vector<std::vector<std::uint8_t>> outputs;  ///< of the process image
  bool answers = true;                             ///< every request is done at once
  void take() {
    if (send_reader_) {
      (void)send_reader_->take([this](const layer2_SendRequest& sample) {
        expect_meant(sample);
        sends.push_back(sample);
        if (answers) reply(sample, gateway_REPLY_DONE);
      });
    }
    (void)control_reader_.take([this](const layer2_ControlRequest& sample) {
      controls.push_back(sample);
      configured.emplace_back(reinterpret_cast<const char*>(sample.data._buffer), sample.data._length);
      if (answers) reply(sample, gateway_REPLY_DONE);
    });
    take_objects();
  }
  void take_objects() {
    (void)object_reader_.take([this](const layer2_ObjectRequest& sample) {
      expect_meant(sample);
      objects.push_back(sample);
      if (sample.settings._length != 0)
        settings.assign(sample.settings._buffer, sample.settings._buffer + sample.settings._length);
      if (answers) reply(sample, {});
    });
    (void)outputs_reader_.take([this](const layer2_ImageOutputs& sample) {
      outputs.emplace_back(sample.data._buffer, sample.data._buffer + sample.data._length);
    });
  }
  /// An answer as `content` says it; who asked need not stand in it.
  void reply(const layer2_ObjectRequest& request, layer2_ObjectReply content) {
    const auto who = reply_to<layer2_ObjectReply>(request, content.code, "");
    std::copy(std::begin(who.client), std::end(who.client), std::begin(content.client));
    content.request = request.request;
    write_to_client(object_writer_, content);
  }
  void tell(const layer2_ObjectStatus& object) { write_to_client(object_status_, object); }
  void tell(const layer2_ProcessImage& image) { write_to_client(image_writer_, image); }
  void reply(const layer2_SendRequest& request, gateway_ReplyCode code, std::string_view reason = {}) {
    write_to_client(send_writer_, reply_to<layer2_SendReply>(request, code, reason));
  }
  void reply(const layer2_ControlRequest& request, gateway_ReplyCode code, std::string_view reason = {}) {
    write_to_client(control_writer_, reply_to<layer2_ControlReply>(request, code, reason));
  }

  layer2_FrameStatus status = {};

 private:
  gateway::dds::Writer<layer2_FrameStatus> status_writer_{participant_};
  gateway::dds::Writer<layer2_FrameBatch> batch_writer_{participant_};
  gateway::dds::Writer<layer2_SendReply> send_writer_{participant_, clients_, nullptr};
  gateway::dds::Writer<layer2_ControlReply> control_writer_{participant_, clients_, nullptr};
  gateway::dds::Writer<layer2_ObjectReply> object_writer_{participant_, clients_, nullptr};
  gateway::dds::Writer<layer2_ObjectStatus> object_status_{participant_};
  gateway::dds::Writer<layer2_ProcessImage> image_writer_{participant_};
  gateway::dds::Reader<layer2_ObjectRequest> object_reader_{participant_};
  gateway::dds::Reader<layer2_ImageOutputs> outputs_reader_{participant_};
  std::optional<gateway::dds::Reader<layer2_SendRequest>> send_reader_;
  gateway::dds::Reader<layer2_ControlRequest> control_reader_{participant_};
  std::uint64_t batches_ = 0;
};

using FrameBlockTest = BlockTest<FakeFrameDaemon, FrameConnection>;

}  // namespace cansync::client::function_blocks
