// The metadata of a picture for the JSON side file.
#pragma once

#include <string>

#include "app/render_options.h"
#include "output/metadata.h"
#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::app {

// `environment`: its name, empty for none.
output::Metadata describeRender(const scene::Scene& scene, const scene::Camera& camera, const vk::Device& device,
                                const std::string& environment, const RenderOptions& options);

}  // namespace latelight::app
