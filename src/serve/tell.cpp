#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

#include "output/aov.h"
#include "render/options/options.h"
#include "serve/messages.h"
#include "view/shell_words.h"

namespace latelight::serve {

namespace {

using Json = nlohmann::json;
using render::OptionKind;

Json describe(const render::Option& option) {
  static const std::map<OptionKind, const char*> kKinds = {
      {OptionKind::Flag, "flag"},     {OptionKind::Integer, "integer"}, {OptionKind::Number, "number"},
      {OptionKind::Choice, "choice"}, {OptionKind::Text, "text"},       {OptionKind::List, "text"}};
  Json row{{"key", render::keyOf(option)},
           {"group", option.group},
           {"kind", kKinds.at(option.kind)},
           {"help", option.help},
           {"default", option.defaultValue},
           {"without", option.without},
           {"unit", option.unit},
           {"compiled", option.effect == render::OptionEffect::Compiled}};
  if (std::isfinite(option.range.least)) row["least"] = option.range.least;
  if (std::isfinite(option.range.most)) row["most"] = option.range.most;
  row["names"] = Json::array();
  for (const render::NamedOption& named : option.names)
    row["names"].push_back({{"name", named.name}, {"help", named.description}});
  return row;
}

Json describe(const view::Choice& choice) {
  return {{"options", choice.options}, {"output", choice.output}};
}

Json vector(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}

Json describe(const render::Picked& picked) {
  if (picked.id == 0) return {{"id", 0}};
  return {{"id", picked.id},
          {"part", picked.part},
          {"node", picked.node},
          {"mesh", picked.mesh},
          {"material", picked.material},
          {"primitive", picked.primitive},
          {"position", vector(picked.position)},
          {"normal", vector(picked.normal)},
          {"geonormal", vector(picked.geonormal)},
          {"depth", picked.depth},
          {"distance", picked.distance},
          {"uv", {picked.uv.x, picked.uv.y}}};
}

Json describe(const std::optional<view::Probe>& probe) {
  if (!probe) return nullptr;
  return {{"x", probe->x}, {"y", probe->y}, {"rgba", probe->rgba}, {"surface", describe(probe->surface)}};
}

Json describe(const view::SetSplit& split) {
  constexpr const char* kModes[] = {"off", "slider", "difference"};
  return {{"mode", kModes[split.mode]}, {"at", split.at}, {"amplification", split.amplification}};
}

// The maximum is as many lights as can be told apart in a picture.
Json describe(const std::vector<view::LightState>& lights) {
  constexpr size_t kMax = 64;
  Json told = Json::array();
  for (const view::LightState& light : std::span(lights).first(std::min(lights.size(), kMax)))
    told.push_back({{"name", light.name},
                    {"type", light.type},
                    {"position", light.position},
                    {"at", light.at ? Json(*light.at) : Json()}});
  return told;
}

std::string command(const view::ViewSession& session, view::Side side) {
  std::vector<std::string> words = session.commandLine(side);
  words.insert(words.end(), {"-o", "picture.png"});
  return view::shellWords(words);
}

}  // namespace

// Texts may come from a scene file, so bytes that are not UTF-8 are replaced.
std::string envelope(const Json& header, const std::vector<std::string_view>& payload) {
  static_assert(std::endian::native == std::endian::little);
  const std::string text = header.dump(-1, ' ', false, Json::error_handler_t::replace);
  const auto bytes = static_cast<uint32_t>(text.size());
  std::string message(sizeof bytes, '\0');
  std::memcpy(message.data(), &bytes, sizeof bytes);
  message += text;
  for (const std::string_view part : payload) message += part;
  return message;
}

Json tables(const view::Start& start) {
  Json told{{"options", Json::array()},
            {"outputs", Json::array()},
            {"environments", {"", "studio", "none"}},
            {"file", {{"most", kMaxFileBytes}, {"piece", kMaxPieceBytes}}}};
  for (const render::Option& option : render::options())
    if (render::keyOf(option) != "size") told["options"].push_back(describe(option));
  told["outputs"].push_back({{"name", "picture"}, {"help", "what the camera sees"}});
  for (const output::AovInfo& aov : output::aovs())
    told["outputs"].push_back({{"name", aov.name}, {"help", aov.description}});
  told["outputs"].push_back({{"name", "lights"}, {"help", "lights tested and used, side by side"}});
  told["outputs"].push_back({{"name", "sheet"}, {"help", "all outputs, side by side"}});
  told["outputs"].push_back({{"name", "targets"}, {"help", "the layout's targets, side by side"}});
  const std::string& own = start.environment;
  if (!own.empty() && own != "studio" && own != "none") told["environments"].push_back(own);
  return told;
}

Json describe(const view::ViewSession& session, bool withLights) {
  const view::State& s = session.state();
  return {{"scene", s.scene},
          {"device", s.device},
          {"error", s.error},
          {"width", s.width},
          {"height", s.height},
          {"left", describe(s.choices[0])},
          {"right", describe(s.choices[1])},
          {"split", describe(s.split)},
          {"environment", s.environment},
          {"variants", s.variants},
          {"variant", s.variant},
          {"cameras", s.cameras},
          {"camera", s.camera},
          {"cameraIndex", s.cameraIndex ? Json(*s.cameraIndex) : Json()},
          {"steered", s.steered.has_value()},
          {"navigation", s.navigation == view::Navigation::Fly ? "fly" : "orbit"},
          {"animations", s.animations},
          {"duration", s.duration},
          {"time", s.time ? Json(*s.time) : Json()},
          {"playing", s.playing},
          {"crosshair", s.crosshair ? Json(*s.crosshair) : Json()},
          {"selected", s.selected ? describe(*s.selected) : Json()},
          {"probe", describe(s.probe)},
          {"lights", withLights ? describe(s.lights) : Json::array()},
          {"lightsMoved", s.lightsMoved},
          {"leftCommand", command(session, view::Side::Left)},
          {"rightCommand", s.split.mode == view::SetSplit::Off ? "" : command(session, view::Side::Right)},
          {"bytesPerPixel", s.bytesPerPixel},
          {"targets", s.targets}};
}

Json changes(const Json& before, const Json& now) {
  Json changed = Json::object();
  for (const auto& [key, value] : now.items())
    if (!before.contains(key) || before[key] != value) changed[key] = value;
  return changed;
}

}  // namespace latelight::serve
