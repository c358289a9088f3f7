#include "can/pcapng_reader.h"

#include <algorithm>

#include "can/pcapng.h"

namespace can {
namespace {

constexpr std::uint32_t kByteOrder = 0x1A2B3C4D;
constexpr std::uint32_t kInterfaceDescription = 1;
constexpr std::uint32_t kObsoletePacket = 2;
constexpr std::uint32_t kSimplePacket = 3;
constexpr std::uint32_t kEnhancedPacket = 6;
constexpr unsigned kLinkTypeCooked = 113;
constexpr unsigned kLinkTypeCooked2 = 276;
constexpr std::size_t kBlockFrame = 12;  // type, and the length before and behind the content
constexpr std::size_t kPseudoHeader = 8;

unsigned byte_of(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]);
}

// Time stamps per second of an if_tsresol byte; nothing when they do not fit.
std::optional<std::uint64_t> units_of(unsigned resolution) {
  const unsigned power = resolution & 0x7F;
  if ((resolution & 0x80) != 0) return power < 63 ? std::optional(std::uint64_t{1} << power) : std::nullopt;
  if (power > 18) return std::nullopt;
  std::uint64_t units = 1;
  for (unsigned i = 0; i < power; ++i) units *= 10;
  return units;
}

// Without a product that does not fit.
std::uint64_t micros_of(std::uint64_t part, std::uint64_t units) {
  if (units <= 1'000'000'000'000) return part * 1'000'000 / units;
  return part / (units / 1'000'000);
}

constexpr std::size_t kClassicPacket = kPseudoHeader + 8;
constexpr std::size_t kFlexiblePacket = kPseudoHeader + 64;

/// The size of a packet tells CAN FD from CAN 2.0; the flag counts where it does not, for kernels leave what they
/// like in the unused bytes of a classic frame.
bool is_flexible(std::string_view packet) {
  if (packet.size() == kClassicPacket) return false;
  return packet.size() == kFlexiblePacket || (packet.size() > 5 && (byte_of(packet, 5) & 0x04) != 0);
}

// The flag that every CAN XL frame has, in the place of the length of the others, which is 64 at most.
bool is_long(std::string_view packet) {
  return packet.size() > 4 && (byte_of(packet, 4) & 0x80) != 0;
}

// The frame of a packet of LINKTYPE_CAN_SOCKETCAN; nothing for one that is cut off.
std::optional<Frame> frame_of(std::string_view packet) {
  if (packet.size() < kPseudoHeader) return std::nullopt;
  const unsigned length = byte_of(packet, 4);
  if (length > 8 || packet.size() - kPseudoHeader < length) return std::nullopt;
  const std::uint32_t id = (byte_of(packet, 0) << 24) | (byte_of(packet, 1) << 16) |
                           (byte_of(packet, 2) << 8) | byte_of(packet, 3);
  Frame frame;
  frame.id = id & kExtendedIdentifierMask;
  frame.dlc = static_cast<std::uint8_t>(length);
  frame.error = (id & 0x20000000) != 0;
  frame.extended = !frame.error && (id & 0x80000000) != 0;
  frame.remote = !frame.error && (id & 0x40000000) != 0;
  if (frame.id != frame.identifier()) return std::nullopt;
  if (frame.remote) return frame;
  for (unsigned i = 0; i < length; ++i)
    frame.data[i] = static_cast<std::uint8_t>(byte_of(packet, kPseudoHeader + i));
  return frame;
}

}  // namespace

bool is_pcapng(std::string_view first_bytes) noexcept {
  return first_bytes.substr(0, 4) == "\n\r\r\n";
}

std::uint16_t PcapngReader::get16(std::string_view at) const noexcept {
  const unsigned value =
      big_endian_ ? (byte_of(at, 0) << 8) | byte_of(at, 1) : byte_of(at, 0) | (byte_of(at, 1) << 8);
  return static_cast<std::uint16_t>(value);
}

std::uint32_t PcapngReader::get32(std::string_view at) const noexcept {
  const std::uint32_t first = get16(at);
  const std::uint32_t second = get16(at.substr(2));
  return big_endian_ ? (first << 16) | second : first | (second << 16);
}

