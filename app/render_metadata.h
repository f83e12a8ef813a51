// The metadata of an image for the JSON side file.
#pragma once

#include <string>

#include "app/render_options.h"
#include "output/metadata.h"
#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::app {

// `environment` is the name of the environment; empty for none.
output::Metadata describeRender(const scene::Scene& scene, const scene::Camera& camera, const vk::Device& device,
                                const std::string& environment, const RenderOptions& options);

}  // namespace latelight::app
