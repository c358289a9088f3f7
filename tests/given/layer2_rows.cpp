// What may be given to a bus of general frames.
#include "daemon/layer2/segment/layer2_segment.h"
#include "layer2.h"
#include "layer2/dds/topics.h"
#include "row_on.h"
#include "rows.h"

namespace given {
namespace {

using std::chrono::milliseconds;

const std::string kBus = R"([bus]
interface = "sim"
protocol = "layer2"
bit_rate = 500000
[dds]
request_max_age_ms = 0
[recorder]
folder = ""
[[receive]]
number = 0
first = 0
last = 0x7FF
)";
const std::string kMapped = R"([mapping]
interval_ms = 10
[[mapped]]
number = 0
identifier = 0x201
address = 0
size = 2
output = true
)";

class Layer2Row : public RowOn {
 public:
  void set_running(bool running) override {
    control(watcher(), running ? layer2_CONTROL_RUN : layer2_CONTROL_STOP);
  }

 protected:
  explicit Layer2Row(const std::string& file = {}, const std::string& changed = {})
      : RowOn({make_daemon<DeadlineDaemon<cansyncd::Layer2Parts>>, kBus}, file, changed) {}

  static void control(Program& by, layer2_ControlKind kind, std::uint8_t number = 0) {
    layer2_ControlRequest request = {};
    request.kind = kind;
    request.number = number;
    (void)by.ask<layer2_ControlReply>(request);
  }
  static void configure(Program& by, const std::string& toml) {
    std::vector<std::uint8_t> bytes(toml.begin(), toml.end());
    layer2_ControlRequest request = {};
    request.kind = layer2_CONTROL_CONFIGURE;
    request.data._buffer = bytes.data();
    request.data._length = request.data._maximum = static_cast<std::uint32_t>(bytes.size());
    (void)by.ask<layer2_ControlReply>(request);
  }
  static void write_image(Program& by, std::uint8_t value, std::uint16_t address = 0) {
    layer2_ControlRequest request = {};
    request.kind = layer2_CONTROL_WRITE_IMAGE;
    request.address = address;
    request.size = 1;
    request.bytes[0] = value;
    (void)by.ask<layer2_ControlReply>(request);
  }
  static layer2_CanFrame frame_of(std::uint32_t identifier, std::uint8_t value) {
    layer2_CanFrame frame = {};
    frame.identifier = identifier;
    frame.length = 1;
    frame.data[0] = value;
    return frame;
  }
  std::string image() {
    return frames([](const can::Frame& frame) {
      return frame.id == 0x201 ? whose(frame.data[0], frame.data[1]) : std::string();
    });
  }
  std::string frames_of(std::uint32_t identifier) {
    return frames([&](const can::Frame& frame) {
      return frame.id == identifier ? whose(frame.data[0]) : std::string();
    });
  }
};

/// Outputs of the process image, by a writer: byte 0 by the first, byte 1 by the second.
class Outputs final : public Layer2Row {
 public:
  Outputs() : Layer2Row(kMapped) {}
  bool is_job() const override { return false; }
  void give(Giver giver) override {
    std::uint8_t byte = value_of(giver);
    layer2_ImageOutputs sample = {};
    sample.address = static_cast<std::uint16_t>(index(giver));
    sample.data._buffer = &byte;
    sample.data._length = sample.data._maximum = 1;
    program(giver).give(sample);
  }
  void end(Giver giver) override {
    layer2_ImageOutputs sample = {};
    sample.given_up = true;
    program(giver).give(sample);
  }
  std::string on_bus() override { return image(); }
  std::string told() override {
    return ownership_word(watcher().newest<layer2_FrameStatus>().image_ownership);
  }
};

/// Outputs of the process image, by a request.
class OutputsByRequest final : public Layer2Row {
 public:
  OutputsByRequest() : Layer2Row(kMapped) {}
  bool is_job() const override { return false; }
  void give(Giver giver) override { write_image(program(giver), value_of(giver)); }
  /// There is no end of its own: it writes what is harmless.
  void end(Giver giver) override { write_image(program(giver), 0); }
  std::string on_bus() override { return image(); }
  void collect() override { collect_answers<layer2_ControlReply>(); }
};

/// Leadership of run and stop.
class RunLead final : public Layer2Row {
 public:
  RunLead() : Layer2Row(kMapped + "[module]\nrun_follows = \"line\"\n") {}
  bool is_job() const override { return false; }
  void give(Giver giver) override { lead(giver, true); }
  void end(Giver giver) override { lead(giver, false); }
  /// The image that is written to see whether it is sent.
  bool is_noise(const std::string& code) const override { return code == "requests_rejected"; }
  /// Who says stop has it still.
  void leave(Giver giver) override { kill(giver); }
  /// In run the image is sent that somebody has written.
  std::string on_bus() override {
    write_image(watcher(), 1);
    let_it_be_seen();  // before what comes next, which may refuse it
    const std::string seen = image();
    return seen == "first" ? "runs" : seen;
  }
  std::string told() override {
    return ownership_word(watcher().newest<layer2_FrameStatus>().run_lead_ownership);
  }

