#include <cansync/function_blocks/j1939/cansend_sae_j1939.h>
#include <cansync/function_blocks/module_codes.h>

#include <utility>

#include "client/src/j1939/message_side.h"
#include "j1939/identifier.h"

namespace cansync::client::function_blocks {
namespace {

std::string out_of_range(const char* input, INT value, const char* allowed) {
  return "client: " + std::string(input) + " " + std::to_string(value) + ": out of range; allowed " + allowed;
}

}  // namespace

void CANSEND_SAE_J1939::call() {
  detail::MessageSide& side = connection_->side();
  side.look();
  RETVAL = std::exchange(Snd, false) ? send() : module_code::done;
  side.look();
  if (RETVAL == module_code::done) error_ = side.failure();
  STAT = side.status_word();
}

UDINT CANSEND_SAE_J1939::failures() const noexcept {
  return connection_->side().failures();
}

INT CANSEND_SAE_J1939::send() {
  detail::MessageSide& side = connection_->side();
  if (Priority < 0 || Priority > 7)
    return refuse(module_code::input_invalid, out_of_range("Priority", Priority, "0..7"));
  if (PDU_Format < 0 || PDU_Format > 255)
    return refuse(module_code::input_invalid, out_of_range("PDU_Format", PDU_Format, "0..255"));
  const bool to_one = PDU_Format < 240;
  if (PDU_Specific < 0 || PDU_Specific > 255 || (to_one && PDU_Specific == j1939::kNullAddress))
    return refuse(module_code::input_invalid,
                  out_of_range("PDU_Specific", PDU_Specific,
                               to_one ? "0..253 and 255, the destination" : "0..255, the group extension"));
  if (side.take_restart())
    return refuse(
        module_code::not_ready,
        "client: the daemon was started anew: this frame was not sent; give it again if it still holds");
  if (std::string obstacle = side.obstacle(); !obstacle.empty())
    return refuse(module_code::not_ready, std::move(obstacle));
  if (const unsigned own = side.address().value_or(j1939::kNullAddress);
      Source_Addr < 0 || static_cast<unsigned>(Source_Addr) != own)
    return refuse(module_code::node_invalid, "client: Source_Addr " + std::to_string(Source_Addr) +
                                                 ": the daemon's address is " + std::to_string(own) +
                                                 "; give that, or the daemon address.preferred");
  const j1939::Identifier parts = {.priority = static_cast<std::uint8_t>(Priority),
                                   .data_page = DataPageBit,
                                   .format = static_cast<std::uint8_t>(PDU_Format),
                                   .specific = static_cast<std::uint8_t>(PDU_Specific),
                                   .source = static_cast<std::uint8_t>(Source_Addr)};
  side.queues().send(
      {.identifier = j1939::compose(parts), .bytes = {B0, B1, B2, B3, B4, B5, B6, B7}, .length = 8}, false);
  return module_code::done;
}

INT CANSEND_SAE_J1939::refuse(INT code, std::string reason) {
  error_ = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
