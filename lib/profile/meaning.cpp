#include "profile/meaning.h"

namespace profile {
namespace {

template <class Wanted>
std::string collect(const Parameter& parameter, std::uint32_t raw, Wanted&& wanted) {
  std::string text;
  const auto add = [&](const Meaning& meaning) {
    if (wanted(meaning)) text += (text.empty() ? "" : ", ") + meaning.words;
  };
  for (const Meaning& meaning : parameter.values)
    if (meaning.number == raw) add(meaning);
  for (const Meaning& meaning : parameter.bits)
    if (((raw >> meaning.number) & 1u) != 0) add(meaning);
  return text;
}

}  // namespace

std::string words(const Parameter& parameter, std::uint32_t raw) {
  return collect(parameter, raw, [](const Meaning&) { return true; });
}

std::string fault_words(const Parameter& parameter, std::uint32_t raw) {
  return collect(parameter, raw, [](const Meaning& meaning) { return meaning.fault; });
}

}  // namespace profile
