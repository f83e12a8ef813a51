// latelight compare A B: how much two pictures differ, and whether that is within tolerance.
#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/commands.h"
#include "base/files.h"
#include "base/log.h"
#include "output/compare.h"
#include "output/files.h"
#include "output/used_files.h"

namespace latelight::app {
namespace {

struct Arguments {
  std::string first, second;
  double tolerance = -1;  // below 0: from the files' types
  double share = 0;
  std::string difference;
  std::vector<std::string> channels;
  bool json = false;
};

nlohmann::ordered_json number(double value) {
  if (std::isfinite(value)) return value;
  return "inf";
}

void printJson(const output::Comparison& c, bool alike) {
  const nlohmann::ordered_json json{{"alike", alike},
                                    {"maximum", number(c.maximum)},
                                    {"mean", number(c.mean)},
                                    {"psnr", number(c.psnr)},
                                    {"share", c.share()},
                                    {"beyond", c.beyond},
                                    {"pixels", c.pixels},
                                    {"unlike", c.unlike},
                                    {"worst", {{"x", c.worstX}, {"y", c.worstY}, {"channel", c.worstChannel}}}};
  // Channel names come from the files and need not be UTF-8.
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void printText(const output::Comparison& c, bool alike) {
  fmt::print("{}\n", alike ? "alike" : "not alike");
  fmt::print("maximum  {:.6g}", c.maximum);
  if (c.maximum > 0) fmt::print("  (channel {} at {},{})", printable(c.worstChannel), c.worstX, c.worstY);
  fmt::print("\nmean     {:.6g}\n", c.mean);
  fmt::print("PSNR     {:.2f} dB\n", c.psnr);
  fmt::print("beyond   {:.6g} % of the pixels ({} of {})\n", c.share() * 100, c.beyond, c.pixels);
  if (c.unlike > 0) fmt::print("unlike   {} values are infinite or NaN in one picture only\n", c.unlike);
}

void run(const Arguments& arguments) {
  if (std::isnan(arguments.tolerance) || std::isnan(arguments.share))
    badUsage("--tolerance and --share take numbers, and nan is none");
  output::CompareOptions options;
  options.channels = arguments.channels;
  if (!arguments.difference.empty()) {
    const std::filesystem::path inputs[] = {arguments.first, arguments.second}, outputs[] = {arguments.difference};
    output::UsedFiles(inputs).checkOutputs(outputs);
    checkWritable(arguments.difference);
  }
  if (arguments.tolerance >= 0) options.tolerance = arguments.tolerance;
  const output::ReadImage a = output::readImage(arguments.first);
  const output::ReadImage b = output::readImage(arguments.second);
  const output::Comparison comparison = output::compare(a, b, options);
  const bool alike = comparison.share() <= arguments.share;
  if (!arguments.difference.empty()) {
    output::writePicture(arguments.difference, output::differencePicture(a, b, options));
  }
  arguments.json ? printJson(comparison, alike) : printText(comparison, alike);
  // For this command 1 means "different", not an internal error.
  if (!alike) throw Exit{static_cast<ExitCode>(1)};
}

}  // namespace

void addCompareCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("compare", "Say how far two pictures are apart; exits 0 if alike, 1 if not");
  command->add_option("A", arguments->first, "A .png, .exr or .npy file")->required();
  command->add_option("B", arguments->second, "Another of the same size and channels")->required();
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "A value is beyond it if |a-b| > T max(1, |a|, |b|), PNG values being in [0, 1]; default: one level "
                   "for 8 and 16 bits, 1e-4 for floats, 0 for integers")
      ->type_name("T")
      ->check(CLI::Validator(
          [](const std::string& text) {
            double number = -1;
            const bool right = CLI::detail::lexical_cast(text, number) && number >= 0;
            return right ? std::string() : "it takes a number from 0 upwards, not " + text;
          },
          ""));
  command->add_option("--share", arguments->share, "Alike if at most this share of the pixels is beyond; default 0")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--channel", arguments->channels, "Compare only these channels, for example R,G,B or Z")
      ->type_name("LIST")
      ->delimiter(',');
  command
      ->add_option("--diff", arguments->difference,
                   "Write a picture: grey within the tolerance, yellow to red beyond it (PNG)")
      ->type_name("FILE");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace latelight::app
