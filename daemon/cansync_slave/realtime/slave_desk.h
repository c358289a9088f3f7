#pragma once

#include <cstdint>
#include <optional>

#include "cansync/slave/slave_service.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/loop/moment.h"

namespace cansyncd {

/// What stands behind the slave on the realtime thread: the status word, the parameter table, and the way to
/// the application and back. Realtime safe after its construction.
class SlaveDesk final : private cansync::SlaveServiceListener {
 public:
  /// `service`: its table has `parameter`, the number of the status word; `bits`: that word's bits 0..14.
  /// `exchange` must outlive the desk.
  SlaveDesk(const cansync::SlaveServiceSettings& service, std::uint16_t parameter, std::uint16_t bits,
            SlaveExchange& exchange);

  /// What the slave asks.
  cansync::SlaveApplication& application() noexcept { return service_; }

  /// Bit 15 of the status word.
  void set_synchronized(bool synchronized) noexcept;
  /// As the master reads it.
  std::uint16_t status_word() const noexcept;
  /// What the action was that came last, and forgets it; nothing: none has come.
  std::optional<SlaveAction> take_action() noexcept;

  /// Tells when what comes now happens.
  void at(const Moment& when) noexcept { now_ = when; }
  /// Takes what the application has answered, and looks whose time is over.
  void take_orders(can::Time now) noexcept;
  /// Something was told to the gateway since the last call.
  bool take_told() noexcept;
  const ServiceCounters& counters() const noexcept { return counters_; }

 private:
  void take(const TakeOver& order) noexcept;
  void take(const JobAnswer& order) noexcept;
  void take(const BlockReply& order) noexcept;
  void tell(const ServiceReport& report) noexcept;

  void asked(const cansync::AskedParameter& job) noexcept override;
  void dropped(std::uint64_t id) noexcept override;
  void answered(std::uint64_t id) noexcept override;
  void block_begun(const cansync::AskedBlock& block) noexcept override;
  void block_complete(std::uint64_t id) noexcept override;
  void step_asked(std::uint64_t id, const cansync::AskedStep& step) noexcept override;
  void block_ended(std::uint64_t id, cansync::BlockEnd end) noexcept override;
  void sync_activated() noexcept override { action_ = SlaveAction::sync_mode; }
  void control_word(std::uint16_t) noexcept override { action_ = SlaveAction::control_word; }
  void action(std::uint8_t, std::uint8_t, std::uint16_t) noexcept override { action_ = SlaveAction::user; }

  const std::uint16_t parameter_;
  const std::uint16_t bits_;
  SlaveExchange& exchange_;
  cansync::SlaveService service_;
  Moment now_;
  bool told_ = false;
  ServiceCounters counters_;
  std::optional<SlaveAction> action_;
};

}  // namespace cansyncd
