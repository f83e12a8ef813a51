// latelight list: what can be chosen, from the registries.
#include <fmt/core.h>

#include <map>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "output/aov.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/settings.h"
#include "scene/builtin.h"
#include "vk/resources.h"

namespace latelight::app {

namespace {

using Json = nlohmann::ordered_json;

Json listLayouts() {
  Json rows = Json::array();
  const uint32_t octahedral = render::findNormalEncoding("octahedral").index;
  for (const render::Layout& layout : render::layouts()) {
    Json targets = Json::array();
    for (size_t i = 0; i < layout.targets.size(); ++i)
      targets.push_back({{"name", layout.targets[i].name},
                         {"format", vk::formatName(layout.format(i, octahedral))},
                         {"channels", layout.targets[i].channels}});
    targets.push_back(
        {{"name", "depth"}, {"format", vk::formatName(render::kDepthFormat)}, {"channels", "reversed depth"}});
    uint32_t bytes = layout.bytesPerPixel(octahedral);
    rows.push_back({{"name", layout.name},
                    {"description", layout.description},
                    {"bytesPerPixel", bytes},
                    {"mebibytesAt1280x720", bytes * 1280.0 * 720.0 / (1 << 20)},
                    {"targets", targets}});
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

Json listLighting() {
  Json rows = Json::array();
  for (const render::TechniqueInfo& technique : render::techniques())
    rows.push_back({{"name", technique.name}, {"description", technique.description}});
  return rows;
}

Json listOptions(const std::vector<render::NamedOption>& options) {
  Json rows = Json::array();
  for (const render::NamedOption& option : options)
    rows.push_back({{"name", option.name}, {"description", option.description}});
  return rows;
}

Json listAovs() {
  Json rows = Json::array();
  for (const output::AovInfo& aov : output::aovs()) {
    std::string channels;
    for (uint32_t i = 0; i < aov.channels; ++i) channels += (i ? " " : "") + std::string(aov.exrChannels[i]);
    rows.push_back(
        {{"name", aov.name}, {"description", aov.description}, {"unit", aov.unit}, {"exrChannels", channels}});
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

struct Topic {
  const char* name;
  Json (*rows)();
};
const Topic kTopics[] = {
    {"layouts", listLayouts},
    {"normals", listNormals},
    {"normal-spaces", [] { return listOptions(render::normalSpaces()); }},
    {"positions", [] { return listOptions(render::positionMethods()); }},
    {"lighting", listLighting},
    {"shading", [] { return listOptions(render::shadings()); }},
    {"tonemaps", [] { return listOptions(render::tonemaps()); }},
    {"aovs", listAovs},
    {"scenes", listScenes},
};

std::string text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.1f}", value.get<double>());
  return value.dump();
}

// Name and description on one line, every other value on a line of its own.
void print(const Json& row) {
  fmt::print("  {:<20}{}\n", row["name"].get<std::string>(),
             row.contains("description") ? text(row["description"]) : "");
  for (const auto& [key, value] : row.items()) {
    if (key == "name" || key == "description") continue;
    if (!value.is_array()) {
      fmt::print("  {:<18}{}: {}\n", "", key, text(value));
      continue;
    }
    for (const Json& part : value)
      fmt::print("  {:<18}{:<12}{:<28}{}\n", "", text(part["name"]), text(part["format"]), text(part["channels"]));
  }
}

void list(const std::string& topic, bool json) {
  Json all = Json::object();
  for (const Topic& t : kTopics)
    if (topic.empty() || topic == t.name) all[t.name] = t.rows();
  if (all.empty()) {
    std::string names;
    for (const Topic& t : kTopics) names += (names.empty() ? "" : ", ") + std::string(t.name);
    badUsage("there is no list of \"{}\"; there are: {}", topic, names);
  }
  if (json) {
    fmt::print("{}\n", all.dump(2));
    return;
  }
  for (const auto& [name, rows] : all.items()) {
    fmt::print("{}\n", name);
    for (const Json& row : rows) print(row);
  }
}

}  // namespace

void addListCommand(CLI::App& app) {
  struct Options {
    std::string topic;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("list", "List layouts, normals, positions, lighting, shading, tonemaps, aovs, scenes");
  command->add_option("TOPIC", options->topic, "One of the lists; all of them without it");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options] { list(options->topic, options->json); });
}

}  // namespace latelight::app
