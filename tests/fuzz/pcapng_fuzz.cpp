// Captures (lib/can/pcapng_reader.h): whole or byte by byte they give the same, and no more than they hold.
#include <utility>
#include <vector>

#include "bounded.h"
#include "bytes.h"
#include "can/pcapng_reader.h"
#include "require.h"

namespace {

using fuzz::require;

constexpr std::size_t kSmallestBlock = 12;  // bytes

struct Found {
  std::vector<can::CandumpLine> frames;
  std::vector<std::string> problems;
  bool fatal = false;
};

void take(can::PcapngReader& reader, Found& found) {
  while (auto item = reader.next()) {
    require(!found.fatal, "nothing comes after a fatal problem");
    if (auto* frame = std::get_if<can::CandumpLine>(&*item)) {
      require(frame->frame.dlc <= 8, "no more than 8 data bytes");
      found.frames.push_back(std::move(*frame));
    } else {
      auto& error = std::get<can::PcapngError>(*item);
      require(!error.message.empty(), "a problem is told");
      found.fatal = error.fatal;
      found.problems.push_back(std::move(error.message));
    }
  }
}

Found read(std::string_view capture, std::size_t piece) {
  can::PcapngReader reader;
  Found found;
  for (std::size_t at = 0; at < capture.size(); at += piece) {
    reader.feed(capture.substr(at, piece));
    take(reader, found);
  }
  return found;
}

bool same(const can::CandumpLine& a, const can::CandumpLine& b) {
  return a.time == b.time && a.interface == b.interface && a.frame == b.frame;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string capture = fuzz::text_of(data, size);
  const Found whole = fuzz::bounded(size, fuzz::kOfText, [&] { return read(capture, size + 1); });
  require((whole.frames.size() + whole.problems.size()) * kSmallestBlock <= size + kSmallestBlock,
          "a block gives one thing at most");
  const Found pieces = read(capture, 1);
  require(whole.problems == pieces.problems && whole.frames.size() == pieces.frames.size(),
          "pieces are the same");
  for (std::size_t i = 0; i < whole.frames.size(); ++i)
    require(same(whole.frames[i], pieces.frames[i]), "frames of pieces are the same");
  return 0;
}
