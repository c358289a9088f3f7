#include "cli/cansync/parameter/parameter_answer.h"

#include <fmt/format.h>

#include <string_view>

#include "profile/meaning.h"
#include "profile/scaling.h"

namespace cansync::cli {
namespace {

std::string_view format_name(bool doubleword) {
  return doubleword ? "doubleword" : "word";
}

std::string raw_text(std::uint32_t value, bool doubleword) {
  const auto width = doubleword ? Width::doubleword : Width::word;
  const std::int64_t number = as_signed(value, width);
  std::string text = doubleword ? fmt::format("{} (0x{:08X}, doubleword", value, value)
                                : fmt::format("{} (0x{:04X}, word", value, value);
  if (number < 0) text += fmt::format(", signed {}", number);
  return text + ")";
}

/// Does the profile's scaling hold for this value?
bool scales(const KnownRequest& request, const client::ParameterReply& reply) {
  return has_known_value(request) && profile::fits_format(*request.known, reply.doubleword);
}

std::string number_text(const KnownRequest& request, const client::ParameterReply& reply) {
  std::string raw = raw_text(reply.value, reply.doubleword);
  if (request.known == nullptr) return raw;
  if (!scales(request, reply)) return raw + "; " + request.known->name;
  const std::string unit = request.known->unit.empty() ? "" : " " + request.known->unit;
  const std::string value =
      profile::scaled_text(*request.known, profile::raw_number(*request.known, reply.value)) + unit;
  if (request.scaled) {
    return fmt::format("{} ({}, parameter {}, raw {})", value, request.known->name, request.job.number,
                       reply.value);
  }
  return fmt::format("{}; {} {}", raw, request.known->name, value);
}

/// Number and unit, then what they mean, when the profile says so.
std::string value_text(const KnownRequest& request, const client::ParameterReply& reply) {
  const std::string words = scales(request, reply) ? profile::words(*request.known, reply.value) : "";
  return number_text(request, reply) + (words.empty() ? "" : ": " + words);
}

std::string hexadecimal(const client::ParameterReply& reply) {
  return reply.doubleword ? fmt::format("0x{:08X}", reply.value) : fmt::format("0x{:04X}", reply.value);
}

/// What a value means, or its signed number when only its bits are known; empty: nothing to add.
std::string meaning_text(const KnownRequest& request, const client::ParameterReply& reply) {
  if (request.known != nullptr && scales(request, reply)) return profile::words(*request.known, reply.value);
  const std::int64_t number = as_signed(reply.value, reply.doubleword ? Width::doubleword : Width::word);
  return number < 0 ? fmt::format("signed {}", number) : "";
}

std::vector<std::string> reading_cells(Session& session, const KnownRequest& request,
                                       const client::ParameterReply& reply, const Shown& shown) {
  const bool known = request.known != nullptr;
  const bool scaled = known && scales(request, reply);
  std::vector<std::string> cells;
  if (shown.time) cells.push_back(time_text(*shown.time, false));
  cells.push_back(fmt::to_string(request.job.slave));
  cells.push_back(session.slave_name(request.job.slave));
  cells.push_back(fmt::to_string(request.job.number));
  cells.push_back(known ? request.known->name : "-");
  cells.push_back(scaled
                      ? profile::scaled_text(*request.known, profile::raw_number(*request.known, reply.value))
                      : fmt::to_string(reply.value));
  cells.push_back(scaled ? request.known->unit : "");
  cells.push_back(hexadecimal(reply));
  cells.push_back(meaning_text(request, reply));
  return cells;
}

}  // namespace

std::vector<Table::Column> reading_columns(bool timed) {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  std::vector<Table::Column> columns;
  if (timed) columns.push_back({"TIME", left, "with --every: when it was read"});
  columns.push_back({"SLAVE", right, "its number"});
  columns.push_back({"NAME", left, "of the slave, as configured"});
  columns.push_back({"NUMBER", right, "of the parameter"});
  columns.push_back({"PARAMETER", left, "its name in the slave's drive profile; - = not known"});
  columns.push_back(
      {"VALUE", right, "in its unit, by the profile; without a profile as on the bus, decimal"});
  columns.push_back({"UNIT", left, "of the value"});
  columns.push_back({"RAW", left, "as on the bus: four hexadecimal digits are a word, eight a doubleword"});
  columns.push_back(
      {"MEANING", left,
       "of the value, by the profile; without one its signed number when the highest bit is set"});
  return columns;
}

ExitCode finish_parameter(Session& session, const KnownRequest& request, const client::ParameterReply& reply,
                          const Shown& shown) {
  JsonObject object;
  object.add("slave", request.job.slave)
      .add("number", request.job.number)
      .add("element", request.job.element)
      .add("sub_slave", request.job.sub_slave);
  if (reply.ok()) {
    object.add("value", reply.value)
        .add("signed", as_signed(reply.value, reply.doubleword ? Width::doubleword : Width::word))
        .add("format", format_name(reply.doubleword));
  } else {
    object.add_null("value").add_null("signed").add_null("format");
  }
  object.add("error_code", reply.error_code).add("intervals", reply.intervals);
  if (request.known != nullptr) {
    object.add("name", request.known->name).add("unit", request.known->unit);
  } else {
    object.add_null("name").add_null("unit");
  }
  if (reply.ok() && scales(request, reply)) {
    object.add("scaled", profile::scaled(*request.known, profile::raw_number(*request.known, reply.value)));
  } else {
    object.add_null("scaled");
  }
  if (shown.time) object.add("time_ns", *shown.time);
  if (reply.ok() && !session.json()) {
    if (shown.table != nullptr)
      shown.table->add(reading_cells(session, request, reply, shown));
    else
      session.output().line(value_text(request, reply));
  }
  const std::string parameter = request.known != nullptr ? profile::label(*request.known)
                                                         : fmt::format("parameter {}", request.job.number);
  return session.finish(reply, object, fmt::format("slave {}, {}", request.job.slave, parameter));
}

}  // namespace cansync::cli
