#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Drive profiles: which parameters a type of drive has, and what they are called. Plain values, no DDS and
/// no bus; docs/profiles.md describes the file. Not for the realtime thread (allocates).
namespace profile {

/// Format of a parameter on the bus.
enum class Format : std::uint8_t { word, doubleword };

/// What may be done with a parameter.
enum class Access : std::uint8_t {
  read_write,
  read_only,  ///< a write is refused
  none,       ///< neither read nor written; the profile only says what the number is
};

/// Does the value tell which drive this is?
enum class Identity : std::uint8_t {
  none,
  type,  ///< the same in every drive that the same values fit: device type, firmware
  unit,  ///< tells one drive from the other: serial number
};

/// Does the value tell something of how the drive takes part in the bus?
enum class Tells : std::uint8_t {
  none,
  status_word,          ///< it is the status word
  block_limit,          ///< most bytes of a block of an upload or download
  reference_mapping_1,  ///< four register bytes, that of word 0 the lowest (M 3.1.1.1)
  reference_mapping_2,
  actual_mapping_1,
  actual_mapping_2,
};

/// A parameter with the raw value that a type of drive has there.
struct Recognition {
  std::uint16_t number = 0;  ///< 0..4095
  std::uint32_t value = 0;
};

/// What a bit that is set, or a number, means.
struct Meaning {
  std::uint32_t number = 0;  ///< bit 0..31, or the raw number
  std::string words;         ///< 1..60 bytes
  bool fault = false;        ///< the drive is in fault then
};

/// One parameter. A value in engineering units = raw number * factor + offset.
struct Parameter {
  std::uint16_t number = 0;  ///< 0..4095
  std::string name;          ///< lower-case letters, digits, '-'; 1..64 bytes, begins with a letter
  Format format = Format::word;
  bool is_signed = false;    ///< the raw number is two's complement
  std::string unit;          ///< 0..16 bytes
  double factor = 1.0;       ///< finite, not 0
  double offset = 0.0;       ///< finite
  bool limited = false;      ///< the profile gives `minimum` or `maximum`
  std::int64_t minimum = 0;  ///< smallest raw number allowed, at least what the format holds
  std::int64_t maximum = 0;  ///< greatest raw number allowed, inclusive
  Access access = Access::read_write;
  bool is_volatile = false;  ///< changes by itself: never compared and never restored
  Identity identity = Identity::none;
  Tells tells = Tells::none;
  std::optional<std::uint8_t>
      actual_value;             ///< 0..7: the same stands in this actual value, with this scaling
  std::string group;            ///< a name like `name`; empty: none
  std::string text;             ///< what it means, for people; 0..200 bytes
  std::vector<Meaning> bits;    ///< each bit at most once
  std::vector<Meaning> values;  ///< each number at most once
};

/// The parameters of one type of drive.
struct Profile {
  std::string name;  ///< a name like a parameter's; also the name of its file without ".toml"
  std::string text;
  std::vector<Recognition> recognised_by;  ///< a drive with all of these is of this type; empty: never
  std::string hash;                        ///< SHA-256 of the file, 64 hexadecimal digits
  std::vector<Parameter> parameters;       ///< by rising number, each number and each name once

  /// The parameter of this number; null when the profile has none.
  const Parameter* find(std::uint32_t wanted) const noexcept;
  /// The parameter of this name; null when the profile has none.
  const Parameter* find(std::string_view wanted) const noexcept;
  /// The parameter that tells this; null when the profile has none.
  const Parameter* telling(Tells wanted) const noexcept;
};

}  // namespace profile
