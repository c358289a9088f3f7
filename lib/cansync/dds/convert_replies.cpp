#include <algorithm>

#include "cansync/dds/convert.h"

namespace cansync::dds {
namespace {

using gateway::dds::Denial;

/// Builds a reason from pieces in the reply's own memory, without allocation.
template <std::size_t N>
class ReasonBuilder {
 public:
  explicit ReasonBuilder(char (&out)[N]) noexcept : out_(out) {}
  ReasonBuilder& add(std::string_view piece) noexcept {
    copy_text(piece, out_ + length_, N - length_);
    length_ = text(out_).size();
    return *this;
  }
  ReasonBuilder& add_hexadecimal(std::uint16_t value) noexcept {
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    const char digits[] = {'0',
                           'x',
                           kDigits[value >> 12],
                           kDigits[(value >> 8) & 0xF],
                           kDigits[(value >> 4) & 0xF],
                           kDigits[value & 0xF]};
    return add({digits, sizeof digits});
  }

 private:
  char (&out_)[N];
  std::size_t length_ = 0;
};

std::string_view reason_of(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return "";
    case Outcome::slave_error:
      return "the slave answered with an error";
    case Outcome::timeout:
      return "no final answer of the slave within the monitoring time; check that it responds, or give a "
             "longer timeout";
    case Outcome::no_answer:
      return "the write was not answered; whether the slave took the value is not known: read it back";
    case Outcome::word_expected:
      return "the parameter is a word; use format word or as_slave_says";
    case Outcome::doubleword_expected:
      return "the parameter is a doubleword; use format doubleword or as_slave_says";
    case Outcome::value_too_wide:
      return "the parameter is a word that cannot hold the value; allowed 0..65535";
    case Outcome::cancelled:
      return "cancelled";
    case Outcome::master_stopped:
      return "the master left the operating state while the request was open";
    case Outcome::slave_lost:
      return "the slave stopped answering; what was under way may have been taken or not: check its power "
             "and the bus cable, and read back what was written";
    case Outcome::slave_held:
      return "not sent: the slave lost SYNC or was away, and is held out until it is released";
    case Outcome::replaced:
      return "not sent: a newer control word for the slave, or a stop, took its place";
    case Outcome::taken:
      return "the slave has taken the value and was busy with it; its final answer did not come: read it back";
  }
  return "unknown outcome";
}

/// Of a download: a part of it, or all, is in the slave's memory.
std::string_view reason_of_transfer(Outcome outcome) noexcept {
  if (outcome == Outcome::no_answer)
    return "ended when a part of the data was sent: the slave has what it confirmed, and may have more; download "
           "it again";
  return reason_of(outcome);
}

/// What slaves do not answer ends for other reasons than what they do.
std::string_view reason_of_command(Outcome outcome) noexcept {
  if (outcome == Outcome::timeout) {
    return "not sent within the monitoring time; check the cursor of control words, and that the bus takes "
           "telegrams";
  }
  if (outcome == Outcome::no_answer) {
    return "handed over, but not seen on the bus within its interval; whether the slave took it is not "
           "known: read its status word, and give it again";
  }
  return reason_of(outcome);
}

template <std::size_t N>
void fill_reason(Outcome outcome, std::uint16_t code, std::string_view meaning, std::string_view otherwise,
                 char (&out)[N]) noexcept {
  ReasonBuilder<N> reason(out);
  if (outcome != Outcome::slave_error) {
    reason.add(otherwise);
    return;
  }
  reason.add("slave error ").add_hexadecimal(code).add(": ").add(meaning);
}

template <class Reply>
Reply reply_to(const RequestKey& key) noexcept {
  Reply reply = {};
  std::copy(key.client.begin(), key.client.end(), std::begin(reply.client));
  reply.request = key.request;
  return reply;
}

template <class Reply>
Reply ended(const RequestKey& key, Outcome outcome) noexcept {
  Reply reply = reply_to<Reply>(key);
  reply.code = to_reply_code(outcome);
  reply.cause = to_cause(outcome);
  return reply;
}

template <class Reply>
Reply refused(const RequestKey& key, const Denial& denial) noexcept {
  Reply reply = reply_to<Reply>(key);
  gateway::dds::refuse(reply, denial);
  return reply;
}

}  // namespace

