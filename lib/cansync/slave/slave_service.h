#pragma once

#include <span>
#include <vector>

#include "cansync/slave/block_area.h"
#include "cansync/slave/parameter_jobs.h"
#include "cansync/slave/parameter_table.h"
#include "cansync/slave/slave.h"

namespace cansync {

/// Is told of everything that the master wants of a slave. Called on the slave's thread; must not allocate,
/// block or throw, nor call back.
class SlaveServiceListener : public ParameterJobsListener, public BlockAreaListener {
 public:
  /// A control word arrived (M 3.2.3.7).
  virtual void control_word(std::uint16_t word) noexcept = 0;
  /// Any other action arrived, also that of "SYNC mode" with other data than "activate".
  virtual void action(std::uint8_t command, std::uint8_t data_byte, std::uint16_t data_word) noexcept = 0;
  /// The action "SYNC mode: activate" arrived, for the first time or again.
  virtual void sync_activated() noexcept = 0;
};

/// How a slave serves its master.
struct SlaveServiceSettings {
  std::vector<ParameterDefinition> parameters;
  ParameterJobsSettings jobs;
  BlockAreaSettings area;
};

/// What stands behind a slave whose application lives elsewhere, in a PLC or another process: the parameter
/// table, its jobs, the block area. Nothing allocates, blocks or throws after construction; not thread safe.
class SlaveService final : public SlaveApplication {
 public:
  /// `listener` must outlive the service.
  SlaveService(const SlaveServiceSettings& settings, SlaveServiceListener& listener)
      : listener_(listener),
        table_(settings.parameters),
        jobs_(settings.jobs, table_, listener),
        area_(settings.area, listener) {}

  /// There is an application (its lease runs), or there is none (any more).
  void set_application(bool present) noexcept {
    jobs_.set_application(present);
    area_.set_application(present);
  }

  /// What the slave answers by itself.
  ParameterTable& table() noexcept { return table_; }
  const ParameterTable& table() const noexcept { return table_; }
  /// The access that waits for the application.
  ParameterJobs& jobs() noexcept { return jobs_; }
  /// The block that waits for the application.
  BlockArea& area() noexcept { return area_; }

 private:
  // What the slave asks.
  ParameterAnswer read_parameter(ParameterNumber number, Element element, SubSlave sub) noexcept override {
    return jobs_.read(number, element, sub);
  }
  ParameterAnswer write_parameter(ParameterNumber number, Element element, SubSlave sub, bool doubleword,
                                  std::uint32_t value) noexcept override {
    return jobs_.write(number, element, sub, doubleword, value);
  }
  void parameter_dropped() noexcept override { jobs_.dropped(); }
  bool keeps_answer() noexcept override { return jobs_.keeps_answer(); }
  void parameter_answered() noexcept override { jobs_.sent(); }
  BlockAnswer begin_block(const TransferInitialise& initialise) noexcept override {
    return area_.begin(initialise);
  }
  bool block_open() const noexcept override { return area_.open().id != 0; }
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override {
    return area_.read(offset, out);
  }
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override {
    return area_.write(offset, data);
  }
  void end_block(bool complete) noexcept override { area_.end(complete); }
  void transfer_answered() noexcept override { area_.sent(); }
  void transfer_dropped() noexcept override { area_.dropped(); }
  void sync_activated() noexcept override { listener_.sync_activated(); }
  void control_word(std::uint16_t word) noexcept override { listener_.control_word(word); }
  void action(std::uint8_t command, std::uint8_t data_byte, std::uint16_t data_word) noexcept override {
    listener_.action(command, data_byte, data_word);
  }

  SlaveServiceListener& listener_;
  ParameterTable table_;
  ParameterJobs jobs_;
  BlockArea area_;
};

}  // namespace cansync
