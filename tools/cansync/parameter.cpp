#include <fmt/format.h>

#include <memory>

#include "cansync/verbs.h"

namespace cansync::cli {
namespace {

/// The arguments as they were typed.
struct ParameterOptions {
  std::string slave;
  std::string number;
  std::string value;  ///< write
  std::string element = "7";
  std::string sub_slave = "0";
  std::string format = "auto";
};

client::ParameterFormat parse_format(std::string_view text) {
  if (text == "word") return client::ParameterFormat::word;
  if (text == "doubleword") return client::ParameterFormat::doubleword;
  if (text == "auto") return client::ParameterFormat::as_slave_says;
  throw UsageError(fmt::format("--format: found '{}'; allowed: word, doubleword, auto", text));
}

/// Everything but the value. Numbers are checked before the slave's name, so that a wrong one is told without
/// a daemon.
client::ParameterRequest parse_request(Session& session, const ParameterOptions& options) {
  client::ParameterRequest request;
  request.number = static_cast<std::uint32_t>(parse_integer(options.number, "NUMBER", 0, 4095));
  request.element = static_cast<std::uint32_t>(parse_integer(options.element, "--element", 0, 7));
  request.sub_slave = static_cast<std::uint32_t>(parse_integer(options.sub_slave, "--sub-slave", 0, 65535));
  request.format = parse_format(options.format);
  request.timeout_ms = session.monitoring_ms();
  request.slave = session.slave(options.slave);
  return request;
}

std::string_view format_name(bool doubleword) {
  return doubleword ? "doubleword" : "word";
}

std::string value_text(std::uint32_t value, bool doubleword) {
  const auto width = doubleword ? Width::doubleword : Width::word;
  const std::int64_t number = as_signed(value, width);
  std::string text = doubleword ? fmt::format("{} (0x{:08X}, doubleword", value, value)
                                : fmt::format("{} (0x{:04X}, word", value, value);
  if (number < 0) text += fmt::format(", signed {}", number);
  return text + ")";
}

ExitCode finish(Session& session, const client::ParameterRequest& request,
                const client::ParameterReply& reply) {
  JsonObject object;
  object.add("slave", request.slave)
      .add("number", request.number)
      .add("element", request.element)
      .add("sub_slave", request.sub_slave);
  if (reply.ok()) {
    object.add("value", reply.value)
        .add("signed", as_signed(reply.value, reply.doubleword ? Width::doubleword : Width::word))
        .add("format", format_name(reply.doubleword));
  } else {
    object.add_null("value").add_null("signed").add_null("format");
  }
  object.add("error_code", reply.error_code).add("intervals", reply.intervals);
  if (reply.ok() && !session.json()) session.output().line(value_text(reply.value, reply.doubleword));
  return session.finish(reply, object, fmt::format("slave {}, parameter {}", request.slave, request.number));
}

ExitCode run_job(Session& session, const client::ParameterRequest& request) {
  return finish(session, request, session.wait(session.client().submit(request)));
}

ExitCode read_verb(Session& session, const ParameterOptions& options) {
  return run_job(session, parse_request(session, options));
}

ExitCode write_verb(Session& session, const ParameterOptions& options) {
  using Format = client::ParameterFormat;
  const auto width_of = [](Format format) {
    return format == Format::word ? Width::word : Width::doubleword;
  };
  const Format typed = parse_format(options.format);
  // Told before anything is sent; with `auto` a doubleword is the widest the slave can have.
  static_cast<void>(parse_raw(options.value, "VALUE", width_of(typed)));
  client::ParameterRequest request = parse_request(session, options);
  request.write = true;
  if (request.format == Format::as_slave_says && options.value.starts_with('-')) {
    // The two's complement depends on the width, which only the slave knows.
    client::ParameterRequest ask = request;
    ask.write = false;
    const client::ParameterReply reply = session.wait(session.client().submit(ask));
    if (!reply.ok()) return finish(session, request, reply);
    request.format = reply.doubleword ? Format::doubleword : Format::word;
  }
  request.value = parse_raw(options.value, "VALUE", width_of(request.format));
  return run_job(session, request);
}

void add_common(CLI::App& verb, ParameterOptions& options) {
  verb.add_option("--element", options.element, "element 0..7 of the parameter; 7 = the value (default)")
      ->type_name("E");
  verb.add_option("--sub-slave", options.sub_slave,
                  "participant below the slave, 0..65535; 0 = the slave itself (default)")
      ->type_name("S");
  verb.add_option("--format", options.format, "width of the value; auto = as the slave says (default)")
      ->type_name("word|doubleword|auto");
}

}  // namespace

void add_parameter_verbs(CLI::App& app, Verb& chosen) {
  auto* read = app.add_subcommand("read", "read a parameter of a slave");
  auto read_options = std::make_shared<ParameterOptions>();
  read->add_option("SLAVE", read_options->slave, "number 0..31 or name")->required();
  read->add_option("NUMBER", read_options->number, "parameter number 0..4095")->required();
  add_common(*read, *read_options);
  read->footer(
      "Prints the value in decimal, in hexadecimal, its format, and, when its highest bit is set, its signed "
      "value.");
  read->callback([read_options, &chosen] {
    chosen = [read_options](Session& session) { return read_verb(session, *read_options); };
  });

  auto* write = app.add_subcommand("write", "write a parameter of a slave");
  auto write_options = std::make_shared<ParameterOptions>();
  write->add_option("SLAVE", write_options->slave, "number 0..31 or name")->required();
  write->add_option("NUMBER", write_options->number, "parameter number 0..4095")->required();
  write
      ->add_option("VALUE", write_options->value,
                   "decimal, hexadecimal (0x..) or negative; raw, as on the bus")
      ->required();
  add_common(*write, *write_options);
  write->footer(
      "Prints what was written, as `read` does. With --format auto the parameter is read first, so that it "
      "is written\n"
      "in the slave's own format. Exit code 5 after `no_answer`: whether the slave took the value is not "
      "known.");
  write->callback([write_options, &chosen] {
    chosen = [write_options](Session& session) { return write_verb(session, *write_options); };
  });
}

}  // namespace cansync::cli