std::optional<PcapngError> PcapngReader::failed(std::string_view what, bool fatal) {
  stopped_ = stopped_ || fatal;
  return PcapngError{"block " + std::to_string(blocks_) + ": " + std::string(what), fatal};
}

std::optional<PcapngReader::Item> PcapngReader::next() {
  while (!stopped_ && waiting() >= (long_block_ != 0 ? 1 : kBlockFrame)) {
    if (long_block_ != 0) {
      if (auto wrong = pass_over()) return *wrong;
      if (long_block_ != 0) break;
      continue;
    }
    const std::string_view rest = std::string_view(buffer_).substr(at_);
    // Reads the same in both byte orders; the next field says which one holds from here on.
    const bool section = is_pcapng(rest);
    if (section) big_endian_ = rest.substr(8, 4) == "\x1A\x2B\x3C\x4D";
    const std::uint32_t length = get32(rest.substr(4));
    if (length < kBlockFrame || length % 4 != 0 || length > (section ? kLongestBlock : kLongestPassedOver)) {
      ++blocks_;
      return failed("length " + std::to_string(length) + "; allowed are 12 to " +
                        std::to_string(kLongestPassedOver) + " in steps of 4. This is no pcapng capture",
                    true);
    }
    if (length > kLongestBlock) {
      ++blocks_;
      long_block_ = length;
      return failed("length " + std::to_string(length) + ", which is over " + std::to_string(kLongestBlock) +
                    "; it is left out");
    }
    if (rest.size() < length) break;
    ++blocks_;
    at_ += length;
    const std::uint32_t type = get32(rest);
    const std::string_view content = rest.substr(8, length - kBlockFrame);
    if (get32(rest.substr(length - 4)) != length) return failed("its two lengths differ", true);
    std::optional<Item> item;
    if (section) item = take_section(content);
    if (type == kInterfaceDescription) item = take_interface(content);
    if (type == kEnhancedPacket) item = take_enhanced_packet(content);
    if (type == kObsoletePacket) item = take_obsolete_packet(content);
    if (type == kSimplePacket) item = take_simple_packet(content);
    if (item) return item;
  }
  buffer_.erase(0, at_);
  at_ = 0;
  return std::nullopt;
}

std::optional<PcapngError> PcapngReader::pass_over() {
  constexpr std::size_t kLength = 4;  // stands behind the content, too
  const std::size_t part = std::min(waiting(), long_block_ - kLength - passed_);
  at_ += part;
  passed_ += part;
  if (waiting() < kLength) return std::nullopt;
  const bool same = get32(std::string_view(buffer_).substr(at_)) == long_block_;
  at_ += kLength;
  long_block_ = passed_ = 0;
  return same ? std::nullopt : failed("its two lengths differ", true);
}

std::optional<PcapngError> PcapngReader::take_section(std::string_view content) {
  if (content.size() < 16 || get32(content) != kByteOrder)
    return failed("a section header without its byte order mark; this is no pcapng capture", true);
  if (get16(content.substr(4)) != 1)
    return failed("version " + std::to_string(get16(content.substr(4))) + " of the format; 1 is read", true);
  interfaces_.clear();
  return std::nullopt;
}

void PcapngReader::take_option(Interface& interface, std::uint16_t code, std::string_view value) const {
  if (code == 2 && is_interface_name(value)) interface.name = value;
  if (code == 9 && !value.empty()) interface.units = units_of(byte_of(value, 0)).value_or(0);
  if (code == 14 && value.size() >= 8) {
    const std::uint64_t first = get32(value);
    const std::uint64_t second = get32(value.substr(4));
    interface.offset =
        static_cast<std::int64_t>(big_endian_ ? (first << 32) | second : first | (second << 32));
  }
}

