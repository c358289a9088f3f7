#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "can/frame_length.h"
#include "cansync/sim/drive.h"
#include "cansync/telegram/telegram.h"
#include "cli/scan/line_port.h"

namespace cansync::cli::support {

/// A line of simulated drives in virtual time, without any SYNC, that keeps every frame it is handed.
class SpyLine final : public LinePort {
 public:
  explicit SpyLine(BitRate rate) : bit_time_(slot_times(rate).bit_time()) {}

  /// A drive with these settings.
  sim::Drive& add(const sim::DriveSettings& settings) {
    drives_.push_back(std::make_unique<sim::Drive>(settings));
    return *drives_.back();
  }

  Duration now() override { return now_; }
  void wait(Duration deadline) override {
    Duration next = std::max(deadline, now_);
    for (const Pending& pending : pending_) next = std::min(next, std::max(pending.at, now_));
    now_ = std::max(next, now_ + Duration{1});
  }
  bool receive(can::Frame& out) override {
    const auto first = std::min_element(pending_.begin(), pending_.end(),
                                        [](const Pending& a, const Pending& b) { return a.at < b.at; });
    if (first == pending_.end() || first->at > now_) return false;
    out = first->frame;
    pending_.erase(first);
    return true;
  }
  can::SocketResult send(const can::Frame& frame) override {
    sent.push_back({now_, frame});
    if (on_sent) on_sent();
    if (result != can::SocketResult::done) return result;
    const Duration end = now_ + can::frame_bits(frame) * bit_time_;
    for (const auto& drive : drives_) {
      if (!drive->accepts(frame)) continue;
      const auto answer = drive->on_frame(frame, end);
      if (!answer) continue;
      note_block(frame, answer->frame);
      pending_.push_back({answer->not_before + can::frame_bits(answer->frame) * bit_time_, answer->frame});
    }
    return result;
  }

  /// Somebody else's frame, now.
  void inject(const can::Frame& frame) { pending_.push_back({now_, frame}); }

  struct Sent {
    Duration at;
    can::Frame frame;
  };
  std::vector<Sent> sent;
  SlaveMask open;  ///< slaves that began an upload which was not closed
  std::function<void()> on_sent;
  can::SocketResult result = can::SocketResult::done;

 private:
  struct Pending {
    Duration at;
    can::Frame frame;
  };
  void note_block(const can::Frame& asked, const can::Frame& answered) {
    const Decoded command = decode(asked);
    const Decoded answer = decode(answered);
    const auto* begin = std::get_if<TransferInitialise>(std::get_if<Telegram>(&command));
    const auto* reply = std::get_if<TransferReply>(std::get_if<Telegram>(&answer));
    if (begin == nullptr || reply == nullptr || reply->error) return;
    open.set(begin->slave, begin->length.value() != 0);
  }

  Duration bit_time_;
  Duration now_ = std::chrono::seconds(100);
  std::vector<std::unique_ptr<sim::Drive>> drives_;
  std::vector<Pending> pending_;
};

}  // namespace cansync::cli::support