 private:
  void lead(Giver giver, bool run) {
    layer2_RunLead sample = {};
    gateway::dds::copy_text("line", sample.client_name);
    sample.run = run;
    program(giver).give(sample);
  }
};

/// A mapping.
class Mapping final : public Layer2Row {
 public:
  bool is_job() const override { return false; }
  void give(Giver giver) override {
    configure(program(giver), "[mapping]\ninterval_ms = 10\n[[mapped]]\nnumber = 0\nidentifier = " +
                                  std::to_string(kIdentifier + value_of(giver)) +
                                  "\nsize = 1\noutput = true\n");
    run(milliseconds(10));
    write_image(watcher(), 1);
  }
  void end(Giver giver) override { configure(program(giver), "[mapping]\n"); }
  std::string on_bus() override {
    return frames([](const can::Frame& frame) {
      return frame.id > kIdentifier && frame.id <= kIdentifier + 2
                 ? whose(static_cast<std::uint8_t>(frame.id - kIdentifier))
                 : std::string();
    });
  }
  void collect() override { collect_answers<layer2_ControlReply>(); }

 private:
  static constexpr std::uint32_t kIdentifier = 0x300;
};

/// A timer that runs.
class Timer final : public Layer2Row {
 public:
  Timer() : Layer2Row({}, "[[timer]]\nnumber = 1\nidentifier = 0x70\n") {}
  bool is_job() const override { return false; }
  void give(Giver giver) override {
    layer2_ControlRequest request = {};
    request.kind = layer2_CONTROL_SET_TIMER;
    request.number = 1;
    request.content = frame_of(kIdentifier, value_of(giver));
    request.period = 10'000;
    request.cyclic = true;
    (void)program(giver).ask<layer2_ControlReply>(request);
    control(program(giver), layer2_CONTROL_START_TIMER, 1);
  }
  void end(Giver giver) override { control(program(giver), layer2_CONTROL_STOP_TIMER, 1); }
  std::string on_bus() override { return frames_of(kIdentifier); }
  void collect() override { collect_answers<layer2_ControlReply>(); }

 private:
  static constexpr std::uint32_t kIdentifier = 0x80;
};

/// A frame.
class FrameJob final : public Layer2Row {
 public:
  FrameJob() : Layer2Row({}, "[send]\nqueue = 2\n") {}
  bool is_job() const override { return true; }
  void give(Giver giver) override {
    layer2_SendRequest request = {};
    request.content = frame_of(kIdentifier, value_of(giver));
    request.timeout = 2000;
    const std::uint64_t number = program(giver).ask<layer2_SendReply>(request);
    if (giver == Giver::first) newest_ = number;
  }
  void end(Giver giver) override { program(giver).cancel(newest_); }
  std::string on_bus() override { return frames_of(kIdentifier); }
  void collect() override { collect_answers<layer2_SendReply>(); }

 private:
  static constexpr std::uint32_t kIdentifier = 0x400;
  std::uint64_t newest_ = 0;
};

/// Objects that send.
const std::string kObjects =
    "[[object]]\nnumber = 1\ntransmit = true\nidentifier = 0x500\ntimeout_ms = 2000\n";

/// A frame of a message object.
class ObjectJob : public Layer2Row {
 public:
  explicit ObjectJob(bool held = false)
      : Layer2Row(kObjects, "[[object]]\nnumber = 2\nidentifier = 0x500\n"), held_(held) {}
  bool is_job() const override { return !held_; }
  void give(Giver giver) override {
    layer2_ObjectRequest request = {};
    request.action = layer2_OBJECT_SEND;
    request.number = 1;
    request.content = frame_of(kIdentifier, value_of(giver));
    request.on_remote = request.every_time = held_;
    (void)program(giver).ask<layer2_ObjectReply>(request);
  }
  void end(Giver giver) override {
    layer2_ObjectRequest request = {};
    request.action = layer2_OBJECT_ABORT;
    request.number = 1;
    (void)program(giver).ask<layer2_ObjectReply>(request);
  }
  std::string on_bus() override { return frames_of(kIdentifier); }
  void collect() override { collect_answers<layer2_ObjectReply>(); }

 protected:
  static constexpr std::uint32_t kIdentifier = 0x500;

 private:
  const bool held_;
};

/// A frame that an object holds for whoever asks.
class HeldObject final : public ObjectJob {
 public:
  HeldObject() : ObjectJob(true) {}
  /// Somebody asks every 20 ms.
  void each_step() override {
    if (++steps_ % 2 == 1) return;
    can::Frame asks;
    asks.id = kIdentifier;
    asks.remote = true;
    asks.dlc = 1;
    bus().bring(asks);
  }

 private:
  unsigned steps_ = 0;
};

}  // namespace

void add_layer2_rows(Rows& rows) {
  rows.add<Outputs>("layer2.outputs");
  rows.add<OutputsByRequest>("layer2.outputs_by_request");
  rows.add<RunLead>("layer2.run_lead");
  rows.add<Mapping>("layer2.mapping");
  rows.add<Timer>("layer2.timer");
  rows.add<FrameJob>("layer2.frame");
  rows.add<ObjectJob>("layer2.object");
  rows.add<HeldObject>("layer2.held_object");
}

}  // namespace given