std::optional<PcapngError> PcapngReader::take_interface(std::string_view content) {
  if (content.size() < 8) return failed("an interface description that is too short", true);
  if (interfaces_.size() >= kMostInterfaces)
    return failed("more than " + std::to_string(kMostInterfaces) + " interfaces in one section", true);
  Interface interface;
  interface.name = "if" + std::to_string(interfaces_.size());
  interface.can = get16(content) == kLinkTypeSocketcan;
  const unsigned link_type = get16(content);
  content.remove_prefix(8);
  while (content.size() >= 4) {
    const std::uint16_t code = get16(content);
    const std::size_t size = get16(content.substr(2));
    content.remove_prefix(4);
    if (code == 0 || size > content.size()) break;
    take_option(interface, code, content.substr(0, size));
    content.remove_prefix(std::min(content.size(), (size + 3) / 4 * 4));
  }
  interfaces_.push_back(interface);
  if (!interface.can) {
    const bool cooked = link_type == kLinkTypeCooked || link_type == kLinkTypeCooked2;
    return failed("interface " + interface.name + " has link type " + std::to_string(link_type) +
                  (cooked ? " (Linux cooked capture, as of the interface 'any')" : "") + "; only " +
                  std::to_string(kLinkTypeSocketcan) + " (CAN) is read, its packets are left out" +
                  (cooked ? "; capture the CAN interface itself" : ""));
  }
  if (interface.units == 0) return failed("interface " + interface.name + " has an unusable time resolution");
  return std::nullopt;
}

std::optional<PcapngReader::Item> PcapngReader::take_enhanced_packet(std::string_view content) {
  if (content.size() < 20) return failed("a packet that is too short");
  const std::uint64_t stamp = (std::uint64_t{get32(content.substr(4))} << 32) | get32(content.substr(8));
  const std::uint32_t captured = get32(content.substr(12));
  if (captured > content.size() - 20) return failed("a packet longer than its block");
  return take_packet(get32(content), stamp, content.substr(20, captured));
}

std::optional<PcapngReader::Item> PcapngReader::take_obsolete_packet(std::string_view content) {
  if (content.size() < 20) return failed("a packet that is too short");
  const std::uint64_t stamp = (std::uint64_t{get32(content.substr(4))} << 32) | get32(content.substr(8));
  const std::uint32_t captured = get32(content.substr(12));
  if (captured > content.size() - 20) return failed("a packet longer than its block");
  return take_packet(get16(content), stamp, content.substr(20, captured));
}

// It is of the first interface, and as long as its block but for the padding.
std::optional<PcapngReader::Item> PcapngReader::take_simple_packet(std::string_view content) {
  if (content.size() < 4) return failed("a packet that is too short");
  if (interfaces_.empty()) return failed("a packet of interface 0, which is not described");
  if (!interfaces_.front().can) return std::nullopt;
  CandumpLine line;
  line.time = newest_;
  line.interface = interfaces_.front().name;
  if (auto wrong = take_frame(content.substr(4, get32(content)), line)) return *wrong;
  return line;
}

std::optional<PcapngError> PcapngReader::take_frame(std::string_view packet, CandumpLine& line) {
  if (is_long(packet)) return failed("a CAN XL frame, which is no CAN 2.0 frame");
  if (is_flexible(packet)) return failed("a CAN FD frame, which is no CAN 2.0 frame");
  const auto frame = frame_of(packet);
  if (!frame) return failed("a packet that is no CAN 2.0 frame");
  line.frame = *frame;
  return std::nullopt;
}

std::optional<PcapngReader::Item> PcapngReader::take_packet(std::uint32_t number, std::uint64_t stamp,
                                                            std::string_view packet) {
  if (number >= interfaces_.size())
    return failed("a packet of interface " + std::to_string(number) + ", which is not described");
  const Interface& interface = interfaces_[number];
  if (!interface.can || interface.units == 0) return std::nullopt;
  CandumpLine line;
  if (auto wrong = take_frame(packet, line)) return *wrong;
  // What a log can name: see `parse_candump_line`.
  constexpr std::uint64_t kLatest = 999'999'999'999;
  const std::uint64_t seconds =
      std::min(stamp / interface.units, kLatest) + static_cast<std::uint64_t>(interface.offset);
  if (seconds > kLatest) return failed("a time stamp out of range");
  line.time =
      std::chrono::microseconds(seconds * 1'000'000 + micros_of(stamp % interface.units, interface.units));
  line.interface = interface.name;
  newest_ = line.time;
  return line;
}

}  // namespace can
