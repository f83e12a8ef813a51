// Describes a picture for the metadata of its files, except for the device.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "output/metadata.h"
#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::render {

// The texts of the options that the user gave, by key ("exposure").
using ExplicitOptions = std::map<std::string, std::string, std::less<>>;

output::CameraMetadata describeCamera(const scene::Camera& camera, const scene::Scene& scene, const Settings& settings);

// `environment`: its name, empty for none. Ids are described only if an output holds them.
output::Metadata describe(const scene::Scene& scene, const scene::Camera& camera, const std::string& environment,
                          const Settings& settings, const ExplicitOptions& given);

}  // namespace latelight::render
