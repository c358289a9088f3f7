#include "cli/scan/inquiry.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "cansync/channel/transfer_job.h"
#include "cansync/settings/settings.h"

namespace cansync::cli {
namespace {

using ask::Answer;

/// Recognition takes this many numbers at most, whatever stands in the profiles.
constexpr std::size_t kMostRecognitionNumbers = 64;
/// What every CANsync slave should take (M 4.24), and the step of block lengths.
constexpr std::uint16_t kUsualBlock = 300;
constexpr std::uint16_t kBlockStep = 6;

/// The inquiry was stopped.
struct Stopped {};

std::vector<std::uint16_t> recognition_numbers(const std::vector<ProfilePointer>& profiles) {
  std::set<std::uint16_t> numbers;
  for (const ProfilePointer& profile : profiles)
    for (const profile::Recognition& recognition : profile->recognised_by)
      if (numbers.size() < kMostRecognitionNumbers) numbers.insert(recognition.number);
  return {numbers.begin(), numbers.end()};
}

std::optional<TelegramMapping> mapping_of(std::uint32_t registers) {
  TelegramMapping out;
  for (unsigned i = 0; i < kWords; ++i) {
    const auto word = from_register(static_cast<std::uint8_t>(registers >> (8 * i)));
    if (!word) return std::nullopt;
    out.word[i] = *word;
  }
  return out;
}

class Inquiry {
 public:
  Inquiry(QuestionLine& line, const InquirySettings& settings, const InquiryProgress& progress)
      : line_(line),
        settings_(settings),
        progress_(progress),
        numbers_(recognition_numbers(settings.profiles)) {}

  void run(std::vector<FoundSlave>& out) {
    look_for_slaves(out);
    for (FoundSlave& slave : out) ask_about(slave);
    if (!settings_.parameters) return;
    for (FoundSlave& slave : out) scan_parameters(slave);
  }

 private:
  Answer ask(const ask::Question& question) {
    const auto answer = line_.ask(question);
    if (!answer) throw Stopped{};
    return *answer;
  }

  /// Reads a parameter once; what came of it is kept.
  const FoundParameter* read(FoundSlave& slave, std::uint16_t number) {
    const auto at = std::lower_bound(
        slave.parameters.begin(), slave.parameters.end(), number,
        [](const FoundParameter& found, std::uint16_t wanted) { return found.number < wanted; });
    if (at != slave.parameters.end() && at->number == number) return &*at;
    const Answer answer = ask(ask::ReadQuestion{slave.number, *ParameterNumber::from(number)});
    const bool later = answer.kind == Answer::Kind::refused &&
                       answer.error == static_cast<std::uint16_t>(ParameterError::not_available_now);
    if (answer.kind != Answer::Kind::value && !later) return nullptr;
    return &*slave.parameters.insert(at, {number, answer.doubleword, answer.value, answer.error});
  }

  void look_for_slaves(std::vector<FoundSlave>& out) {
    for (const SlaveNumber number : settings_.slaves) {
      progress_("looking for slaves", number.value(), kSlaves);
      FoundSlave slave;
      slave.number = number;
      const Answer answer = ask(ask::ReadQuestion{number, *ParameterNumber::from(slave.status_parameter)});
      if (answer.kind == Answer::Kind::silent) continue;
      if (answer.kind == Answer::Kind::value)
        slave.parameters.push_back({slave.status_parameter, answer.doubleword, answer.value, 0});
      out.push_back(std::move(slave));
    }
  }

  void ask_about(FoundSlave& slave) {
    progress_(fmt::format("asking slave {}", slave.number.value()), 0, 1);
    for (const std::uint16_t number : numbers_) read(slave, number);
    slave.profile = recognised(settings_.profiles, slave.parameters);
    if (slave.profile) read_told(slave, *slave.profile);
    if (const FoundParameter* status = read(slave, slave.status_parameter); status && status->error == 0)
      slave.status_word = static_cast<std::uint16_t>(status->value);
    if (!slave.block_limit) slave.block_limit = try_blocks(slave.number);
  }

  /// What the profile says that the drive's parameters tell.
  void read_told(FoundSlave& slave, const profile::Profile& profile) {
    using profile::Tells;
    for (const profile::Parameter& parameter : profile.parameters) {
      const bool identity = parameter.identity != profile::Identity::none;
      if (parameter.tells == Tells::none && !identity) continue;
      if (parameter.tells == Tells::status_word) slave.status_parameter = parameter.number;
      const FoundParameter* found = read(slave, parameter.number);
      if (found == nullptr || found->error != 0) continue;
      take_told(slave, parameter.tells, found->value);
    }
  }

