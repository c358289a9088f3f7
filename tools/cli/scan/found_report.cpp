#include "cli/scan/found_report.h"

#include <fmt/format.h>

#include "cli/text/column_help.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

constexpr auto kFoundToTheRight = Table::Align::right;

std::vector<Table::Column> found_slave_columns() {
  return {{"SLAVE", kFoundToTheRight, "its number"},
          {"STATUS", Table::Align::left, "its status word; - = not under the number that is asked"},
          {"PARAMETER", kFoundToTheRight, "number of the status word"},
          {"PROFILE", Table::Align::left, "the drive profile that it is recognised by; - = none"},
          {"BLOCK", kFoundToTheRight, "longest block of an upload in bytes; - = not told"},
          {"MAPPING", Table::Align::left, "the drive tells which words of its telegrams are what"},
          {"READ", kFoundToTheRight, "parameters that were read"}};
}

/// The registers of a mapping that the drive told; nothing when it did not.
void add_mapping(JsonObject& object, const char* key, const std::optional<TelegramMapping>& mapping) {
  if (!mapping) {
    object.add_null(key);
    return;
  }
  JsonArray registers;
  for (const WordMapping& word : mapping->word) registers.add(unsigned{to_register(word)});
  object.add(key, registers);
}

JsonObject answer_object(const FoundSlave& slave) {
  JsonObject object;
  object.add("kind", "answer").add("slave", unsigned{slave.number.value()});
  slave.status_word ? object.add("status_word", unsigned{*slave.status_word})
                    : object.add_null("status_word");
  object.add("status_parameter", unsigned{slave.status_parameter});
  slave.profile ? object.add("profile", slave.profile->name) : object.add_null("profile");
  slave.block_limit ? object.add("block_limit", unsigned{*slave.block_limit})
                    : object.add_null("block_limit");
  add_mapping(object, "reference_registers_1", slave.reference[0]);
  add_mapping(object, "reference_registers_2", slave.reference[1]);
  add_mapping(object, "actual_registers_1", slave.actual[0]);
  add_mapping(object, "actual_registers_2", slave.actual[1]);
  object.add("twice", slave.twice);
  return object;
}

JsonObject parameter_object(const FoundSlave& slave, const FoundParameter& parameter) {
  JsonObject object;
  object.add("kind", "parameter").add("slave", unsigned{slave.number.value()});
  object.add("parameter", unsigned{parameter.number});
  if (parameter.error != 0)
    object.add_null("value").add_null("doubleword").add("error", unsigned{parameter.error});
  else
    object.add("value", parameter.value).add("doubleword", parameter.doubleword).add_null("error");
  return object;
}

}  // namespace

void write_found_slaves(Output& output, const InquiryResult& result) {
  Table table(found_slave_columns());
  for (const FoundSlave& slave : result.slaves) {
    if (output.json()) {
      output.object(answer_object(slave));
      for (const FoundParameter& parameter : slave.parameters)
        output.object(parameter_object(slave, parameter));
      continue;
    }
    const bool told = slave.actual[0] || slave.actual[1];
    table.add({fmt::format("{}", slave.number.value()),
               slave.status_word ? fmt::format("0x{:04X}", *slave.status_word) : "-",
               fmt::format("{}", slave.status_parameter), slave.profile ? slave.profile->name : "-",
               slave.block_limit ? fmt::format("{}", *slave.block_limit) : "-", told ? "told" : "not told",
               fmt::format("{}", slave.parameters.size())});
  }
  if (output.json()) return;
  output.line("");
  if (table.lines().empty())
    output.line("No slave answered.");
  else
    output.table(table);
  for (const FoundSlave& slave : result.slaves) {
    if (slave.twice)
      output.line(
          fmt::format("Two drives answer as slave {0}. Disconnect one, or give it another number, then scan "
                      "again; what is shown of slave {0} may be of either.",
                      slave.number.value()));
  }
}

std::string found_tables_help() {
  std::vector<Explained> entries;
  for (const Table::Column& column : found_slave_columns()) entries.emplace_back(column.heading, column.help);
  return explanation("Slaves that answer", entries);
}

}  // namespace cansync::cli
