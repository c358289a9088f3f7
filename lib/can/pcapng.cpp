#include "can/pcapng.h"

#include <algorithm>
#include <array>
#include <functional>

namespace can {
namespace {

// Block types, options and flags by their numbers in the draft and on the page of the link type.
constexpr std::uint32_t kSectionHeader = 0x0A0D0D0A;
constexpr std::uint32_t kByteOrder = 0x1A2B3C4D;
constexpr std::uint32_t kInterfaceDescription = 1;
constexpr std::uint32_t kEnhancedPacket = 6;
constexpr std::uint16_t kEndOfOptions = 0;
constexpr std::uint16_t kApplication = 4;     // shb_userappl
constexpr std::uint16_t kInterfaceName = 2;   // if_name
constexpr std::uint16_t kTimeResolution = 9;  // if_tsresol
constexpr char kNanoseconds = 9;              // negative power of ten
constexpr std::uint32_t kExtended = 0x80000000;
constexpr std::uint32_t kRemote = 0x40000000;
constexpr std::uint32_t kError = 0x20000000;
constexpr std::uint32_t kPacketSize = 16;

void put16(std::string& out, std::uint16_t value) {
  out += static_cast<char>(value & 0xFF);
  out += static_cast<char>(value >> 8);
}
void put32(std::string& out, std::uint32_t value) {
  put16(out, static_cast<std::uint16_t>(value & 0xFFFF));
  put16(out, static_cast<std::uint16_t>(value >> 16));
}

// Type, length, content already padded to 32 bits, and the length again.
std::string block(std::uint32_t type, std::string_view content) {
  const auto length = static_cast<std::uint32_t>(content.size() + 12);
  std::string out;
  out.reserve(length);
  put32(out, type);
  put32(out, length);
  out += content;
  put32(out, length);
  return out;
}

void put_option(std::string& out, std::uint16_t code, std::string_view value) {
  // A length field of 16 bits; no text of ours comes near.
  value = value.substr(0, 0xFFFF);
  put16(out, code);
  put16(out, static_cast<std::uint16_t>(value.size()));
  out += value;
  out.append((4 - value.size() % 4) % 4, '\0');
}

void end_options(std::string& out) {
  put16(out, kEndOfOptions);
  put16(out, 0);
}

std::uint32_t flagged_identifier(const Frame& frame) {
  if (frame.error) return frame.identifier() | kError;
  return frame.identifier() | (frame.extended ? kExtended : 0) | (frame.remote ? kRemote : 0);
}

// SocketCAN's pseudo header, identifier in network byte order, and eight bytes of data.
void put_packet(std::string& out, const Frame& frame) {
  const std::uint32_t id = flagged_identifier(frame);
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>((id >> shift) & 0xFF);
  const std::uint8_t length = std::min<std::uint8_t>(frame.dlc, 8);
  out += static_cast<char>(length);
  out.append(3, '\0');
  for (unsigned i = 0; i < frame.data.size(); ++i) out += static_cast<char>(i < length ? frame.data[i] : 0);
}

}  // namespace

std::string PcapngWriter::begin(std::string_view application) {
  std::string content;
  put32(content, kByteOrder);
  put16(content, 1);  // version 1.0
  put16(content, 0);
  put32(content, 0xFFFFFFFF);  // length of the section: not told
  put32(content, 0xFFFFFFFF);
  put_option(content, kApplication, application);
  end_options(content);
  return block(kSectionHeader, content);
}

std::string PcapngWriter::frame(std::chrono::nanoseconds time, std::string_view interface,
                                const Frame& frame) {
  std::string out;
  auto known = interfaces_.find(interface);
  if (known == interfaces_.end()) {
    known = interfaces_.emplace(interface, static_cast<std::uint32_t>(interfaces_.size())).first;
    std::string content;
    put16(content, kLinkTypeSocketcan);
    put16(content, 0);
    put32(content, kPacketSize);  // longest packet
    put_option(content, kInterfaceName, interface);
    put_option(content, kTimeResolution, std::string_view(&kNanoseconds, 1));
    end_options(content);
    out = block(kInterfaceDescription, content);
  }
  const auto stamp = static_cast<std::uint64_t>(std::max<std::int64_t>(time.count(), 0));
  std::string content;
  put32(content, known->second);
  put32(content, static_cast<std::uint32_t>(stamp >> 32));
  put32(content, static_cast<std::uint32_t>(stamp & 0xFFFFFFFF));
  put32(content, kPacketSize);  // captured
  put32(content, kPacketSize);  // on the wire
  put_packet(content, frame);
  return out + block(kEnhancedPacket, content);
}

}  // namespace can
