#include "app/render_labels.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "base/lowercase.h"
#include "data/extras.h"
#include "data/json_builder.h"
#include "data/json_text.h"
#include "output/files.h"
#include "render/submit/id_manifest.h"

namespace latelight::app {

namespace {

using Json = nlohmann::ordered_json;

bool isJson(const std::string& keypoints) {
  return keypoints.starts_with('[') || keypoints.starts_with('{');
}

Json readJson(const RenderOptions& o) {
  if (isJson(o.keypoints)) return data::parseJson(o.keypoints, "--keypoints").json;
  const std::vector<std::byte> bytes = readFile(o.keypoints);
  return data::parseJson({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "the keypoints").json;
}

std::vector<data::ObjectKeypoint> readKeypoints(const RenderOptions& o) {
  if (o.keypoints.empty()) return {};
  try {
    return data::readKeypoints(readJson(o), "--keypoints");
  } catch (const data::JsonError& error) {
    if (isJson(o.keypoints)) badUsage("--keypoints takes a file or JSON, not \"{}\": {}", o.keypoints, error.what());
    badUsage("{}:{}: {}", o.keypoints, error.line, error.what());
  }
}

void checkName(const std::string& pattern) {
  if (pattern == "-") return;
  if (lowercaseExtension(pattern) != ".json")
    badUsage("--labels writes JSON; give it a name that ends in .json, not \"{}\"", pattern);
  checkFrameFile("--labels", pattern);
}

}  // namespace

void checkFrameFile(std::string_view option, const std::string& pattern) {
  if (pattern.find("{aov}") != std::string::npos)
    badUsage("{} writes one file per frame: \"{}\" may contain {{frame}}, {{camera}} and {{scene}}", option, pattern);
  output::checkPattern(pattern);
}

std::optional<data::ObjectLabels> planLabels(const RenderOptions& o) {
  if (o.labels.empty()) {
    if (!o.keypoints.empty()) badUsage("--keypoints are a part of the labels: give their file with --labels");
    return std::nullopt;
  }
  checkName(o.labels);
  return data::ObjectLabels{.masks = true, .keypoints = readKeypoints(o)};
}

void warnOfMissingNodes(const data::ObjectLabels& labels, const scene::Scene& scene) {
  if (labels.keypoints.empty()) return;
  const output::IdManifest manifest = render::idManifest(scene);
  const data::KeypointNodes nodes(scene, labels.keypoints);
  for (size_t i = 0; i < labels.keypoints.size(); ++i)
    if (std::ranges::none_of(manifest.ids, [&](const auto& object) { return nodes.of(object, i).has_value(); }))
      warn("no object has the node \"{}\" of the keypoint {}: \"node\" is {}", labels.keypoints[i].node,
           labels.keypoints[i].name, data::kKeypointNodeHelp);
}

std::filesystem::path keypointsFile(const RenderOptions& o) {
  return isJson(o.keypoints) ? std::filesystem::path() : std::filesystem::path(o.keypoints);
}

Json labelFrame(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                const render::Settings& settings, const render::SceneState& moment, const data::ObjectLabels& labels,
                const output::Metadata& metadata) {
  data::DataFrame frame{.index = metadata.frame,
                        .name = fmt::format("{:0{}}", metadata.frame, metadata.frameDigits),
                        .metadata = metadata};
  render::Settings ids = settings;
  ids.display = false;
  ids.aovs = labels.needs();
  frame.picture = std::move(renderer.render({&camera, 1}, ids, moment).front());
  labels::GeometryHashes geometry;
  data::renderExtras(renderer, scene, camera, ids, moment, labels.needsExtras(), geometry, frame);
  return labels.describe(frame);
}

std::vector<std::filesystem::path> writeFrameFile(const std::string& pattern, std::span<const std::byte> bytes,
                                                  const output::Metadata& metadata) {
  const std::filesystem::path path = output::fillPattern(pattern, "", metadata);
  output::makeFilledFolders(pattern, path);
  writeFile(path, bytes);
  if (pattern == "-") return {};
  return {path};
}

std::vector<std::filesystem::path> writeLabels(const std::string& pattern, const Json& labels,
                                               const output::Metadata& metadata) {
  const std::string text = data::dumped(labels) + "\n";
  return writeFrameFile(pattern, std::as_bytes(std::span(text)), metadata);
}

}  // namespace latelight::app
