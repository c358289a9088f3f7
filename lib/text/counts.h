#pragma once

#include <chrono>
#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

/// Numbers with what they count, and durations with their unit, said in one way everywhere. Pure; allocates,
/// so not for realtime threads.
namespace text {

/// The plural of an English noun: slave, slaves; reply, replies; address, addresses.
inline std::string plural_of(std::string_view noun) {
  constexpr std::string_view kVowels = "aeiou";
  std::string many(noun);
  if (many.ends_with('y') && many.size() > 1 && kVowels.find(many[many.size() - 2]) == kVowels.npos)
    return many.replace(many.size() - 1, 1, "ies");
  const bool hisses = many.ends_with('s') || many.ends_with('x') || many.ends_with("ch");
  return many + (hisses ? "es" : "s");
}

/// "1 slave", "0 slaves", "3 slaves". The form for other numbers than 1 may be given, also with its verb:
/// `counted(n, "edge was", "edges were")`.
inline std::string counted(std::integral auto count, std::string_view one, std::string_view many = {}) {
  const std::string noun = count == 1 ? std::string(one) : many.empty() ? plural_of(one) : std::string(many);
  return std::to_string(count) + ' ' + noun;
}

/// "1 of 32 slaves", "0 of 1 slave".
inline std::string counted_of(std::integral auto part, std::integral auto whole, std::string_view one,
                              std::string_view many = {}) {
  return std::to_string(part) + " of " + counted(whole, one, many);
}

/// "3 s", "1.5 s", "250 ms", "62.5 us", "40 ns": the greatest unit that leaves a number of 1 or more, to
/// three digits behind the point at most, without zeros at its end.
inline std::string duration_text(std::chrono::nanoseconds time) {
  struct Unit {
    std::int64_t nanoseconds;
    std::string_view name;
  };
  constexpr Unit kUnits[] = {{1'000'000'000, " s"}, {1'000'000, " ms"}, {1000, " us"}};
  const std::int64_t count = time.count();
  for (const Unit& unit : kUnits) {
    if (count < unit.nanoseconds && -count < unit.nanoseconds) continue;
    std::string number = std::to_string(count / unit.nanoseconds);
    const std::int64_t part = (count < 0 ? -count : count) % unit.nanoseconds * 1000 / unit.nanoseconds;
    if (part != 0) {
      std::string digits = std::to_string(1000 + part).substr(1);
      digits.erase(digits.find_last_not_of('0') + 1);
      number += '.' + digits;
    }
    return number + std::string(unit.name);
  }
  return std::to_string(count) + (count == 0 ? " s" : " ns");
}

}  // namespace text
