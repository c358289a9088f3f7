#pragma once

#include <cstdint>
#include <span>

/// The NAME of a controller application (SAE J1939-81).
namespace j1939 {

/// 64 bits; on the bus the lowest byte first. Of two who claim one address the lower NAME has it.
using Name = std::uint64_t;

/// A NAME as its fields, from the lowest bits to the highest; bit 48 is reserved and 0.
struct NameFields {
  std::uint32_t identity = 0;                ///< 21 bits: serial number, by the manufacturer
  std::uint16_t manufacturer = 0;            ///< 11 bits: code given by SAE
  std::uint8_t ecu_instance = 0;             ///< 3 bits
  std::uint8_t function_instance = 0;        ///< 5 bits
  std::uint8_t function = 0;                 ///< 8 bits
  std::uint8_t vehicle_system = 0;           ///< 7 bits
  std::uint8_t vehicle_system_instance = 0;  ///< 4 bits
  std::uint8_t industry_group = 0;           ///< 3 bits
  bool arbitrary_address = false;            ///< takes another address when it loses its own

  friend bool operator==(const NameFields&, const NameFields&) = default;
};

/// Puts the fields together; of one that is too large the lower bits count. Realtime safe; any thread.
constexpr Name compose(const NameFields& fields) noexcept {
  return (fields.identity & 0x1FFFFFu) | Name{fields.manufacturer & 0x7FFu} << 21 |
         Name{fields.ecu_instance & 7u} << 32 | Name{fields.function_instance & 0x1Fu} << 35 |
         Name{fields.function} << 40 | Name{fields.vehicle_system & 0x7Fu} << 49 |
         Name{fields.vehicle_system_instance & 0xFu} << 56 | Name{fields.industry_group & 7u} << 60 |
         Name{fields.arbitrary_address ? 1u : 0u} << 63;
}

/// Takes a NAME apart. Realtime safe; any thread.
constexpr NameFields fields_of(Name name) noexcept {
  return {static_cast<std::uint32_t>(name & 0x1FFFFF),
          static_cast<std::uint16_t>(name >> 21 & 0x7FF),
          static_cast<std::uint8_t>(name >> 32 & 7),
          static_cast<std::uint8_t>(name >> 35 & 0x1F),
          static_cast<std::uint8_t>(name >> 40),
          static_cast<std::uint8_t>(name >> 49 & 0x7F),
          static_cast<std::uint8_t>(name >> 56 & 0xF),
          static_cast<std::uint8_t>(name >> 60 & 7),
          (name >> 63) != 0};
}

/// Loses against every other NAME: an arbitrary address, and every field at its largest, "not available".
inline constexpr Name kWeakestName = compose({.identity = 0x1FFFFF,
                                              .manufacturer = 0x7FF,
                                              .ecu_instance = 7,
                                              .function_instance = 0x1F,
                                              .function = 0xFF,
                                              .vehicle_system = 0x7F,
                                              .vehicle_system_instance = 0xF,
                                              .industry_group = 7,
                                              .arbitrary_address = true});

/// The NAME in the first eight bytes; `bytes` has them.
constexpr Name name_of(std::span<const std::uint8_t> bytes) noexcept {
  Name name = 0;
  for (unsigned i = 0; i < 8; ++i) name |= Name{bytes[i]} << 8 * i;
  return name;
}

}  // namespace j1939
