#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cansync/channel/jobs.h"
#include "cansync/sim/drive.h"

namespace cansyncd::campaign {

/// What the parameters of the drives can hold after everything the clients were told.
class ParameterTruth {
 public:
  /// Numbers that clients write: words, doublewords, and one that answers busy first.
  static constexpr std::uint16_t kWritten[] = {1000, 1001, 1002, 1020, 1021, 1022, 410};

  /// A drive of this number is watched; again after it was switched off and on.
  void powered_on(const sim::Drive& drive);

  void pushed(const cansync::ParameterRequest& request);
  /// `doubtful`: an answer to an earlier request may have been taken for the answer to this one, because the
  /// protocol cannot tell them apart.
  void answered(const cansync::ParameterRequest& request, const cansync::ParameterResult& result,
                bool doubtful);
  void refused(const cansync::ParameterRequest& request);

  /// Notes when a parameter of the drive holds what it cannot.
  void look(const sim::Drive& drive);

  /// What was wrong first; empty: nothing.
  const std::string& complaint() const noexcept { return complaint_; }

 private:
  using Key = std::pair<unsigned, unsigned>;  // slave, number
  struct Cell {
    std::vector<std::uint32_t> held;    ///< what it may hold by what has been answered
    std::vector<std::uint32_t> past;    ///< what it held before
    std::vector<std::uint32_t> unsure;  ///< writes without a result since the last one that is done
    std::vector<std::pair<cansync::JobId, std::uint32_t>> open;  ///< writes without an answer
    cansync::JobId before_power_on = 0;  ///< writes up to this one may have been done and undone
  };

  Cell* cell(const cansync::ParameterRequest& request);
  void check_read(const cansync::ParameterRequest& request, const cansync::ParameterResult& result,
                  bool doubtful);
  void complain(std::string text) {
    if (complaint_.empty()) complaint_ = std::move(text);
  }

  std::map<Key, Cell> cells_;
  cansync::JobId last_pushed_ = 0;
  std::map<cansync::JobId, std::vector<std::uint32_t>> reads_;  ///< what each open read may give
  std::string complaint_;
};

}  // namespace cansyncd::campaign
