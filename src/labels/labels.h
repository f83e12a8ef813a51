// The labels of a picture's objects: masks of visible and of all pixels, boxes, and the order of occlusion.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "labels/objects.h"
#include "render/submit/renderer.h"

namespace latelight::labels {

struct LabeledObject {
  Object object;
  std::string node;  // path of its node, as in the id manifest
  Mask visible;
};

struct PictureLabels {
  output::AovImage ids;                  // the output `id`
  output::CameraMetadata camera;         // in the frame of the settings' axes
  std::vector<LabeledObject> objects{};  // those that cover any pixel by themselves, sorted by id
};

// Returns the labels of one picture per camera. If `moment` has worlds, with lists and not with arrays for shaders,
// each camera shows its world.
std::vector<PictureLabels> labelObjects(render::Renderer& renderer, const scene::Scene& scene,
                                        std::span<const scene::Camera> cameras, const render::Settings& settings,
                                        const render::SceneState& moment);

}  // namespace latelight::labels
