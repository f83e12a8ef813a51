#include "output/metadata.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>

namespace latelight::output {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no infinity or NaN, so they become strings.
Json number(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

std::string textOf(const Json& json) {
  // Names come from files and need not be UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string_view axesOf(std::string_view frame) {
  if (frame == "gltf") return "X right, Y up, Z toward the viewer; right-handed, meters";
  if (frame == "z-up") return "X right, Y away from the viewer, Z up; right-handed, meters";
  if (frame == "opencv") return "X right, Y down, Z forward; right-handed, meters";
  if (frame == "opengl") return "X right, Y up, Z backward; right-handed, meters";
  return "";
}

std::string_view modelOf(const CameraMetadata& camera) {
  if (camera.lens) return scene::infoOf(camera.lens->model).name;
  return camera.orthographic ? "orthographic" : "perspective";
}

Json cameraOf(const CameraMetadata& camera) {
  const bool hasK = !camera.lens || scene::infoOf(camera.lens->model).calibrated;
  Json json{{"name", camera.name},
            {"model", modelOf(camera)},
            {"convention", camera.convention},
            {"axes", axesOf(camera.convention)},
            {"K", hasK ? rowsOf(camera.intrinsics) : nullptr},
            {"cameraToWorld", rowsOf(camera.cameraToWorld)},
            {"near", number(camera.nearClip)},
            {"far", number(camera.farClip)}};
  if (camera.lens) json["distortion"] = distortionOf(*camera.lens);
  if (camera.apertureRadius > 0) {
    json["apertureRadius"] = camera.apertureRadius;
    json["focusDistance"] = camera.focusDistance;
  }
  return json;
}

Json aovOf(const AovInfo& aov, const Metadata& metadata, ChannelNames names) {
  Json json{{"description", aov.description}, {"unit", aov.unit}};
  Json channels = Json::array();
  for (uint32_t c = 0; c < aov.channels; ++c) channels.push_back(names(aov, c));
  json["channels"] = channels;
  json["background"] = number(aov.background);
  const auto is = [&](std::initializer_list<Aov> some) { return std::ranges::find(some, aov.aov) != some.end(); };
  if (is({Aov::Position, Aov::SceneFlow})) json["frame"] = "world";
  if (is({Aov::ObjectPosition, Aov::Nocs})) json["frame"] = "object";
  if (is({Aov::Normal, Aov::GeoNormal, Aov::Tangent, Aov::Bitangent})) json["frame"] = metadata.normalFrame;
  json["png"] = describe(aov.png);
  if (dependsOnNeighbors(aov.aov) && metadata.neighbors) json["frames"] = describe(*metadata.neighbors);
  return json;
}

Json conventions() {
  return {{"pixels", "x to the right, y down; the first pixel's center, upper left, is (0.5, 0.5)"},
          {"samples", "data are those of the pixel's center, never an average"},
          {"matrices", "lists of rows; they multiply column vectors"},
          {"K",
           "pixel = K * (x, y, z) / third component, of a point in the camera's frame; orthographic: K * (x, y, 1); "
           "opencv and fisheye: of the point as distortion moves it"},
          {"length", "meters"},
          {"color", "linear Rec.709; alpha premultiplied in .exr and .npy, straight in .png"}};
}

}  // namespace

Json describe(const NeighborFrames& neighbors) {
  const auto one = [](const std::optional<NeighborFrame>& frame) {
    if (!frame) return Json();
    Json json = Json::object();
    if (!frame->name.empty()) json["frame"] = frame->name;
    if (frame->time) json["time"] = *frame->time;
    return json;
  };
  return {{"previous", one(neighbors.previous)}, {"next", one(neighbors.next)}};
}

Json distortionOf(const scene::Lens& lens) {
  const uint32_t count = scene::infoOf(lens.model).coefficients;
  if (count == 0) return nullptr;
  return std::vector(lens.distortion.begin(), lens.distortion.begin() + count);
}

Json rowsOf(const glm::dmat4& m) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) rows.push_back({m[0][row], m[1][row], m[2][row], m[3][row]});
  return rows;
}

Json rowsOf(const std::array<double, 9>& m) {
  Json rows = Json::array();
  for (size_t row = 0; row < 3; ++row) rows.push_back({m[3 * row], m[3 * row + 1], m[3 * row + 2]});
  return rows;
}

double ev100Of(float exposure) {
  return -std::log2(1.2 * double{exposure});
}

std::string sideFile(const Metadata& metadata, uint32_t width, uint32_t height, std::span<const Aov> aovs,
                     std::span<const std::string> files, ChannelNames names) {
  assert(files.empty() || files.size() == aovs.size());
  Json json{{"scene", {{"name", metadata.scene}, {"source", metadata.source}}},
            {"frame", metadata.frame},
            {"width", width},
            {"height", height},
            {"world", {{"name", metadata.axes}, {"axes", axesOf(metadata.axes)}}},
            {"camera", cameraOf(metadata.camera)},
            {"exposure", metadata.exposure},
            {"conventions", conventions()}};
  if (metadata.metered) json["metered"] = {{"ev", std::log2(metadata.exposure)}, {"ev100", ev100Of(metadata.exposure)}};
  Json& entries = json["aovs"] = Json::object();
  for (size_t i = 0; i < aovs.size(); ++i) {
    const AovInfo& aov = info(aovs[i]);
    Json& entry = entries[std::string(aov.name)] = aovOf(aov, metadata, names);
    if (!files.empty()) entry["file"] = files[i];
  }
  const DeviceMetadata& device = metadata.device;
  if (!device.name.empty()) json["device"] = {{"name", device.name}, {"driver", device.driver}, {"uuid", device.uuid}};
  json["versions"] = metadata.versions;
  json["settings"] = metadata.settings;
  if (!metadata.idManifest.empty()) {
    json["idManifest"] = metadata.idManifest;
  } else if (std::ranges::any_of(aovs, holdsIds) && metadata.ids) {
    json["ids"] = describeIds(*metadata.ids);
    json["materials"] = describeMaterials(*metadata.ids);
  }
  return textOf(json);
}

}  // namespace latelight::output
