#include <fmt/format.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <span>
#include <system_error>

#include "cli/base/child_process.h"
#include "cli/base/files.h"
#include "cli/base/verb_groups.h"
#include "cli/record/plot_data.h"
#include "cli/record/plot_script.h"
#include "cli/record/verbs.h"

namespace cansync::cli {
namespace {

/// The arguments as they were typed.
struct PlotTexts {
  std::string file;
  std::string output;
  std::vector<std::string> values;
  std::string slaves;
  std::string title;
};

PlotFormat format_of(const std::string& output) {
  if (output.ends_with(".svg")) return PlotFormat::svg;
  if (output.ends_with(".png")) return PlotFormat::png;
  throw UsageError(fmt::format("--output: found '{}'; allowed: a name that ends with .svg or .png", output));
}

PlotData read_file_to_plot(const PlotTexts& texts) {
  if (texts.file == "-") return read_recording(std::cin, "standard input", texts.values, texts.slaves);
  std::ifstream file(texts.file, std::ios::binary);
  if (!file) throw std::system_error(errno, std::generic_category(), texts.file);
  return read_recording(file, texts.file, texts.values, texts.slaves);
}

std::string drawn(const std::string& script) {
  try {
    // -d: nobody's own settings.
    const ChildResult result = run_child({"gnuplot", "-d"}, script);
    if (result.status == 0 && !result.output.empty()) return result.output;
    throw std::runtime_error(
        fmt::format("gnuplot has failed with code {}: {}", result.status, result.errors));
  } catch (const NoProgram&) {
    throw std::runtime_error("gnuplot is not installed; plots need it: apt install gnuplot-nox");
  }
}

/// "run.svg" for "run.csv" unless a name was given.
std::string output_of(const PlotTexts& texts) {
  if (!texts.output.empty()) return texts.output;
  if (texts.file == "-") throw UsageError("--output: found nothing with FILE '-'; allowed: a picture's name");
  return std::filesystem::path(texts.file).replace_extension(".svg").string();
}

ExitCode plot_verb(Session& session, const PlotTexts& texts) {
  const std::string output = output_of(texts);
  const PlotFormat format = format_of(output);
  session.expect_input(texts.file);
  const PlotData data = read_file_to_plot(texts);
  if (data.broken_off)
    session.output().remark(fmt::format("{}: the last line is not complete and is left out", texts.file));
  if (data.panels.empty())
    throw std::runtime_error(fmt::format("{}: nothing to plot, there are no values in it", texts.file));
  const std::string picture =
      drawn(plot_script(data, texts.title.empty() ? texts.file : texts.title, format));
  ReplacementFile file(output);
  file.commit(std::span(reinterpret_cast<const std::uint8_t*>(picture.data()), picture.size()));
  if (!session.json()) {
    if (texts.output.empty()) session.output().remark(output + " is written");
    return ExitCode::done;
  }
  JsonArray values;
  for (const Panel& panel : data.panels) values.add(panel.heading);
  JsonArray slaves;
  for (const unsigned slave : data.slaves) slaves.add(slave);
  session.output().object(JsonObject()
                              .add("file", texts.file)
                              .add("output", output)
                              .add("slaves", slaves)
                              .add("values", values)
                              .add("rows", data.rows));
  return ExitCode::done;
}

}  // namespace

void add_plot_verb(CLI::App& app, Verb& chosen) {
  auto* plot = app.add_subcommand("plot", "draws a recording (record) as SVG or PNG, with gnuplot");
  plot->group(kLookingVerbs);
  auto texts = std::make_shared<PlotTexts>();
  plot->add_option("FILE", texts->file, "a recording; - = standard input")->required();
  plot->add_option("-o,--output", texts->output,
                   "the picture, whose name ends with .svg or .png; is replaced (default: that of FILE with "
                   ".svg)")
      ->type_name("PICTURE");
  plot->add_option("--values", texts->values, "these alone, by name, with commas (default: all)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAMES");
  plot->add_option("--slaves", texts->slaves, "these alone: 0,4-7,winder, or a mask 0x... (default: all)")
      ->type_name("SET");
  plot->add_option("--title", texts->title, "above the plot (default: the name of the file)")
      ->type_name("WORDS");
  plot->footer(
      "One panel for each value with a curve for each slave. Of long recordings the least and the greatest "
      "value\n"
      "of each stretch of time are drawn. No daemon is needed; gnuplot (Debian: gnuplot-nox) is.");
  plot->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return plot_verb(session, *texts); }; });
}

}  // namespace cansync::cli
