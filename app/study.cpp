// latelight study NAME: measures one subject, and writes tables and pictures.
#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands.h"
#include "app/parse.h"
#include "base/files.h"
#include "output/files.h"
#include "study/study.h"

namespace latelight::app {

namespace {

constexpr uint32_t kLeastSamples = 1000, kMostSamples = 100'000'000;

struct Arguments {
  std::string name, folder, bits;
  study::Options options;
  bool json = false;
};

// "8,10,16,float", or ranges as in "8-16".
std::vector<uint32_t> parseBits(const std::string& text) {
  const auto wrong = [&]() -> std::vector<uint32_t> {
    badUsage("--bits takes numbers from 8 to 16 and float, by comma, as in 8,10,12-16,float, not \"{}\"", text);
  };
  std::vector<uint32_t> bits;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    begin = end + 1;
    if (part == "float") {
      bits.push_back(0);
      continue;
    }
    const size_t dash = part.find('-');
    const auto first = parseIndex(part.substr(0, dash));
    const auto last = dash == std::string::npos ? first : parseIndex(part.substr(dash + 1));
    if (!first || !last || *first < 8 || *last > 16 || *first > *last) return wrong();
    for (size_t b = *first; b <= *last; ++b) bits.push_back(static_cast<uint32_t>(b));
  }
  return bits;
}

nlohmann::ordered_json toJson(const Arguments& a, const study::Result& result) {
  nlohmann::ordered_json json{
      {"study", a.name}, {"version", LATELIGHT_VERSION}, {"device", result.device}, {"samples", a.options.samples}};
  for (const study::Table& table : result.tables) json[table.name] = study::toJson(table);
  return json;
}

// Checks that the folder is there or can be made, before anything costs time.
void checkFolder(const std::filesystem::path& folder) {
  const bool there = std::filesystem::is_directory(folder);
  if (!there && std::filesystem::exists(folder))
    badUsage("{} is no folder; give -o the name of one, or a new name", folder.string());
  output::checkWritable((there ? folder / "study.json" : folder).string());
}

void makeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directory(folder, error);
  if (error) badUsage("the folder {} can't be made: {}; give -o another", folder.string(), error.message());
}

void writeText(const std::filesystem::path& path, const std::string& text) {
  writeFile(path, std::as_bytes(std::span(text)));
}

void writeAll(const std::filesystem::path& folder, const Arguments& a, const study::Result& result) {
  makeFolder(folder);
  for (const study::Table& table : result.tables) writeText(folder / (table.name + ".csv"), study::toCsv(table));
  for (const study::NamedPicture& picture : result.pictures)
    output::writePicture(folder / (picture.name + ".png"), picture.picture);
  writeText(folder / (a.name + ".json"), toJson(a, result).dump(1) + "\n");
}

void run(Arguments& a) {
  const study::Study& chosen = study::findStudy(a.name);
  if (a.options.samples < kLeastSamples || a.options.samples > kMostSamples)
    badUsage("--samples takes a number from {} to {}, not {}", kLeastSamples, kMostSamples, a.options.samples);
  if (!a.bits.empty()) a.options.bits = parseBits(a.bits);
  a.options.pictures = !a.folder.empty();
  if (!a.folder.empty()) checkFolder(a.folder);
  const study::Result result = chosen.run(a.options);
  if (!a.folder.empty()) writeAll(a.folder, a, result);
  if (a.json) {
    fmt::print("{}\n", toJson(a, result).dump(1));
    return;
  }
  for (const study::Table& table : result.tables)
    if (table.shown) fmt::print("{}\n", study::toText(table));
}

}  // namespace

void addStudyCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* command = app.add_subcommand("study", "Measure one subject, and write tables and pictures of it");
  std::string names;
  for (const study::Study& study : study::studies()) names += (names.empty() ? "" : ", ") + std::string(study.name);
  command->add_option("NAME", a.name, "One of " + names)->required();
  command->add_option("-o,--out", a.folder, "Folder for CSV, JSON and PNG files; made if missing")->type_name("DIR");
  command->add_option("--samples", a.options.samples, "Directions; of depths a quarter as many")->capture_default_str();
  command->add_option("--seed", a.options.seed, "Random directions of normals, by this number, instead of a lattice");
  command->add_option("--bits", a.bits, "Bits a channel of normals: 8 to 16 and float, as in 8,10-12,float");
  command->add_option("--device", a.options.device, "auto, cpu, a number, a name or a UUID (latelight devices)")
      ->capture_default_str();
  command->add_flag("--json", a.json, "The tables on standard output as JSON");
  command->add_flag("--validate", a.options.validation,
                    "Run under the Vulkan validation layers; any message is an error");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace latelight::app
