#include "profile/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "config/document.h"
#include "profile/hash.h"
#include "profile/reader_fields.h"
#include "profile/scaling.h"
#include "profile/source.h"
#include "text/text_file.h"

namespace profile {
namespace {

using config::Content;
using config::Node;
using config::Problem;
using detail::Fields;

constexpr config::Wording kWording{
    .unreadable = "cannot read this profile: ",
    .allowed = "[profile], [[parameter]], key = value, # comment",
};
constexpr std::int64_t kHighestNumber = 4095;
constexpr std::int64_t kHighestValue = 7;
constexpr std::size_t kLongestUnit = 16;
constexpr std::size_t kLongestText = 200;
/// How far, in raw steps, a limit may lie beside a raw number and still mean it: what doubles round.
constexpr double kRounding = 1e-6;

/// One limit in engineering units as a raw number: the last one that keeps it.
double raw_limit(const Parameter& parameter, double limit, bool lower) {
  const double raw = (limit - parameter.offset) / parameter.factor;
  const double near = std::round(raw);
  if (std::abs(raw - near) <= kRounding * std::max(1.0, std::abs(raw))) return near;
  return lower ? std::ceil(raw) : std::floor(raw);
}

/// Puts `limit` into the parameter; a problem when the format cannot hold it.
void set_limit(Fields& fields, std::string_view key, double limit, Parameter& parameter) {
  // A negative factor turns the order around.
  const bool lower = (key == "minimum") == (parameter.factor > 0.0);
  const double raw = raw_limit(parameter, limit, lower);
  if (!(raw >= static_cast<double>(format_minimum(parameter)) &&
        raw <= static_cast<double>(format_maximum(parameter)))) {
    Parameter whole = parameter;
    whole.limited = true;
    whole.minimum = format_minimum(parameter);
    whole.maximum = format_maximum(parameter);
    fields.problem(
        key, fmt::format("found {}, which is raw {:.0f}; allowed with format \"{}\"{}: {}", limit, raw,
                         name(parameter.format), parameter.is_signed ? ", signed" : "", limits_text(whole)));
    return;
  }
  (lower ? parameter.minimum : parameter.maximum) = static_cast<std::int64_t>(raw);
  parameter.limited = true;
}

void read_scaling(Fields& fields, Parameter& parameter) {
  parameter.unit = fields.word("unit", kLongestUnit).value_or("");
  const auto factor = fields.number("factor");
  if (factor && *factor == 0.0) {
    fields.problem("factor", "found 0; allowed: a finite number other than 0");
  } else {
    parameter.factor = factor.value_or(1.0);
  }
  parameter.offset = fields.number("offset").value_or(0.0);
  parameter.minimum = format_minimum(parameter);
  parameter.maximum = format_maximum(parameter);
  const auto minimum = fields.number("minimum");
  const auto maximum = fields.number("maximum");
  if (minimum && maximum && *minimum > *maximum) {
    fields.problem("minimum", fmt::format("found {}, over the maximum {}; allowed: at most the maximum",
                                          *minimum, *maximum));
    return;
  }
  if (minimum) set_limit(fields, "minimum", *minimum, parameter);
  if (maximum) set_limit(fields, "maximum", *maximum, parameter);
  if (parameter.minimum > parameter.maximum) {
    fields.problem("minimum", fmt::format("no value lies between {} and {} with factor {} and offset {}",
                                          *minimum, *maximum, parameter.factor, parameter.offset));
  }
}

void read_access(Fields& fields, Parameter& parameter) {
  constexpr Access kAccess[] = {Access::read_write, Access::read_only, Access::none};
  constexpr Identity kIdentity[] = {Identity::type, Identity::unit};
  if (const auto place = fields.choice("access", {"read-write", "read-only", "none"})) {
    parameter.access = kAccess[*place];
  }
  parameter.is_volatile = fields.flag("volatile").value_or(false);
  const auto identity = fields.choice("identity", {"type", "unit"});
  if (!identity) return;
  parameter.identity = kIdentity[*identity];
  if (parameter.access != Access::read_only || parameter.is_volatile) {
    fields.problem("identity",
                   "found beside a parameter that is not read-only or is volatile; allowed: with access = "
                   "\"read-only\" and without volatile");
  }
}

/// As the file has it; not for `none`.
std::string_view tells_word(Tells tells) {
  constexpr std::string_view kWords[] = {"status-word",         "block-limit",      "reference-mapping-1",
                                         "reference-mapping-2", "actual-mapping-1", "actual-mapping-2"};
  return kWords[static_cast<std::size_t>(tells) - 1];
}

/// What a scan of a line takes from the parameter.
void read_scanning(Fields& fields, Parameter& parameter) {
  constexpr Tells kTells[] = {Tells::status_word,         Tells::block_limit,      Tells::reference_mapping_1,
                              Tells::reference_mapping_2, Tells::actual_mapping_1, Tells::actual_mapping_2};
  if (const auto place =
          fields.choice("tells", {"status-word", "block-limit", "reference-mapping-1", "reference-mapping-2",
                                  "actual-mapping-1", "actual-mapping-2"})) {
    parameter.tells = kTells[*place];
    const bool mapping = parameter.tells != Tells::status_word && parameter.tells != Tells::block_limit;
    if (parameter.access == Access::none)
      fields.problem("tells", "found beside access = \"none\"; allowed: with a parameter that can be read");
    else if (mapping && parameter.format != Format::doubleword)
      fields.problem("tells",
                     "found a mapping with format \"word\"; allowed: four register bytes, \"doubleword\"");
  }
  if (const auto value = fields.integer("actual_value", 0, kHighestValue))
    parameter.actual_value = static_cast<std::uint8_t>(*value);
}

Parameter read_parameter(Fields& fields) {
  fields.only({"number", "name", "format", "signed", "unit", "factor", "offset", "minimum", "maximum",
               "access", "volatile", "identity", "tells", "actual_value", "group", "text", "bits", "values"});
  fields.require("number", "0..4095");
  fields.require("name", "1..64 lower-case letters, digits and '-'");
  fields.require("format", "\"word\", \"doubleword\"");
  fields.require("access", "\"read-write\", \"read-only\", \"none\"");
  Parameter parameter;
  parameter.number = static_cast<std::uint16_t>(fields.integer("number", 0, kHighestNumber).value_or(0));
  parameter.name = fields.name("name").value_or("");
  const auto format = fields.choice("format", {"word", "doubleword"});
  parameter.format = format == std::optional<std::size_t>{1} ? Format::doubleword : Format::word;
  parameter.is_signed = fields.flag("signed").value_or(false);
  read_scaling(fields, parameter);
  read_access(fields, parameter);
  read_scanning(fields, parameter);
  parameter.group = fields.name("group").value_or("");
  parameter.text = fields.text("text", kLongestText).value_or("");
  const bool doubleword = parameter.format == Format::doubleword;
  parameter.bits = fields.meanings("bits", doubleword ? 31 : 15);
  parameter.values = fields.meanings("values", doubleword ? 0xFFFFFFFF : 0xFFFF);
  return parameter;
}

/// Reads one profile; collects problems on the way.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  Reading read(const config::Document& document) {
    problems_ = document.problems;
    const Content root(document, nullptr);
    Profile profile;
    for (const Node* node : root.nodes()) {
      if (node->name() == "profile" && node->kind == Node::Kind::section) {
        head(Content(document, node), profile);
      } else if (node->name() == "parameter" && node->kind == Node::Kind::sections) {
        for (const Node* section : root.each("parameter")) parameter(Content(document, section), profile);
      } else {
        problems_.push_back({node->key, node->name(),
                             "no section of a profile; allowed: [profile] once, [[parameter]] for each "
                             "parameter"});
      }
    }
    if (root.find("profile") == nullptr) {
      missing("profile", "is missing; allowed: a section [profile] with a name");
    }
    if (root.find("parameter") == nullptr) {
      missing("parameter", "is missing; allowed: at least one section [[parameter]]");
    }
    return result(std::move(profile));
  }

