#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cansync/channel/jobs.h"
#include "cansync/sim/drive.h"
#include "dice.h"

namespace cansyncd::campaign {

/// What the memories of the drives hold, and the data of every transfer. Each memory is divided into places;
/// a place has at most one transfer at a time, so that what it must hold is known.
class MemoryTruth {
 public:
  static constexpr std::size_t kPlaces = 4;
  static constexpr std::uint32_t kPlaceBytes = 1024;

  /// Fills the drive's memory with random bytes and watches it.
  void watch(sim::Drive& drive, Dice& dice);

  /// A transfer of `bytes` (up to kPlaceBytes) with a free place of the slave; nothing when all are in use.
  /// The data stays valid as long as this object.
  std::optional<cansync::TransferRequest> draw(cansync::JobId id, cansync::SlaveNumber slave, bool download,
                                               std::uint32_t bytes, std::uint8_t address_step, Dice& dice);

  /// What the drive has of an open download.
  struct Facts {
    bool has_all = false;    ///< every byte
    bool untouched = false;  ///< the memory is as it was
  };
  /// Nothing when the transfer is not open.
  std::optional<Facts> facts(cansync::JobId id, const sim::Drive& drive) const;

  /// The transfer ended in interval `now`; `refused`: it was not taken at all.
  void answered(cansync::JobId id, const cansync::TransferResult& result, bool refused,
                const sim::Drive& drive, std::uint64_t now);

  /// Notes when the drive's memory holds what it cannot, in interval `now`. `calm`: no telegram is held up.
  void look(const sim::Drive& drive, std::uint64_t now, bool calm);

  /// What was wrong first; empty: nothing.
  const std::string& complaint() const noexcept { return complaint_; }

 private:
  using Bytes = std::vector<std::uint8_t>;
  struct Place {
    bool used = false;
    std::uint64_t settled = 0;     ///< from this interval on nothing of the last transfer is under way
    std::optional<Bytes> written;  ///< a download that may have come in parts: what it would write
  };
  struct Memory {
    Bytes held;
    std::array<Place, kPlaces> places = {};
  };
  struct Transfer {
    std::unique_ptr<Bytes> data;  ///< what the master works with
    Bytes given;                  ///< download: what the client gave
    unsigned slave = 0;
    std::size_t place = 0;
    bool download = false;
  };

  void check_end(const Transfer& transfer, const cansync::TransferResult& result, const sim::Drive& drive,
                 cansync::JobId id);
  void put_away(cansync::JobId id, Transfer transfer);
  void complain(std::string text) {
    if (complaint_.empty()) complaint_ = std::move(text);
  }

  std::map<unsigned, Memory> memories_;
  std::map<cansync::JobId, Transfer> open_;
  std::deque<std::pair<cansync::JobId, Transfer>> ended_;  ///< the last ones, whose data nobody may touch
  std::string complaint_;
};

}  // namespace cansyncd::campaign
