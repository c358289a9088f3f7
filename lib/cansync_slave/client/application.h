#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cansync_slave.h"
#include "cansync_slave/client/slave_client.h"
#include "dds/endpoint.h"
#include "dds/guard/writer_guid.h"

namespace cansync_slave::client {

/// Is the value whole in its low word, without a sign or with one (-32768..65535)?
constexpr bool fits_word(std::uint32_t value) noexcept {
  return value <= 0xFFFF || value >= 0xFFFF8000;
}

/// What a program takes over of the slave.
struct Duties {
  std::vector<std::uint16_t> parameters;  ///< numbers, 0..4095
  bool sub_slaves = false;                ///< and every parameter of sub-slaves over 0
  bool blocks = false;                    ///< and uploads and downloads
};

/// The application behind the slave: what it has taken over the master is answered by it, through
/// `SlaveClient::Listener::parameter_job` and `block_job` and the functions below. While it thinks, the
/// master is told that it takes longer. Every function returns what failed; empty: it was handed to DDS. An
/// answer to what is not open any more is dropped by the daemon. One thread.
class Application {
 public:
  /// `strength`: 0 and more, or gateway::dds::kTakeOver. There is one application at a time, until it gives
  /// everything back, is lost, or a stronger one comes; others wait and become it afterwards. `client` must
  /// outlive the application. Throws gateway::dds::SetupError.
  Application(SlaveClient& client, Duties duties, std::int32_t strength);

  /// Gives everything back.
  ~Application();
  Application(const Application&) = delete;
  Application& operator=(const Application&) = delete;

  /// Takes over other things from now on. What is open of before stays open.
  std::string take_over(Duties duties);

  /// Says that the application is there, when that is due: to be called at least every half second. A
  /// program that stands still longer than two seconds is none any more. Says nothing while another program is
  /// the application that is no weaker, nor before the jobs of the daemon reach this program.
  std::string keep();

  /// True for a job that the daemon has given to this application, also of its end: an answer to another one
  /// counts for nothing, and what another application answers is not for this one to apply. A daemon of a data
  /// model before 8 does not say whose a job is: then every job is.
  template <class Job>
  bool is_asked(const Job& job) const noexcept {
    const gateway::dds::WriterGuid asked = gateway::dds::application_of(job);
    return asked == gateway::dds::WriterGuid{} || asked == guid_;
  }
  /// True while `status` names this application as the one that the daemon asks.
  bool is_application(const cansync_slave_SlaveSideStatus& status) const noexcept;

  /// A write is done, or a read has this raw value in this format.
  std::string answer(const cansync_slave_ParameterJob& job, std::uint32_t value = 0, bool doubleword = false);
  /// The access fails with an error number (M 3.2.3.7).
  std::string refuse(const cansync_slave_ParameterJob& job, std::uint16_t error);

  /// BLOCK_BEGUN: the block may be moved. An upload that goes as a whole brings all of its data, 1..300
  /// bytes; one that does not may fix its length, 0: as asked.
  std::string allow(const cansync_slave_BlockJob& job, std::span<const std::uint8_t> upload = {},
                    std::uint16_t length = 0);
  /// BLOCK_COMPLETE: the data were taken.
  std::string take(const cansync_slave_BlockJob& job);
  /// BLOCK_TELEGRAM: done; of an upload with as many bytes as were asked for.
  std::string step(const cansync_slave_BlockJob& job, std::span<const std::uint8_t> upload = {});
  /// The block fails with an error number, 0x0100 and over (M 3.2.3.7).
  std::string refuse(const cansync_slave_BlockJob& job, std::uint16_t error);

 private:
  using Sample = cansync_slave_ApplicationAnswer;

  std::string write(Sample& sample, std::span<const std::uint8_t> data = {});

  SlaveClient& client_;
  Duties duties_;
  const std::int32_t strength_;
  gateway::dds::Writer<Sample> writer_;
  gateway::dds::WriterGuid guid_;
  std::uint32_t daemons_ = 0;  ///< readers, when it was said last
  std::optional<std::chrono::steady_clock::time_point> said_;
};

}  // namespace cansync_slave::client
