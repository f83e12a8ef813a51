// `latelight compare A B`: compares two files output by output and reports if they agree within tolerance.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "base/files.h"
#include "base/log.h"
#include "base/text.h"
#include "output/compare_outputs.h"
#include "output/files.h"
#include "output/used_files.h"

namespace latelight::app {
namespace {

using Json = nlohmann::ordered_json;
using output::Measure;
using output::OutputDifference;

struct Arguments {
  std::string first, second;
  std::string tolerances;  // "T" or "OUTPUT=T", comma-separated
  double share = 0;
  double flip = -1;  // below 0: colors are judged by the tolerance
  std::optional<double> pixelsPerDegree;
  std::string difference;
  std::vector<std::string> channels;
  bool json = false;
};

// --- results ---------------------------------------------------------------------------------------------------------

// JSON has neither infinity nor NaN.
Json number(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? Json(nullptr) : Json("inf");
}

std::string_view nameOf(Measure measure) {
  switch (measure) {
    case Measure::Color:
      return "color";
    case Measure::Relative:
      return "relative";
    case Measure::Angle:
      return "degrees";
    case Measure::Identity:
      return "identity";
    case Measure::Pixels:
      return "pixels";
    case Measure::Difference:
      return "difference";
  }
  return "";
}

Json describe(const OutputDifference& d, bool alike) {
  Json json{{"alike", alike},         {"measure", nameOf(d.measure)},
            {"channels", d.channels}, {"maximum", number(d.maximum)},
            {"mean", number(d.mean)}, {"share", d.share()},
            {"beyond", d.beyond},     {"pixels", d.pixels},
            {"unlike", d.unlike},     {"worst", {{"x", d.worstX}, {"y", d.worstY}}}};
  if (d.measure == Measure::Color) {
    json["psnr"] = number(d.psnr);
    json["flip"] = d.flip;
  }
  if (!d.worstChannel.empty()) json["worst"]["channel"] = d.worstChannel;
  return json;
}

std::string errorsOf(const OutputDifference& d) {
  if (d.measure == Measure::Identity) return "";
  const std::string_view unit = output::unitOf(d.measure);
  std::string text =
      fmt::format("{}maximum {:.6g}", d.measure == Measure::Relative ? "relative error: " : "", d.maximum);
  if (!unit.empty()) text += fmt::format(" {}", unit);
  if (d.maximum > 0 && !d.worstChannel.empty())
    text += fmt::format(" (channel {} at {},{})", printable(d.worstChannel), d.worstX, d.worstY);
  else if (d.maximum > 0)
    text += fmt::format(" (at {},{})", d.worstX, d.worstY);
  text += fmt::format(", mean {:.6g}, ", d.mean);
  if (d.measure == Measure::Color) {
    const std::string psnr = std::isnan(d.psnr) ? "undefined" : fmt::format("{:.2f} dB", d.psnr);
    text += fmt::format("PSNR {}, FLIP {:.4f}, ", psnr, d.flip);
  }
  return text;
}

void printText(const OutputDifference& d, size_t width) {
  fmt::print("{:<{}}  {}{} {:.6g} % of the pixels ({} of {})\n", printable(d.output), width, errorsOf(d),
             d.measure == Measure::Identity ? "different in" : "beyond the tolerance in", d.share() * 100, d.beyond,
             d.pixels);
  if (d.unlike > 0 && d.measure != Measure::Identity)
    fmt::print("{:<{}}  {} {} are infinite, NaN or background in one file only\n", "", width, d.unlike,
               d.worstChannel.empty() ? "pixels" : "values");
}

// --- arguments -------------------------------------------------------------------------------------------------------

double toleranceOf(std::string_view text) {
  const std::optional<double> value = parseNumber<double>(text);
  if (!value || *value < 0)
    badUsage("--tolerance takes a number from 0 upwards, or OUTPUT=NUMBER, as in depth=1e-3, not \"{}\"", text);
  return *value;
}

output::OutputOptions optionsOf(const Arguments& arguments) {
  output::OutputOptions options{.channels = arguments.channels,
                                .pixelsPerDegree = arguments.pixelsPerDegree.value_or(output::kPixelsPerDegree)};
  if (arguments.tolerances.empty()) return options;
  for (const std::string_view text : splitAtCommas(arguments.tolerances)) {
    const size_t equals = text.find('=');
    if (equals == std::string_view::npos) {
      if (options.tolerance) badUsage("--tolerance has two numbers for all outputs: omit one");
      options.tolerance = toleranceOf(text);
      continue;
    }
    const std::string name(text.substr(0, equals));
    if (!options.tolerances.try_emplace(name, toleranceOf(text.substr(equals + 1))).second)
      badUsage("--tolerance has two numbers for \"{}\": omit one", name);
  }
  return options;
}

bool isAlike(const OutputDifference& d, const Arguments& arguments) {
  if (d.measure == Measure::Color && arguments.flip >= 0) return d.flip <= arguments.flip;
  return d.share() <= arguments.share;
}

// Returns, per pixel, the worst excess of all outputs.
std::vector<double> worstOf(const std::vector<OutputDifference>& differences) {
  std::vector<double> worst = differences.front().excesses;
  for (const OutputDifference& d : differences)
    for (size_t i = 0; i < worst.size(); ++i) worst[i] = std::max(worst[i], d.excesses[i]);
  return worst;
}

void print(const std::vector<OutputDifference>& differences, const Arguments& arguments, bool alike) {
  if (arguments.json) {
    Json json{{"alike", alike}, {"outputs", Json::object()}};
    for (const OutputDifference& d : differences) json["outputs"][d.output] = describe(d, isAlike(d, arguments));
    // Channel names come from the files and need not be UTF-8.
    return fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
  }
  fmt::print("{}\n", alike ? "alike" : "not alike");
  size_t width = 0;
  for (const OutputDifference& d : differences) width = std::max(width, d.output.size());
  for (const OutputDifference& d : differences) printText(d, width);
}

// Checks the file of --diff before any work. Standard output receives the report.
void checkDifference(const Arguments& arguments) {
  if (arguments.difference == "-")
    badUsage("--diff - and the report both write to standard output; give --diff a name that ends in .png");
  if (!output::isPngName(arguments.difference))
    badUsage("--diff writes PNG; give it a name that ends in .png, not \"{}\"", arguments.difference);
  const std::filesystem::path inputs[] = {arguments.first, arguments.second}, outputs[] = {arguments.difference};
  output::UsedFiles(inputs).checkOutputs(outputs);
  checkWritable(arguments.difference);
}

// Only colors have a FLIP.
void checkFlip(const std::vector<OutputDifference>& differences, const Arguments& arguments) {
  if (std::ranges::find(differences, Measure::Color, &OutputDifference::measure) != differences.end()) return;
  if (arguments.flip >= 0) badUsage("--flip judges colors, and none are compared: omit it, or use --tolerance");
  if (arguments.pixelsPerDegree) badUsage("--ppd applies to the FLIP of colors, and none are compared: omit it");
}

void run(const Arguments& arguments) {
  const output::OutputOptions options = optionsOf(arguments);
  if (!arguments.difference.empty()) checkDifference(arguments);
  const output::ReadImage a = output::asOutput(output::readImage(arguments.first), arguments.first);
  const output::ReadImage b = output::asOutput(output::readImage(arguments.second), arguments.second);
  const std::vector<OutputDifference> differences = output::compareOutputs(a, b, options);
  checkFlip(differences, arguments);
  const bool alike = std::ranges::all_of(differences, [&](const auto& d) { return isAlike(d, arguments); });
  if (!arguments.difference.empty())
    output::writePicture(arguments.difference, output::differencePicture(a.width, a.height, worstOf(differences)));
  print(differences, arguments, alike);
  // For this command 1 means "different", not an internal error.
  if (!alike) throw Exit{static_cast<ExitCode>(1)};
}

}  // namespace

void addCompareCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "compare", "Measure how far two files are apart, output by output; exits 0 if alike, 1 if not");
  command->add_option("A", arguments->first, "A .png, .exr or .npy file")->required();
  command->add_option("B", arguments->second, "Another of the same size and channels")->required();
  command
      ->add_option(
          "--tolerance", arguments->tolerances,
          "Largest error of a pixel: T for all outputs except ids, or OUTPUT=T, comma-separated. Colors: |a-b| <= T "
          "max(1, |a|, |b|), PNG values being in [0, 1]; default: one level for 8 and 16 bits, 1e-4 for floats. Colors "
          "of a PNG are converted to linear, premultiplied ones if the other file is an EXR or NPY. "
          "Depth, distance and positions: relative, 1e-4. Normals and tangents: degrees, 0.01. Motion: pixels, 0.01. "
          "Ids and triangles: equal. All others: as colors")
      ->type_name("LIST");
  command
      ->add_option("--share", arguments->share,
                   "Alike if at most this share of each output's pixels is beyond; default 0")
      ->check(CLI::Range(0.0, 1.0));
  command
      ->add_option("--flip", arguments->flip,
                   "Judge colors by their mean FLIP instead: alike if it is at most this value")
      ->check(CLI::Range(0.0, 1.0));
  command
      ->add_option("--ppd", arguments->pixelsPerDegree,
                   "Pixels per degree of FLIP's observer; 67: 0.7 m from a screen 0.7 m wide with 3840 pixels across")
      ->default_str(fmt::format("{:g}", output::kPixelsPerDegree))
      ->check(CLI::Range(1.0, 1000.0));
  command->add_option("--channel", arguments->channels, "Compare only these channels, for example R,G,B or Z")
      ->type_name("LIST")
      ->delimiter(',');
  command
      ->add_option(
          "--diff", arguments->difference,
          "Write a PNG file of the worst output of each pixel: gray within the tolerance, yellow to red beyond it")
      ->type_name("FILE");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace latelight::app
