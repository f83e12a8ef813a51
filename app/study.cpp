// `latelight study NAME`: measures one subject and writes tables and images.
#include <fmt/core.h>
#include <latelight/latelight.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands.h"
#include "app/explicit_options.h"
#include "app/parse.h"
#include "app/render_options.h"
#include "base/files.h"
#include "base/text.h"
#include "output/png.h"
#include "output/used_files.h"
#include "render/settings/settings.h"
#include "report/command.h"
#include "report/study_page.h"
#include "scene/builtin/builtin.h"
#include "study/study.h"
#include "vk/driver_cache.h"

namespace latelight::app {

namespace {

constexpr uint32_t kMinSamples = 1000, kMaxSamples = 100'000'000;

struct Arguments {
  std::string name, folder, page, bits, lights, triangles, sizes;
  study::Options options;
  bool json = false;
  CLI::App* command = nullptr;
};

void parseSweep(const Arguments& a, study::SweepOptions& sweep) {
  checkBudget(sweep.budget);
  if (!a.lights.empty()) sweep.lights = parseCounts("--lights", a.lights);
  if (!a.triangles.empty()) sweep.triangles = parseCounts("--triangles", a.triangles);
  if (a.sizes.empty()) return;
  for (std::string_view part : splitAtCommas(a.sizes)) sweep.sizes.push_back(render::readSize("--sizes", part));
}

// Parses "8,10,16,float", or ranges such as "8-16". A number that is listed twice is returned once.
std::vector<uint32_t> parseBits(const std::string& text) {
  const auto wrong = [&]() -> std::vector<uint32_t> {
    badUsage("--bits requires comma-separated numbers from 8 to 16 and float, such as 8,10,12-16,float, not \"{}\"",
             text);
  };
  std::vector<uint32_t> bits;
  const auto add = [&](uint32_t number) {
    if (std::ranges::find(bits, number) == bits.end()) bits.push_back(number);
  };
  for (std::string_view part : splitAtCommas(text)) {
    if (part == "float") {
      add(0);
      continue;
    }
    const size_t dash = part.find('-');
    const auto first = parseIndex(part.substr(0, dash));
    const auto last = dash == std::string::npos ? first : parseIndex(part.substr(dash + 1));
    if (!first || !last || *first < 8 || *last > 16 || *first > *last) return wrong();
    for (size_t b = *first; b <= *last; ++b) add(static_cast<uint32_t>(b));
  }
  return bits;
}

nlohmann::ordered_json toJson(const Arguments& a, const study::Result& result) {
  nlohmann::ordered_json json{{"study", a.name}, {"version", version()}, {"device", result.device}};
  if (study::findStudy(a.name).uses("samples"))
    json["samples"] = a.options.samples;
  else
    json["budget"] = a.options.sweep.budget;
  for (const study::Table& table : result.tables) json[table.name] = study::toJson(table);
  return json;
}

// True for names that a file with a result of the study may have.
bool isResultName(const std::filesystem::path& name, const std::string& study) {
  const std::string ending = name.extension().string();
  const bool isResult = ending == ".csv" || ending == ".json" || ending == ".png" || ending == ".svg";
  return isResult && name.string().starts_with(study);
}

// The folder for results. It is created if missing, and removed again if there are no results.
class ResultFolder {
 public:
  // Checks before any expensive work that the folder is writable. `study` is the prefix of its file names.
  ResultFolder(const std::filesystem::path& path, const std::string& study);
  ~ResultFolder() {
    std::error_code ignored;
    if (made_) std::filesystem::remove(path_, ignored);  // only if empty
  }
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

 private:
  std::filesystem::path path_;
  bool made_ = false;
};

ResultFolder::ResultFolder(const std::filesystem::path& path, const std::string& study) : path_(path) {
  std::error_code error, ignored;
  made_ = std::filesystem::create_directory(path, error);
  if (!std::filesystem::is_directory(path, ignored)) {
    if (isThere(path)) badUsage("{} is no folder; give -o the name of one, or a new name", path.string());
    badUsage("the folder {} cannot be created: {}; give -o another", path.string(), error.message());
  }
  checkWritable(path / (study + ".json"));
  for (std::filesystem::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error))
    if (isResultName(entry->path().filename(), study)) checkWritable(entry->path());
}

// The files that the command writes, with their contents. They appear together.
class Files {
 public:
  void add(const std::filesystem::path& path, std::vector<std::byte> bytes) {
    paths_.push_back(path);
    contents_.push_back(std::move(bytes));
  }
  void add(const std::filesystem::path& path, const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    add(path, std::vector<std::byte>(bytes.begin(), bytes.end()));
  }
  // Throws before it writes the first file if one would replace another one, or one that `used` has.
  void write(output::UsedFiles& used) const {
    used.checkOutputs(paths_);
    FileGroup group;
    for (size_t i = 0; i < paths_.size(); ++i) group.add(paths_[i], contents_[i]);
    group.commit();
  }

