// `latelight list`: prints the available choices from the registries.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "app/commands.h"
#include "app/list.h"
#include "app/render_options.h"
#include "data/format.h"
#include "output/aov.h"
#include "render/gbuffer/layout.h"
#include "render/settings/settings.h"
#include "scene/builtin/builtin.h"
#include "scene/gltf/extensions.h"
#include "scene/light_types.h"
#include "vk/resources.h"

namespace latelight::app {

namespace {

using Json = nlohmann::ordered_json;

// The image size for which memory costs are printed.
struct PictureSize {
  uint32_t width = 1280, height = 720, samples = 1;
  uint64_t count() const { return uint64_t{width} * height * samples; }
};

Json describeTarget(const char* name, VkFormat format, const char* channels) {
  return {
      {"name", name}, {"format", vk::formatName(format)}, {"bytes", vk::texelBytes(format)}, {"channels", channels}};
}

// Describes a target that every layout has in addition to its own, with its format in the original design.
Json describeSharedTarget(const char* name, VkFormat format, VkFormat original, const char* channels) {
  Json target = describeTarget(name, format, channels);
  if (original != format) target["originalFormat"] = vk::formatName(original);
  if (original != format) target["originalBytes"] = vk::texelBytes(original);
  return target;
}

Json describeBytes(const render::LayoutBytes& bytes, const PictureSize& picture) {
  return {{"targets", bytes.targets},
          {"depth", bytes.depth},
          {"light", bytes.light},
          {"total", bytes.total()},
          {"picture", bytes.total() * picture.count()}};
}

Json listLayouts(const PictureSize& picture) {
  Json rows = Json::array();
  const uint32_t octahedral = render::findNormalEncoding("octahedral").index;
  for (const render::Layout& layout : render::layouts()) {
    Json targets = Json::array();
    for (size_t i = 0; i < layout.targets.size(); ++i)
      targets.push_back(
          describeTarget(layout.targets[i].name, layout.format(i, octahedral), layout.targets[i].channels));
    targets.push_back(describeSharedTarget("depth", render::kDepthFormat, layout.originalDepth, "r: reversed depth"));
    targets.push_back(describeSharedTarget("light", render::kLightFormat, layout.originalLight,
                                           layout.hasTargets()
                                               ? "rgb: emission, then radiance; a: ambient occlusion, then coverage"
                                               : "rgb: radiance; a: coverage"));
    rows.push_back(
        {{"name", layout.name},
         {"description", layout.description},
         {"targets", targets},
         {"normals", layout.fixedNormal ? layout.fixedNormal : "selected by --normals"},
         {"followsNormals", layout.fixedNormal == nullptr},
         {"position", layout.fixedPosition ? layout.fixedPosition : "from depth, with the method of --position"},
         {"followsPosition", layout.fixedPosition == nullptr},
         {"raster", layout.hasTargets() ? "any" : "compute"},
         {"size", fmt::format("{}x{}", picture.width, picture.height)},
         {"samples", picture.samples},
         {"bytes", describeBytes(layout.bytesPerPixel(octahedral), picture)},
         {"originalBytes", describeBytes(layout.originalBytesPerPixel(octahedral), picture)}});
  }
  return rows;
}

Json listNormals() {
  Json rows = Json::array();
  for (const render::NormalEncoding& encoding : render::normalEncodings())
    rows.push_back({{"name", encoding.name},
                    {"description", encoding.description},
                    {"channels", encoding.channels},
                    {"hemisphereOnly", encoding.hemisphere}});
  return rows;
}

Json listLights() {
  Json rows = Json::array();
  for (const scene::LightType& type : scene::lightTypes())
    rows.push_back({{"name", type.name}, {"description", type.description}});
  return rows;
}

Json listNames(std::span<const render::NamedOption> names) {
  Json rows = Json::array();
  for (const render::NamedOption& named : names)
    rows.push_back({{"name", named.name}, {"description", named.description}});
  return rows;
}

const char* kindName(render::OptionKind kind) {
  switch (kind) {
    case render::OptionKind::Flag:
      return "flag";
    case render::OptionKind::Integer:
      return "integer";
    case render::OptionKind::Number:
      return "number";
    case render::OptionKind::Choice:
      return "name";
    case render::OptionKind::Text:
      return "text";
    case render::OptionKind::List:
      return "texts";
  }
  return "";
}

Json describeOption(const render::Option& option, bool inApi) {
  Json row{{"name", render::longName(option)}, {"description", option.help}, {"group", option.group}};
  row["type"] = kindName(option.kind);
  if (!option.names.empty()) {
    row["names"] = Json::array();
    for (const render::NamedOption& named : option.names) row["names"].push_back(named.name);
  }
  if (std::isfinite(option.range.least)) row[option.range.open ? "above" : "least"] = option.range.least;
  if (std::isfinite(option.range.most)) row["most"] = option.range.most;
  if (!option.unit.empty() && option.kind != render::OptionKind::List) row["unit"] = option.unit;
  if (!option.defaultValue.empty()) row["default"] = option.defaultValue;
  if (!option.without.empty()) row["without"] = option.without;
  row["compiled"] = option.effect == render::OptionEffect::Compiled;
  if (inApi) row["member"] = option.member;  // member of latelight::Options
  return row;
}

Json listOptions() {
  Json rows = Json::array();
  for (const render::Option& option : commandOptions()) rows.push_back(describeOption(option, false));
  for (const render::Option& option : render::options()) rows.push_back(describeOption(option, true));
  return rows;
}

Json listAovs() {
  Json rows = Json::array();
  for (const output::AovInfo& aov : output::aovs()) {
    std::string channels;
    for (uint32_t i = 0; i < aov.channels; ++i) channels += (i ? " " : "") + std::string(aov.exrChannels[i]);
    // Pixels of the environment have a motion that depends on the camera.
    const std::string background = aov.aov == output::Aov::Motion ? "motion of the environment"
                                   : std::isinf(aov.background)   ? "+inf"
                                                                  : fmt::format("{:g}", aov.background);
    rows.push_back({{"name", aov.name},
                    {"description", aov.description},
                    {"unit", aov.unit},
                    {"exrChannels", channels},
                    {"exrType", output::nameOf(aov.exr)},
                    {"background", background},
                    {"png", output::describe(aov.png)}});
  }
  return rows;
}

Json listFormats() {
  Json rows = Json::array();
  for (const data::FormatInfo& format : data::formats())
    rows.push_back({{"name", format.name}, {"description", format.description}});
  return rows;
}

// Lists glTF extensions.
Json listExtensions() {
  Json rows = Json::array();
  for (const scene::Extension& extension : scene::extensions()) {
    const char* what = extension.treatment == scene::Treatment::Read      ? "read"
                       : extension.treatment == scene::Treatment::Ignored ? "ignored: does not affect the image"
                                                                          : "not supported";
    rows.push_back({{"name", extension.name}, {"description", what}});
  }
  return rows;
}

Json listScenes() {
  Json rows = Json::array();
  for (const scene::Builtin& builtin : scene::builtins()) {
    Json row{{"name", fmt::format("builtin:{}", builtin.name)}, {"description", builtin.description}};
    for (const scene::BuiltinParameter& p : builtin.parameters)
      row[std::string(p.key)] = fmt::format("{}, {} to {}, normally {}", p.description, p.least, p.most, p.normal);
    rows.push_back(row);
  }
  return rows;
}

std::string text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.1f}", value.get<double>());
  return value.dump();
}

