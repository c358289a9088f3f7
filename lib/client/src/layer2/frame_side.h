#pragma once

#include <cansync/client.h>
#include <cansync/frame_connection.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can/frame.h"
#include "client/src/layer2/direct_access.h"
#include "client/src/layer2/module_queues.h"
#include "client/src/layer2/saia_queues.h"
#include "client/src/open_requests.h"
#include "layer2/client/frame_client.h"
#include "layer2/client/image_writer.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// What a connection to the daemon of general frames has told so far, and what its function blocks send. One
/// thread.
class FrameSide {
 public:
  using Result = layer2::client::SendResult;
  using Ended = std::function<void(const Result&)>;

  /// Waits for the daemon and its first status. Throws as FrameConnection::connect.
  explicit FrameSide(const Options& options);
  /// Ends the mapping that the program has set up; waits for the daemon's answer, 0.5 s at most.
  ~FrameSide();
  FrameSide(const FrameSide&) = delete;
  FrameSide& operator=(const FrameSide&) = delete;

  /// Takes what has come, and hands on what waits. Never waits for an answer.
  void look();

  /// Why nothing can be sent now; empty: it can.
  std::string obstacle() const;
  /// STAT (Helmholz 7.2.5).
  std::uint16_t status_word();
  /// What the daemon says of its controller.
  layer2::StatusFacts controller() { return facts(); }
  /// bit/s, as the daemon is configured; 0: it has not told yet.
  std::uint32_t bit_rate();
  /// True once after another daemon came.
  bool take_restart() noexcept { return std::exchange(restarted_, false); }

  /// The daemon is asked; `ended` is called once. False: it is not, `problem` says why.
  bool control(const layer2_ControlRequest& wanted, Ended ended);
  const std::string& problem() const noexcept { return open_.problem(); }
  /// No more can be asked before something has ended.
  bool full() const noexcept { return open_.full(); }

  ModuleQueues<can::Frame>& queues() noexcept { return queues_; }
  /// The queues of the Basic Services.
  SaiaQueues& basic() noexcept { return basic_; }
  /// The message objects.
  DirectAccess& objects() noexcept { return objects_; }
  /// A daemon is there, and has told of its frames.
  bool daemon_present() const noexcept {
    return client_.daemon_present() && client_.newest_status().has_value();
  }
  /// Why the frame that failed last was not sent; empty: none has.
  const std::string& failure() const noexcept { return failure_; }
  /// Frames that were taken and are known not to have been sent.
  std::uint32_t failures() const noexcept { return failures_; }

  /// SFB 403 was called: what other blocks set up is taken back. `receive`, `send`: of the message objects.
  struct Beginning {
    QueueInterrupt receive;
    QueueInterrupt send;
  };
  void begin_anew(const Beginning& beginning);
  bool begun() const noexcept { return beginning_.has_value(); }
  /// As SFB 403 was called.
  const Beginning& beginning() const noexcept { return *beginning_; }

  /// Data blocks of the program.
  void load_data_block(int number, std::vector<std::uint8_t> bytes) {
    data_blocks_[number] = std::move(bytes);
  }
  /// Nothing: it is not loaded.
  const std::vector<std::uint8_t>* data_block(int number) const;

  /// A data mapping, as sections of the daemon's file.
  struct Mapping {
    std::string toml;
    bool entries = false;  ///< it has some
    Ended ended;           ///< called once
  };
  /// The daemon is asked for it, after the one before. False: it is not, `problem` says why.
  bool map(Mapping wanted);
  /// The object belongs to the mapping, or to the queues (Saia 3.5).
  bool reserved(unsigned number) const noexcept;
  /// What came by the process image.
  std::span<const std::uint8_t, 1024> inputs() const noexcept { return inputs_; }
  /// Why bytes were not written to the process image; empty: they were.
  std::string write_outputs(std::uint16_t address, std::span<const std::uint8_t> bytes);
  /// Error frames and frames that nobody acknowledged, since the daemon's start.
  std::uint64_t error_count();

  /// The routine of an organisation block, if there is one, is called.
  void interrupt(int routine, const Interrupt& interrupt) const;
  void set_routine(int number, std::function<void(const Interrupt&)> routine);

 private:
  /// As [mapping] with nothing in it.
  static constexpr std::string_view kNoMapping = "[mapping]\n";

  void note(const layer2_FrameBatch& batch);
  void hand_over();
  bool begin(const can::Frame& frame, const layer2::client::SendChoice& choice, Ended ended);
  void interrupt_of_object(unsigned number, bool transmit) const;
  /// `entries`: the mapping that ends to be asked for had some.
  void end_mapping(const Result& result, bool entries);
  void note_failure(const Result& result);
  layer2::StatusFacts facts();

  layer2::client::FrameClient client_;
  OpenRequests<layer2::client::FrameClient, Result> open_;
  ModuleQueues<can::Frame> queues_;
  SaiaQueues basic_;
  DirectAccess objects_;
  bool mapped_ = false;    ///< the mapping asked for last is there or under way
  bool in_force_ = false;  ///< the daemon may have one of this program, and drives outputs by it
  bool mapping_under_way_ = false;
  std::optional<Mapping> next_mapping_;
  std::optional<layer2::client::ImageWriter> outputs_;
  std::array<std::uint8_t, 1024> inputs_ = {};
  std::map<int, std::vector<std::uint8_t>> data_blocks_;
  std::optional<Beginning> beginning_;
  std::map<int, std::function<void(const Interrupt&)>> routines_;
  std::uint64_t batch_ = 0;
  std::uint64_t lost_ = 0;
  bool restarted_ = false;
  std::string failure_;
  std::uint32_t failures_ = 0;
};

}  // namespace cansync::client::detail