 private:
  void missing(std::string section, std::string text) {
    problems_.push_back({{file_, 1, 1}, std::move(section), std::move(text)});
  }

  void head(const Content& content, Profile& profile) {
    Fields fields(content, "profile", problems_);
    fields.only({"name", "text", "recognised_by"});
    fields.require("name", "1..64 lower-case letters, digits and '-', the same as the file's name");
    profile.name = fields.name("name").value_or("");
    profile.text = fields.text("text", kLongestText).value_or("");
    profile.recognised_by = fields.recognitions("recognised_by");
  }

  void parameter(const Content& content, Profile& profile) {
    const std::size_t before = problems_.size();
    Fields fields(content, "parameter", problems_);
    Parameter parameter = read_parameter(fields);
    if (fields.has("number")) unique(fields, "number", std::to_string(parameter.number), content, numbers_);
    if (!parameter.name.empty()) unique(fields, "name", "\"" + parameter.name + "\"", content, names_);
    if (parameter.tells != Tells::none)
      unique(fields, "tells", fmt::format("\"{}\"", tells_word(parameter.tells)), content, tells_);
    if (parameter.actual_value)
      unique(fields, "actual_value", std::to_string(*parameter.actual_value), content, actual_values_);
    if (problems_.size() == before) profile.parameters.push_back(std::move(parameter));
  }

