#pragma once

#include <cstdint>
#include <vector>

#include "can/bus.h"
#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/reference_gate.h"
#include "sync/sync_wire.h"

namespace cansyncd::campaign {

struct Said;

/// Stands between the loop and everything it touches, and changes nothing: what breaks a variant of the
/// product on purpose derives from it.
class Tamper : public can::Bus, public sync_line::SyncWire {
 public:
  /// The bus below and its wire; must outlive the object.
  void attach(can::Bus& below, sync_line::SyncWire& wire) noexcept {
    below_ = &below;
    wire_ = &wire;
  }

  can::Time now() noexcept override { return below_->now(); }
  can::Wake wait_until(can::Time deadline) noexcept override { return below_->wait_until(deadline); }
  bool receive(can::ReceivedFrame& out) noexcept override { return below_->receive(out); }
  can::SendResult send(const can::Frame& frame) noexcept override { return below_->send(frame); }
  void sync_edge(can::Time due) noexcept override { wire_->sync_edge(due); }
  can::ControllerStatus status() noexcept override { return below_->status(); }
  can::ResetResult reset() noexcept override { return below_->reset(); }
  can::ResetResult reset_result() noexcept override { return below_->reset_result(); }
  can::TimestampSource timestamp_source() noexcept override { return below_->timestamp_source(); }

  /// What the master is made with.
  virtual cansync::MasterSettings settings(const cansync::MasterSettings& of_plan) { return of_plan; }

  /// What the daemon does when another master has gone.
  virtual AfterOtherMaster after_other_master(AfterOtherMaster of_plan) { return of_plan; }

  /// What the gateway is about to read; may be changed.
  virtual void terminals(std::vector<Terminal>& /*popped*/) {}
  virtual void snapshot(MasterSnapshot& /*snapshot*/) {}
  /// What is said of a request that has ended; may be changed.
  virtual void said(Said& /*said*/) {}
  /// The audit trail keeps what this has read or changed.
  virtual bool remembers(const Request& /*request*/) { return true; }
  /// `fresh`: the master has written the report in this interval. Returns whether the gateway sees it.
  virtual bool actual(ActualReport& /*report*/, bool fresh) { return fresh; }

  /// A sample that the gate is about to look at, in this start of the daemon.
  virtual void sample(ReferenceSample& /*sample*/, const DaemonIdentity& /*start*/) {}
  /// The strength of a writer that is not the owner, as the gate hears of it.
  virtual void strength(std::int32_t& /*strength*/) {}
  /// What the gate hands on. True: it does not arrive.
  virtual void update(cansync::ReferenceUpdate& /*update*/) {}
  virtual bool swallows(const StopRelease& /*stop*/) { return false; }
  /// True: the control word is handed on so many intervals later.
  virtual std::uint64_t held_back(const cansync::ControlWordRequest& /*request*/) { return 0; }

 protected:
  can::Bus& below() noexcept { return *below_; }
  sync_line::SyncWire& wire() noexcept { return *wire_; }

 private:
  can::Bus* below_ = nullptr;
  sync_line::SyncWire* wire_ = nullptr;
};

}  // namespace cansyncd::campaign
