#include "cansync/config/dbc.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "cansync/config/dbc_names.h"
#include "cansync/telegram/telegram.h"

namespace cansyncd {
namespace {

using cansync::Channel;
using cansync::kSlaves;
using cansync::kWords;

constexpr std::string_view kMaster = "master";
constexpr std::string_view kNobody = "Vector__XXX";  // what the format calls a node that is not known

/// Where a signal lies; the format counts bits of little-endian signals from bit 0 of byte 0.
struct Place {
  unsigned start = 0;
  unsigned bits = 0;
  bool is_signed = false;
};

class Writer {
 public:
  explicit Writer(const Config& config) : config_(config) {
    nodes_.take(kMaster);
    nodes_.take(kNobody);
    for (unsigned n = 0; n < kSlaves; ++n) {
      if (!configured(n)) continue;
      node_[n] = nodes_.take(config.slaves[n].name);
      everybody_ += (everybody_.empty() ? "" : ",") + node_[n];
      node_list_ += " " + node_[n];
      if (node_[n] != config.slaves[n].name) comment("BU_ " + node_[n], config.slaves[n].name);
    }
    if (everybody_.empty()) everybody_ = kNobody;
  }

  std::string text() {
    action();
    references();
    for (unsigned n = 0; n < kSlaves; ++n) {
      if (!configured(n)) continue;
      actual(n, Channel::one);
      actual(n, Channel::two);
      command(n);
      response(n);
    }
    const std::string head =
        fmt::format("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {}{}\n\n", kMaster, node_list_);
    const std::string what = fmt::format(
        "CM_ \"CANsync bus {}, {} bit/s. Written by cansyncd --print-dbc from its configuration.\";\n",
        dbc_string(config_.bus.name), cansync::slot_times(config_.master.bit_rate).bits_per_second);
    return head + messages_ + what + comments_ + values_;
  }

 private:
  bool configured(unsigned n) const { return config_.master.slaves[n].configured; }

  /// What people call slave `n`, also one that is not configured.
  std::string called(unsigned n) const { return configured(n) ? node_[n] : fmt::format("{}", n); }

  void comment(const std::string& object, std::string_view text) {
    comments_ += fmt::format("CM_ {} \"{}\";\n", object, dbc_string(text));
  }

  void message(std::uint32_t id, const std::string& name, unsigned length, std::string_view sender) {
    id_ = id;
    signals_ = DbcNames();
    messages_ += fmt::format("{}BO_ {} {}: {} {}\n", messages_.empty() ? "" : "\n", id, names_.take(name),
                             length, sender);
  }
  void message_comment(std::string_view text) { comment(fmt::format("BO_ {}", id_), text); }
  void signal_comment(const std::string& signal, std::string_view text) {
    comment(fmt::format("SG_ {} {}", id_, signal), text);
  }

  /// `group`: "", "M " (multiplexor), or "m1 " (only when it is 1). Returns the name the signal got.
  std::string signal(std::string_view wanted, std::string_view group, const Place& place,
                     const ValueConfig& scaling, std::string_view receiver) {
    std::string name = signals_.take(wanted);
    const double low = place.is_signed ? -std::ldexp(1.0, static_cast<int>(place.bits) - 1) : 0.0;
    const double high = std::ldexp(1.0, static_cast<int>(place.bits) - (place.is_signed ? 1 : 0)) - 1.0;
    const double first = low * scaling.factor + scaling.offset;
    const double last = high * scaling.factor + scaling.offset;
    messages_ +=
        fmt::format(" SG_ {} {}: {}|{}@1{} ({},{}) [{}|{}] \"{}\" {}\n", name, group, place.start, place.bits,
                    place.is_signed ? '-' : '+', scaling.factor, scaling.offset, std::min(first, last),
                    std::max(first, last), dbc_string(scaling.unit), receiver);
    return name;
  }
  std::string raw(std::string_view wanted, std::string_view group, unsigned start, unsigned bits,
                  std::string_view receiver) {
    return signal(wanted, group, {start, bits, false}, {}, receiver);
  }
  /// The number of 12 bits in bytes 0 and 1, the only field whose upper bits come first.
  void twelve(std::string_view wanted, std::string_view group, std::string_view receiver) {
    messages_ +=
        fmt::format(" SG_ {} {}: 3|12@0+ (1,0) [0|4095] \"\" {}\n", signals_.take(wanted), group, receiver);
  }

  /// The values of a telegram; `named` are their names by value number.
  void mapped(const cansync::TelegramMapping& mapping, const ValueConfigs& named, std::string_view receiver) {
    for (unsigned i = 0; i < kWords; ++i) {
      const cansync::WordMapping& word = mapping.word[i];
      if (!word.assigned) continue;
      const ValueConfig& value = named[word.value];
      const std::string name = value.name.empty() ? fmt::format("value{}", word.value) : value.name;
      const auto is = [&](unsigned at, bool high) {
        return at < kWords && mapping.word[at].assigned && mapping.word[at].value == word.value &&
               mapping.word[at].high == high;
      };
      if (!word.high && is(i + 1, true)) {
        told(signal(name, "", {16 * i, 32, value.is_signed}, value, receiver), value.name);
        ++i;
        continue;
      }
      bool other = false;
      for (unsigned at = 0; at < kWords; ++at) other = other || is(at, !word.high);
      half(word, other, i, name, value, receiver);
    }
  }