gateway_ReplyCode to_reply_code(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return gateway_REPLY_DONE;
    case Outcome::slave_error:
      return gateway_REPLY_SLAVE_ERROR;
    case Outcome::timeout:
      return gateway_REPLY_TIMEOUT;
    case Outcome::no_answer:
    case Outcome::taken:
      return gateway_REPLY_NO_ANSWER;
    case Outcome::word_expected:
      return gateway_REPLY_WORD_EXPECTED;
    case Outcome::doubleword_expected:
      return gateway_REPLY_DOUBLEWORD_EXPECTED;
    case Outcome::value_too_wide:
      return gateway_REPLY_VALUE_TOO_WIDE;
    case Outcome::cancelled:
      return gateway_REPLY_CANCELLED;
    case Outcome::slave_lost:
      return gateway_REPLY_SLAVE_LOST;
    case Outcome::slave_held:
      return gateway_REPLY_REFUSED;
    case Outcome::replaced:
      return gateway_REPLY_REPLACED;
    case Outcome::master_stopped:
      break;
  }
  return gateway_REPLY_MASTER_STOPPED;
}

gateway_RefusalCause to_cause(Outcome outcome) noexcept {
  return outcome == Outcome::slave_held ? gateway_CAUSE_SLAVE_HELD : gateway_CAUSE_NONE;
}

cansync_ParameterReply parameter_reply(const RequestKey& key, const ParameterResult& result) noexcept {
  auto reply = ended<cansync_ParameterReply>(key, result.outcome);
  reply.error_code = static_cast<std::uint16_t>(result.error);
  fill_reason(result.outcome, reply.error_code, meaning(result.error), reason_of(result.outcome),
              reply.reason);
  reply.doubleword = result.doubleword;
  reply.value = result.value;
  reply.intervals = result.intervals;
  return reply;
}

cansync_TransferReply transfer_reply(const RequestKey& key, const TransferResult& result,
                                     std::span<std::uint8_t> data) noexcept {
  auto reply = ended<cansync_TransferReply>(key, result.outcome);
  reply.error_code = static_cast<std::uint16_t>(result.error);
  fill_reason(result.outcome, reply.error_code, meaning(result.error), reason_of_transfer(result.outcome),
              reply.reason);
  reply.error_offset = result.error_offset;
  reply.done = result.bytes;
  reply.intervals = result.intervals;
  reply.repeated_telegrams = result.repeated_telegrams;
  reply.repeated_blocks = result.repeated_blocks;
  reply.data._buffer = data.data();
  reply.data._length = static_cast<std::uint32_t>(data.size());
  reply.data._maximum = reply.data._length;
  return reply;
}

cansync_CommandReply command_reply(const RequestKey& key, Outcome outcome) noexcept {
  auto reply = ended<cansync_CommandReply>(key, outcome);
  copy_text(reason_of_command(outcome), reply.reason);
  return reply;
}

cansync_ParameterReply parameter_refused(const RequestKey& key, const Denial& denial) noexcept {
  return refused<cansync_ParameterReply>(key, denial);
}

cansync_TransferReply transfer_refused(const RequestKey& key, const Denial& denial) noexcept {
  return refused<cansync_TransferReply>(key, denial);
}

cansync_CommandReply command_refused(const RequestKey& key, const Denial& denial) noexcept {
  return refused<cansync_CommandReply>(key, denial);
}

cansync_TransferProgress transfer_progress(const RequestKey& key, std::uint32_t done,
                                           std::uint32_t total) noexcept {
  cansync_TransferProgress progress = {};
  std::copy(key.client.begin(), key.client.end(), std::begin(progress.client));
  progress.request = key.request;
  progress.done = done;
  progress.total = total;
  return progress;
}

}  // namespace cansync::dds