// Prints name and description on one line, and each other value on its own line.
void printRow(const Json& row) {
  fmt::print("  {:<19} {}\n", row["name"].get<std::string>(),
             row.contains("description") ? text(row["description"]) : "");
  for (const auto& [key, value] : row.items())
    if (key != "name" && key != "description") fmt::print("  {:<20}{}: {}\n", "", key, text(value));
}

std::string sizeText(const Json& bytes) {
  const double size = bytes["picture"].get<double>();
  return fmt::format("{:.1f} MB ({:.1f} MiB)", size / 1e6, size / (1 << 20));
}

void printLayout(const Json& row) {
  constexpr int kIndent = 20;
  fmt::print("  {:<20}{}\n", text(row["name"]), text(row["description"]));
  for (const Json& target : row["targets"]) {
    fmt::print("{:<{}}  {:<12}{:<28}{:>3} B  {}", "", kIndent, text(target["name"]), text(target["format"]),
               text(target["bytes"]), text(target["channels"]));
    if (target.contains("originalFormat"))
      fmt::print(" (the original: {}, {} B)", text(target["originalFormat"]), text(target["originalBytes"]));
    fmt::print("\n");
  }
  const Json &here = row["bytes"], &original = row["originalBytes"];
  const bool differs = here["total"] != original["total"];
  const auto beside = [&](const std::string& value) { return differs ? "; the original: " + value : std::string(); };
  fmt::print("{:<{}}  normals: {}\n", "", kIndent, text(row["normals"]));
  fmt::print("{:<{}}  position: {}\n", "", kIndent, text(row["position"]));
  if (row["raster"] != "any") fmt::print("{:<{}}  raster: {} alone\n", "", kIndent, text(row["raster"]));
  fmt::print("{:<{}}  bytes per pixel: {} targets + {} depth + {} light = {}{}\n", "", kIndent, text(here["targets"]),
             text(here["depth"]), text(here["light"]), text(here["total"]), beside(text(original["total"])));
  fmt::print("{:<{}}  {}, {} sample{}: {}{}\n", "", kIndent, text(row["size"]), text(row["samples"]),
             row["samples"] == 1 ? "" : "s", sizeText(here), beside(sizeText(original)));
}