 private:
  std::vector<std::filesystem::path> paths_;
  std::vector<std::vector<std::byte>> contents_;
};

void addResults(Files& files, const Arguments& a, const study::Result& result) {
  const std::filesystem::path folder = a.folder;
  for (const study::Table& table : result.tables) files.add(folder / (table.name + ".csv"), study::toCsv(table));
  for (const study::NamedPicture& picture : result.pictures)
    files.add(folder / (picture.name + ".png"), output::encodePng(picture.picture));
  for (const study::Plot& plot : result.plots)
    if (const std::string svg = study::svgOf(plot); !svg.empty()) files.add(folder / (plot.name + ".svg"), svg);
  files.add(folder / (a.name + ".json"), toJson(a, result).dump(1) + "\n");
}

std::string pageOf(const Arguments& a, const study::Study& study, const study::Result& result) {
  std::vector<std::string> words{"study", a.name};
  words = report::joined(std::move(words), explicitOptions(*a.command, {"out", "json", "validate"}));
  return report::studyPage(study, a.options, result, words);
}

// Reports before any expensive work that the page would replace an input, or cannot be written. The folder of the
// results exists already, because the page may be in it.
void checkPage(const Arguments& a, output::UsedFiles& used) {
  checkWritable(a.page);
  const std::filesystem::path outputs[] = {a.page};
  used.checkOutputs(outputs);
}

void rejectOtherOptions(const Arguments& a, const study::Study& chosen) {
  for (const study::Study& other : study::studies())
    for (const std::string_view option : other.options)
      if (!chosen.uses(option) && optionOf(*a.command, option).count() > 0)
        badUsage("the study {} does not use --{}: omit it", chosen.name, option);
}

void run(Arguments& a) {
  const study::Study& chosen = study::findStudy(a.name);
  rejectOtherOptions(a, chosen);
  if (a.options.samples < kMinSamples || a.options.samples > kMaxSamples)
    badUsage("--samples must be from {} to {}, not {}", kMinSamples, kMaxSamples, a.options.samples);
  if (!a.bits.empty()) a.options.bits = parseBits(a.bits);
  parseSweep(a, a.options.sweep);
  if (a.page == "-" && a.json) badUsage("--html - and --json both write to standard output; use one of them");
  const std::vector<std::filesystem::path> inputs(a.options.environments.begin(), a.options.environments.end());
  output::UsedFiles used(inputs);
  if (!a.page.empty()) checkPageName("--html", a.page);
  a.options.pictures = !a.folder.empty() || !a.page.empty();
  std::optional<ResultFolder> folder;
  if (!a.folder.empty()) folder.emplace(a.folder, a.name);
  if (!a.page.empty()) checkPage(a, used);
  vk::avoidFullDriverCache();
  const study::Result result = chosen.run(a.options);
  Files files;
  if (!a.folder.empty()) addResults(files, a, result);
  if (!a.page.empty()) files.add(a.page, pageOf(a, chosen, result));
  files.write(used);
  if (a.page == "-") return;
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
  CLI::App* command = app.add_subcommand("study", "Measure one subject and write tables and images");
  std::string names;
  for (const study::Study& study : study::studies()) names += (names.empty() ? "" : ", ") + std::string(study.name);
  command->add_option("NAME", a.name, "One of " + names)->required();
  command->add_option("-o,--out", a.folder, "Folder for CSV, JSON and PNG files; created if missing")->type_name("DIR");
  command->add_option("--html", a.page, "HTML page with all results, such as depth.html; - is standard output")
      ->type_name("FILE");
  command
      ->add_option("--samples", a.options.samples,
                   "Number of directions; depth studies use a quarter of it, accuracy a thousandth per pixel")
      ->capture_default_str();
  command->add_option("--seed", a.options.seed, "normals: seed for random directions instead of a lattice");
  command->add_option("--bits", a.bits, "normals: bits per channel, 8 to 16 and float, for example 8,10-12,float");
  command->add_option("--lights", a.lights, "lights: numbers of lights, for example 1,100,10k,1M");
  command->add_option("--triangles", a.triangles, "lights: numbers of triangles, for example 50k,300k,10M");
  command->add_option("--sizes", a.sizes, "lights: image sizes, for example 640x360,1280x720");
  command
      ->add_option("--hdri", a.options.environments,
                   "accuracy: additional environments, comma-separated .hdr or .exr files")
      ->delimiter(',')
      ->type_name("FILE");
  command
      ->add_option("--budget", a.options.sweep.budget, "lights: maximum seconds per step; a longer step ends its sweep")
      ->capture_default_str();
  command
      ->add_option("--device", a.options.device,
                   "Device: auto, cpu, cuda:N, a number, a name or a UUID (see latelight devices)")
      ->capture_default_str();
  command->add_flag("--json", a.json, "Print the tables as JSON to standard output");
  command->add_flag("--validate", a.options.validation, "Enable the Vulkan validation layers; any message is an error");
  a.command = command;
  command->callback([arguments] { run(*arguments); });
}

}  // namespace latelight::app
