#include <cansync/function_blocks/pd_comm_ma.h>

#include <algorithm>
#include <string>

namespace cansync::client::function_blocks {
namespace {

constexpr SINT kValid = 5;  // M 4.19

}  // namespace

void PD_COMM_MA::call() {
  error_.clear();
  ask();
  if (may_give()) {
    give(si_WRC1_SEND, 1);
    give(si_WRC2_SEND, 2);
  }
  if (slot_.refused()) error_ = slot_.error();

  const ActualValueInbox::News news = inbox_.take();
  si_RD_SL_NR1_RECEIVED = news.newest[0];
  si_RD_SL_NR2_RECEIVED = news.newest[1];
  if (!x_COPY_TO_RD_ARRAY) return;
  for (std::size_t slave = 0; slave < news.arrived.size(); ++slave) {
    for (std::size_t i = 0; i < news.values[slave].size(); ++i) {
      if (((news.arrived[slave] >> (i / 4)) & 1u) != 0) a_RD_ARRAY[slave][i] = news.values[slave][i];
    }
  }
}

/// False: no value may be given in this call; `error_` says why when one is wanted.
bool PD_COMM_MA::may_give() {
  const bool wanted = si_WRC1_SEND == kValid || si_WRC2_SEND == kValid;
  const bool restarted = client_->validity().daemon != meant_for_.daemon;
  const std::string missing = SettingSlot::missing(*client_);
  if (missing.empty() && !restarted && writer_.standing() == ReferenceStanding::mapping_changed) {
    // The program's own mapping is the one its values are made for.
    if (const auto own = SettingSlot::with_own_mapping(*client_)) writer_.take_up(*own);
  }
  if (restarted || (missing.empty() && writer_.standing() != ReferenceStanding::current)) {
    if (!locked_) {
      writer_.release(1);
      writer_.release(2);
    }
    locked_ = true;
  }
  if (locked_ && !wanted) {
    locked_ = false;
    writer_.take_up();
    meant_for_ = client_->validity();
  }
  if (!wanted) return false;
  if (!missing.empty()) error_ = "client: no reference values are given, " + missing;
  if (locked_) {
    error_ =
        "client: the daemon was started anew, or the mapping of the reference values was changed: no values "
        "are given until si_WRC1_SEND and si_WRC2_SEND had another value than 5 in a call";
  }
  return error_.empty();
}

void PD_COMM_MA::give(SINT command, std::uint8_t telegram) {
  if (command != kValid) return;
  std::array<DINT, 4> values = {};
  std::copy_n(a_WR_VALUES_SEND.begin() + std::ptrdiff_t{4} * (telegram - 1), values.size(), values.begin());
  if (std::string failed = writer_.write(telegram, values, 0b1111); !failed.empty())
    error_ = "client: " + failed;
}

void PD_COMM_MA::ask() {
  const std::array<SINT, 3> asked = {si_RD_SL_NR1_RECEIVE, si_RD_SL_NR2_RECEIVE, si_MAX_SL_NR};
  if (asked != asked_) {
    asked_ = asked;
    Polling polling{.one = number(asked[0]), .two = number(asked[1])};
    if (asked[2] != -1) polling.maximum_slave = number(asked[2]);
    slot_.enter([polling](Client& client) { return client.polling(polling); });
    // Other numbers under 0 mean something to the daemon that the manual does not know.
    const auto refuse = [this](const char* input, SINT given, const char* allowed) {
      slot_.refuse(RefusalCause::field, "client: " + std::string(input) + " " + std::to_string(given) +
                                            ": out of range; " + allowed);
    };
    if (asked[0] < -1 && asked[0] != kAutomaticNumber)
      refuse("si_RD_SL_NR1_RECEIVE", asked[0], "allowed 0..31, -128 automatic, -1 nobody");
    if (asked[1] < -1 && asked[1] != kAutomaticNumber)
      refuse("si_RD_SL_NR2_RECEIVE", asked[1], "allowed 0..31, -128 automatic, -1 nobody");
    if (asked[2] < -1) refuse("si_MAX_SL_NR", asked[2], "allowed 0..31, -1 unchanged");
  }
  slot_.poll();
}

}  // namespace cansync::client::function_blocks