  static void take_told(FoundSlave& slave, profile::Tells tells, std::uint32_t value) {
    using profile::Tells;
    switch (tells) {
      case Tells::block_limit:
        slave.block_limit_told = value >= kBlockStep && value <= kLongestBlock;
        if (slave.block_limit_told) slave.block_limit = static_cast<std::uint16_t>(value);
        return;
      case Tells::reference_mapping_1:
        slave.reference[0] = mapping_of(value);
        return;
      case Tells::reference_mapping_2:
        slave.reference[1] = mapping_of(value);
        return;
      case Tells::actual_mapping_1:
        slave.actual[0] = mapping_of(value);
        return;
      case Tells::actual_mapping_2:
        slave.actual[1] = mapping_of(value);
        return;
      case Tells::status_word:
      case Tells::none:
        return;
    }
  }

  /// Does the slave take a block of this length? Nothing: its answer says nothing of lengths.
  std::optional<bool> takes_block(SlaveNumber slave, std::uint16_t length) {
    const Answer answer = ask(ask::BlockQuestion{slave, *BlockOffset::from(length)});
    // Without an answer it may have begun as well.
    if (answer.kind != Answer::Kind::refused) line_.ask(ask::CloseQuestion{slave});
    // One that fixes the length itself does not say which it would refuse.
    if (answer.kind == Answer::Kind::taken && (answer.length == 0 || answer.length == length)) return true;
    const auto error = static_cast<TransferError>(answer.error);
    if (answer.kind != Answer::Kind::refused) return std::nullopt;
    if (error == TransferError::block_too_long || error == TransferError::longer_than_300_bytes) return false;
    return std::nullopt;
  }

  std::optional<std::uint16_t> try_blocks(SlaveNumber slave) {
    const auto usual = takes_block(slave, kUsualBlock);
    if (!usual) return std::nullopt;
    unsigned taken = *usual ? kUsualBlock : 0;
    unsigned refused = *usual ? kLongestBlock + kBlockStep : kUsualBlock;
    // First the longest there is: most drives take 300 or everything.
    unsigned next = *usual ? kLongestBlock : kUsualBlock / 2;
    while (refused - taken > kBlockStep) {
      const auto length = static_cast<std::uint16_t>(next - next % kBlockStep);
      const auto takes = takes_block(slave, length);
      if (!takes) break;
      (*takes ? taken : refused) = length;
      next = (taken + refused) / 2;
    }
    return taken == 0 ? std::nullopt : std::optional(static_cast<std::uint16_t>(taken));
  }

  void scan_parameters(FoundSlave& slave) {
    for (unsigned number = 0; number <= ParameterNumber::max; ++number) {
      progress_(fmt::format("slave {}: reading parameter numbers", slave.number.value()), number,
                ParameterNumber::max + 1u);
      read(slave, static_cast<std::uint16_t>(number));
    }
  }

  QuestionLine& line_;
  const InquirySettings& settings_;
  const InquiryProgress& progress_;
  std::vector<std::uint16_t> numbers_;
};

bool has_value(const std::vector<FoundParameter>& parameters, const profile::Recognition& wanted) {
  return std::any_of(parameters.begin(), parameters.end(), [&](const FoundParameter& found) {
    return found.number == wanted.number && found.value == wanted.value && found.error == 0;
  });
}

}  // namespace

ProfilePointer recognised(const std::vector<ProfilePointer>& profiles,
                          const std::vector<FoundParameter>& parameters) {
  ProfilePointer best;
  for (const ProfilePointer& profile : profiles) {
    const auto& wanted = profile->recognised_by;
    const bool fits = !wanted.empty() && std::all_of(wanted.begin(), wanted.end(), [&](const auto& one) {
      return has_value(parameters, one);
    });
    if (fits && (!best || wanted.size() > best->recognised_by.size())) best = profile;
  }
  return best;
}

InquiryResult inquire(QuestionLine& line, const InquirySettings& settings, const InquiryProgress& progress) {
  InquiryResult result;
  try {
    Inquiry(line, settings, progress).run(result.slaves);
  } catch (const Stopped&) {
    result.stopped = true;
  } catch (const std::runtime_error& error) {
    if (result.slaves.empty()) throw;
    result.stopped = true;
    result.failure = error.what();
  }
  for (FoundSlave& slave : result.slaves) slave.twice = line.two_answer(slave.number);
  return result;
}

}  // namespace cansync::cli