  /// A word of a value whose other word does not stand behind it.
  void half(const cansync::WordMapping& word, bool other, unsigned at, const std::string& name,
            const ValueConfig& value, std::string_view receiver) {
    ValueConfig scaled = value;
    if (word.high) scaled.factor *= 65536.0;
    if (other && word.high) scaled.offset = 0.0;
    // The sign stands in the high word, or in a low word that is all there is of the value.
    const bool carries_sign = value.is_signed && (word.high || !other);
    const std::string got =
        signal(name + (word.high ? "_high" : "_low"), "", {16 * at, 16, carries_sign}, scaled, receiver);
    if (other)
      signal_comment(got, fmt::format("{}: the value is the sum of its low and its high word", name));
    else
      signal_comment(got, fmt::format("{}: its {} word alone is sent", name, word.high ? "high" : "low"));
  }

  /// A comment with the configured name, when the signal has another.
  void told(const std::string& signal_name, const std::string& configured_name) {
    if (!configured_name.empty() && configured_name != signal_name)
      signal_comment(signal_name, configured_name);
  }

  void action() {
    message(cansync::identifier::action, "action_command", 8, kMaster);
    const std::string slaves = raw("slaves", "", 0, 32, everybody_);
    signal_comment(slaves, "bit n = slave n");
    const std::string number = raw("command", "", 32, 8, everybody_);
    raw("data_byte", "", 40, 8, everybody_);
    raw("data_word", "", 48, 16, everybody_);
    signal_comment("data_word", "with command 1 the control word");
    values_ += fmt::format("VAL_ {} {} {} \"control word\";\n", id_, number, cansync::kCommandControlWord);
  }

  void reference(unsigned asked, const std::string& who, Channel channel) {
    const bool one = channel == Channel::one;
    const std::uint32_t base = one ? cansync::identifier::reference_one : cansync::identifier::reference_two;
    const auto& mapping = config_.master.process.reference_mapping[one ? 0 : 1];
    const unsigned length = config_.master.process.full_length ? 8 : 2u * mapping.used_words();
    message(base + asked, fmt::format("WRC{}_{}", one ? 1 : 2, who), length, kMaster);
    mapped(mapping, config_.references, everybody_);
    message_comment(asked < kSlaves ? fmt::format("reference values; slave {} answers", asked)
                                    : std::string("reference values; nobody answers"));
  }

  /// One message for each number that may be asked: the slave stands in the identifier.
  void references() {
    const unsigned highest = config_.master.process.maximum_slave.value();
    for (const Channel channel : {Channel::one, Channel::two}) {
      for (unsigned n = 0; n < kSlaves; ++n)
        if (configured(n) || n <= highest) reference(n, called(n), channel);
      reference(config_.master.process.poll_nobody, "nobody", channel);
    }
  }

  void actual(unsigned n, Channel channel) {
    const bool one = channel == Channel::one;
    const std::uint32_t base = one ? cansync::identifier::actual_one : cansync::identifier::actual_two;
    const auto& mapping = config_.master.slaves[n].actual_mapping[one ? 0 : 1];
    message(base + n, fmt::format("RDC{}_{}", one ? 1 : 2, node_[n]), 2u * mapping.used_words(), node_[n]);
    mapped(mapping, config_.slaves[n].actual, kMaster);
    message_comment(fmt::format("actual values of slave {}", n));
  }

  void raw_words(std::string_view receiver) {
    for (unsigned i = 1; i < kWords; ++i) raw(fmt::format("word_{}", i), "", 16 * i, 16, receiver);
  }

  void command(unsigned n) {
    message(cansync::identifier::command + n, "CC_" + node_[n], 8, kMaster);
    const std::string kind = raw("kind", "M ", 7, 1, node_[n]);
    raw("element", "m0 ", 4, 3, node_[n]);
    twelve("number", "m0 ", node_[n]);
    const std::string mode = raw("mode", "m1 ", 4, 2, node_[n]);
    const std::string direction = raw("direction", "m1 ", 6, 1, node_[n]);
    twelve("length_or_offset", "m1 ", node_[n]);
    raw_words(node_[n]);
    values_ += fmt::format("VAL_ {0} {1} 0 \"parameter\" 1 \"transfer\";\n", id_, kind);
    values_ += fmt::format("VAL_ {0} {1} 1 \"begin\" 2 \"body\" 3 \"last\";\n", id_, mode);
    values_ += fmt::format("VAL_ {0} {1} 0 \"upload\" 1 \"download\";\n", id_, direction);
    message_comment(
        "Parameter command: 4 bytes read (word_1 sub-slave), 6 write word (word_1 value, word_2 sub-slave), "
        "8 write doubleword (word_1, word_2 value, word_3 sub-slave). Transfer: begin (word_1, word_2 start "
        "address, word_3 sub-slave), upload 2 bytes, download data in words 1 to 3.");
  }

  void response(unsigned n) {
    message(cansync::identifier::response + n, "RC_" + node_[n], 8, node_[n]);
    const std::string kind = raw("kind", "M ", 7, 1, kMaster);
    raw("busy", "", 6, 1, kMaster);
    raw("error", "", 5, 1, kMaster);
    twelve("number", "m0 ", kMaster);
    twelve("length_or_offset", "m1 ", kMaster);
    raw_words(kMaster);
    values_ += fmt::format("VAL_ {0} {1} 0 \"parameter\" 1 \"transfer\";\n", id_, kind);
    message_comment(
        "2 to 8 bytes. error = 1: word_1 is the code. Parameter read: word_1, or word_1 and word_2, the "
        "value, then the sub-slave. Upload: data in words 1 to 3.");
  }

  const Config& config_;
  DbcNames nodes_;
  DbcNames names_;    // of messages
  DbcNames signals_;  // of the message that is written
  std::array<std::string, kSlaves> node_;
  std::string node_list_;
  std::string everybody_;
  std::uint32_t id_ = 0;
  std::string messages_;
  std::string comments_;
  std::string values_;
};

}  // namespace

std::string dbc_text(const Config& config) {
  return Writer(config).text();
}

}  // namespace cansyncd
