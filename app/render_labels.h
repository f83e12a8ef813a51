// --labels: the objects of a frame in a JSON file, as the data set format "boxes" describes them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/render_options.h"
#include "data/formats/object_labels.h"
#include "output/metadata.h"
#include "render/submit/renderer.h"
#include "scene/scene.h"

namespace latelight::app {

// Returns the requested labels, or nothing without --labels. Throws Error(Usage) for invalid options and keypoints, and
// Error(BadInput) if the file of the keypoints cannot be read.
std::optional<data::ObjectLabels> planLabels(const RenderOptions& options);

// Warns of keypoints whose node no object of the scene has.
void warnOfMissingNodes(const data::ObjectLabels& labels, const scene::Scene& scene);

// The file that --keypoints names; empty if there is none.
std::filesystem::path keypointsFile(const RenderOptions& options);

// Renders a frame's ids and isolated objects. `metadata` describes its picture, and has the ids of the scene.
nlohmann::ordered_json labelFrame(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                                  const render::Settings& settings, const render::SceneState& moment,
                                  const data::ObjectLabels& labels, const output::Metadata& metadata);

// Throws Error(Usage) if the name of a file per frame, which `option` sets, has {aov} or cannot be written.
void checkFrameFile(std::string_view option, const std::string& pattern);

// Writes the file of a frame, whole or not at all. Returns its path, or nothing for standard output.
std::vector<std::filesystem::path> writeFrameFile(const std::string& pattern, std::span<const std::byte> bytes,
                                                  const output::Metadata& metadata);
std::vector<std::filesystem::path> writeLabels(const std::string& pattern, const nlohmann::ordered_json& labels,
                                               const output::Metadata& metadata);

}  // namespace latelight::app
