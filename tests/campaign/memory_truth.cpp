#include "memory_truth.h"

#include <algorithm>
#include <utility>

#include "plan.h"

namespace cansyncd::campaign {
namespace {

constexpr std::size_t kEndedKept = 8;
/// A telegram of a transfer that has ended may be on its way for so long.
constexpr std::uint64_t kSettling = kLatestIntervals + 6;

/// It says that the drive has nothing of the download.
bool nothing_written(cansync::Outcome outcome) {
  using cansync::Outcome;
  return outcome == Outcome::cancelled || outcome == Outcome::master_stopped ||
         outcome == Outcome::slave_lost || outcome == Outcome::timeout;
}

std::string transfer_text(cansync::JobId id) {
  return "transfer " + std::to_string(id);
}

}  // namespace

void MemoryTruth::watch(sim::Drive& drive, Dice& dice) {
  Memory& memory = memories_[drive.number().value()];
  for (std::uint8_t& byte : drive.memory().contents()) byte = static_cast<std::uint8_t>(dice.next());
  const auto contents = drive.memory().contents();
  memory.held.assign(contents.begin(), contents.end());
}

std::optional<cansync::TransferRequest> MemoryTruth::draw(cansync::JobId id, cansync::SlaveNumber slave,
                                                          bool download, std::uint32_t bytes,
                                                          std::uint8_t address_step, Dice& dice) {
  Memory& memory = memories_.at(slave.value());
  const std::size_t place = dice.below(kPlaces);
  if (memory.places[place].used || memory.places[place].written) return std::nullopt;
  memory.places[place].used = true;
  Transfer transfer;
  transfer.data = std::make_unique<Bytes>(bytes);
  for (std::uint8_t& byte : *transfer.data) byte = static_cast<std::uint8_t>(dice.next());
  transfer.given = *transfer.data;
  transfer.slave = slave.value();
  transfer.place = place;
  transfer.download = download;
  cansync::TransferRequest request;
  request.id = id;
  request.direction =
      download ? cansync::TransferRequest::Direction::download : cansync::TransferRequest::Direction::upload;
  request.slave = slave;
  request.address = static_cast<std::uint32_t>(sim::kFirstAddress + place * kPlaceBytes / address_step);
  request.data = *transfer.data;
  open_.emplace(id, std::move(transfer));
  return request;
}

std::optional<MemoryTruth::Facts> MemoryTruth::facts(cansync::JobId id, const sim::Drive& drive) const {
  const auto found = open_.find(id);
  if (found == open_.end()) return std::nullopt;
  const Transfer& transfer = found->second;
  const auto contents = drive.memory().contents().subspan(transfer.place * kPlaceBytes, kPlaceBytes);
  const auto held =
      memories_.at(transfer.slave).held.begin() + static_cast<std::ptrdiff_t>(transfer.place * kPlaceBytes);
  return Facts{std::equal(transfer.given.begin(), transfer.given.end(), contents.begin()),
               std::equal(contents.begin(), contents.end(), held)};
}

void MemoryTruth::check_end(const Transfer& transfer, const cansync::TransferResult& result,
                            const sim::Drive& drive, cansync::JobId id) {
  const auto contents = drive.memory().contents().subspan(transfer.place * kPlaceBytes);
  const Bytes& data = *transfer.data;
  if (result.bytes > data.size()) {
    complain(transfer_text(id) + " moved " + std::to_string(result.bytes) + " of " +
             std::to_string(data.size()) + " bytes");
    return;
  }
  if (transfer.download && data != transfer.given) {
    complain(transfer_text(id) + " has changed the data it was given");
  }
  if (result.outcome != cansync::Outcome::done) return;
  if (transfer.download && result.bytes != data.size()) {
    complain(transfer_text(id) + " is done with " + std::to_string(result.bytes) + " of " +
             std::to_string(data.size()) + " bytes");
  }
  const auto differs = std::mismatch(data.begin(), data.begin() + result.bytes, contents.begin());
  if (differs.first != data.begin() + result.bytes) {
    complain(transfer_text(id) + " is done, and byte " + std::to_string(differs.first - data.begin()) +
             " is not what stands in the memory");
  }
}

void MemoryTruth::answered(cansync::JobId id, const cansync::TransferResult& result, bool refused,
                           const sim::Drive& drive, std::uint64_t now) {
  const auto found = open_.find(id);
  if (found == open_.end()) return;
  Transfer transfer = std::move(found->second);
  open_.erase(found);
  Memory& memory = memories_.at(transfer.slave);
  Place& place = memory.places[transfer.place];
  place.used = false;
  if (!refused) {
    check_end(transfer, result, drive, id);
    const auto held = memory.held.begin() + static_cast<std::ptrdiff_t>(transfer.place * kPlaceBytes);
    if (transfer.download && result.outcome == cansync::Outcome::done) {
      std::copy(transfer.given.begin(), transfer.given.end(), held);
    } else if (transfer.download && !nothing_written(result.outcome)) {
      place.written = transfer.given;
      place.settled = now + kSettling;
    }
  }
  put_away(id, std::move(transfer));
}

/// The client has its data back: nobody writes there any more.
void MemoryTruth::put_away(cansync::JobId id, Transfer transfer) {
  transfer.given = *transfer.data;
  ended_.emplace_back(id, std::move(transfer));
  if (ended_.size() <= kEndedKept) return;
  if (*ended_.front().second.data != ended_.front().second.given) {
    complain(transfer_text(ended_.front().first) + " has ended, and its data was touched afterwards");
  }
  ended_.pop_front();
}

void MemoryTruth::look(const sim::Drive& drive, std::uint64_t now, bool calm) {
  Memory& memory = memories_.at(drive.number().value());
  const auto contents = drive.memory().contents();
  for (std::size_t number = 0; number < kPlaces; ++number) {
    Place& place = memory.places[number];
    if (place.used) continue;
    const std::size_t first = number * kPlaceBytes;
    for (std::size_t i = first; i < first + kPlaceBytes; ++i) {
      if (contents[i] == memory.held[i]) continue;
      const bool written =
          place.written && i - first < place.written->size() && contents[i] == (*place.written)[i - first];
      if (!written) {
        complain("byte " + std::to_string(i) + " in the memory of slave " +
                 std::to_string(drive.number().value()) + " holds what nobody has written there");
        return;
      }
    }
    if (!place.written || now < place.settled || !calm) continue;
    // Nothing of that download is under way any more: what it has written stays.
    std::copy_n(contents.begin() + static_cast<std::ptrdiff_t>(first), kPlaceBytes,
                memory.held.begin() + static_cast<std::ptrdiff_t>(first));
    place.written.reset();
  }
}

}  // namespace cansyncd::campaign
