#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "can/candump.h"

/// Reads captures in the pcapng format (draft-ietf-opsawg-pcapng), as `PcapngWriter`, Wireshark and tcpdump
/// write them. Allocates; not for the realtime thread.
namespace can {

/// True when a file with these first bytes is a pcapng capture; at least 4 bytes are needed.
bool is_pcapng(std::string_view first_bytes) noexcept;

/// Why a block gives no frame. The reader goes on behind it, unless `fatal`.
struct PcapngError {
  std::string message;  ///< "block 3: ..."
  bool fatal = false;   ///< the place of the next block is not known: nothing more can be read
};

/// Takes the bytes of a capture in any pieces and gives its CAN frames. Both byte orders, several sections,
/// every time stamp resolution; blocks other than section header, interface description and packets (enhanced,
/// simple and the obsolete form) are passed over, and so are blocks over `kLongestBlock`, which are told. A simple packet has
/// no time stamp and gets the one before. Holds no more than one block, `kLongestBlock` bytes, and the interfaces of the
/// section, at most `kMostInterfaces`.
class PcapngReader {
 public:
  static constexpr std::uint32_t kLongestBlock = 1u << 20;
  static constexpr std::uint32_t kLongestPassedOver = 1u << 28;
  static constexpr std::size_t kMostInterfaces = 1024;

  using Item = std::variant<CandumpLine, PcapngError>;

  /// More bytes of the file.
  void feed(std::string_view bytes) { buffer_ += bytes; }
  /// The next frame or problem; nothing: feed more. After a fatal problem always nothing.
  std::optional<Item> next();
  /// Bytes that were fed and belong to a block that is not complete; at the end of the file 0 is right.
  std::size_t unfinished() const noexcept { return waiting() + passed_; }

 private:
  /// Bytes that were fed and not looked at.
  std::size_t waiting() const noexcept { return buffer_.size() - at_; }
  /// Passes over what has come of a long block; what it returns, if its end is wrong.
  std::optional<PcapngError> pass_over();
  struct Interface {
    std::string name;
    bool can = false;                 ///< of the link type this reader knows
    std::uint64_t units = 1'000'000;  ///< of time stamps, per second
    std::int64_t offset = 0;          ///< seconds to add
  };

  std::uint16_t get16(std::string_view at) const noexcept;
  std::uint32_t get32(std::string_view at) const noexcept;
  std::optional<PcapngError> failed(std::string_view what, bool fatal = false);
  std::optional<PcapngError> take_section(std::string_view content);
  std::optional<PcapngError> take_interface(std::string_view content);
  std::optional<Item> take_enhanced_packet(std::string_view content);
  std::optional<Item> take_obsolete_packet(std::string_view content);
  std::optional<Item> take_simple_packet(std::string_view content);
  std::optional<Item> take_packet(std::uint32_t number, std::uint64_t stamp, std::string_view packet);
  std::optional<PcapngError> take_frame(std::string_view packet, CandumpLine& line);
  void take_option(Interface& interface, std::uint16_t code, std::string_view value) const;

  std::string buffer_;
  std::size_t at_ = 0;
  std::size_t long_block_ = 0;  ///< length of the one that is being passed over; 0: none is
  std::size_t passed_ = 0;      ///< bytes of it
  bool big_endian_ = false;
  bool stopped_ = false;
  std::uint64_t blocks_ = 0;
  std::vector<Interface> interfaces_;
  std::chrono::microseconds newest_{};  ///< stamp of the packet before
};

}  // namespace can