  /// A problem when something is there twice.
  static void unique(Fields& fields, std::string_view key, const std::string& found, const Content& content,
                     std::map<std::string, std::uint32_t>& seen) {
    const auto [first, fresh] = seen.emplace(found, content.where().line);
    if (fresh) return;
    fields.problem(key, fmt::format("found {} again, first used by the parameter in line {}; allowed: each "
                                    "{} once",
                                    found, first->second, key));
  }

  Reading result(Profile profile) {
    config::sort_by_place(problems_);
    Reading reading;
    reading.problems = std::move(problems_);
    if (profile.name.empty() || profile.parameters.empty()) return reading;
    std::sort(profile.parameters.begin(), profile.parameters.end(),
              [](const Parameter& a, const Parameter& b) { return a.number < b.number; });
    reading.profile = std::move(profile);
    return reading;
  }

  std::string file_;
  std::vector<Problem> problems_;
  std::map<std::string, std::uint32_t> numbers_;
  std::map<std::string, std::uint32_t> names_;
  std::map<std::string, std::uint32_t> tells_;
  std::map<std::string, std::uint32_t> actual_values_;
};

/// A problem of the file as a whole.
Reading failed(const std::string& file, std::string text) {
  return {std::nullopt, {{{file, 0, 0}, "", std::move(text)}}};
}

}  // namespace

Reading parse(std::string_view toml, const std::string& file) {
  const config::Document document = config::parse_document_in_part(toml, file, kWording);
  if (document.nodes.empty() && !document.problems.empty()) return {std::nullopt, document.problems};
  Reading reading = Reader(file).read(document);
  if (reading.profile) {
    reading.profile->hash = sha256(toml);
    keep_source(reading.profile->hash, toml);
  }
  return reading;
}

Reading read(const std::string& path) {
  const auto content = text::read_file(path, kFileLimit);
  if (const auto* problem = std::get_if<text::FileProblem>(&content)) {
    return failed(path, std::string(kWording.unreadable) + problem->text);
  }
  Reading reading = parse(std::get<std::string>(content), path);
  if (!reading.profile) return reading;
  const std::string stem = std::filesystem::path(path).stem().string();
  if (reading.profile->name == stem) return reading;
  // Whoever knows the name alone finds the file by it.
  return failed(path,
                fmt::format("profile.name: found \"{}\" in a file called {}.toml; allowed: the same name",
                            reading.profile->name, stem));
}

}  // namespace profile