// Prints type, accepted values and default on one line, and the help on another.
void printOption(const Json& row) {
  std::string takes = text(row["type"]);
  if (row.contains("names")) {
    takes = "";
    for (const Json& name : row["names"]) takes += (takes.empty() ? "" : "|") + text(name);
  }
  const auto bound = [&](const char* key, const char* before) {
    if (row.contains(key)) takes += fmt::format("{}{:g}", before, row[key].get<double>());
  };
  bound("least", " from ");
  bound("above", " above ");
  bound("most", " to ");
  if (row.contains("unit")) takes += " " + text(row["unit"]);
  fmt::print("  {:<20}{}\n{:<24}{}{}{}\n", text(row["name"]), text(row["description"]), "", takes,
             row.contains("default") ? ", default " + text(row["default"]) : "",
             row["compiled"].get<bool>() ? ", compiled into pipelines" : "");
}

struct Topic {
  std::string name;
  std::function<Json(const PictureSize&)> rows;
  void (*print)(const Json& row) = printRow;
};

// Creates the lists with more columns than name and description, and those with the accepted names of options.
std::vector<Topic> makeTopics() {
  std::vector<Topic> topics = {
      {"options", [](const PictureSize&) { return listOptions(); }, printOption},
      {"layouts", listLayouts, printLayout},
      {"normals", [](const PictureSize&) { return listNormals(); }},
      {"lights", [](const PictureSize&) { return listLights(); }},
      {"post", [](const PictureSize&) { return listNames(render::postEffects()); }},
      {"aovs", [](const PictureSize&) { return listAovs(); }},
      {"formats", [](const PictureSize&) { return listFormats(); }},
      {"extensions", [](const PictureSize&) { return listExtensions(); }},
      {"scenes", [](const PictureSize&) { return listScenes(); }},
  };
  const auto isThere = [&](std::string_view name) {
    return std::any_of(topics.begin(), topics.end(), [&](const Topic& topic) { return topic.name == name; });
  };
  for (const render::Option& option : render::options())
    if (*option.topic && !isThere(option.topic))
      topics.push_back({option.topic, [&option](const PictureSize&) { return listNames(option.names); }});
  return topics;
}

}  // namespace

std::vector<std::string> listTopics() {
  std::vector<std::string> names;
  for (const Topic& topic : makeTopics()) names.push_back(topic.name);
  return names;
}

std::vector<ListedName> listedNames(std::string_view topic) {
  std::vector<ListedName> names;
  for (const Topic& each : makeTopics())
    if (each.name == topic)
      for (const Json& row : each.rows({})) names.push_back({row["name"], row.value("description", "")});
  return names;
}

namespace {

struct ListOptions {
  std::string topic, size = "1280x720";
  uint32_t samples = 1;
  bool json = false;
};

PictureSize parsePicture(const ListOptions& o) {
  PictureSize picture;
  std::tie(picture.width, picture.height) = render::readSize("--size", o.size);
  picture.samples = o.samples;
  constexpr uint32_t kMaxSide = 1u << 16, kMaxSamples = 256;  // far beyond any target
  if (!picture.count() || std::max(picture.width, picture.height) > kMaxSide || o.samples > kMaxSamples)
    badUsage("an image of {} with {} samples per pixel is not possible", o.size, o.samples);
  return picture;
}

void list(const ListOptions& o) {
  const PictureSize picture = parsePicture(o);
  const std::vector<Topic> topics = makeTopics();
  std::vector<std::pair<const Topic*, Json>> chosen;
  for (const Topic& t : topics)
    if (o.topic.empty() || o.topic == t.name) chosen.emplace_back(&t, t.rows(picture));
  if (chosen.empty()) {
    std::string names;
    for (const Topic& t : topics) names += (names.empty() ? "" : ", ") + t.name;
    badUsage("there is no list of \"{}\"; there are: {}", o.topic, names);
  }
  if (o.json) {
    Json all = Json::object();
    for (const auto& [topic, rows] : chosen) all[topic->name] = rows;
    fmt::print("{}\n", all.dump(2));
    return;
  }
  for (const auto& [topic, rows] : chosen) {
    fmt::print("{}\n", topic->name);
    for (const Json& row : rows) topic->print(row);
  }
}

}  // namespace

void addListCommand(CLI::App& app) {
  auto options = std::make_shared<ListOptions>();
  CLI::App* command =
      app.add_subcommand("list", "List the available options, layouts, normals, lighting techniques, ...");
  command->add_option("TOPIC", options->topic, "List to print; default: all lists");
  command->add_option("--size", options->size, "Image size for which G-buffer memory is computed, in pixels")
      ->capture_default_str();
  command->add_option("--samples", options->samples, "Samples per pixel of that image")->capture_default_str();
  command->add_flag("--json", options->json, "Print JSON");
  command->callback([options] { list(*options); });
}

}  // namespace latelight::app
