// Renders the data of a frame that some formats require in addition to its outputs: objects and fine id samples.
#pragma once

#include "data/frame.h"
#include "render/submit/renderer.h"

namespace latelight::data {

// Returns the union of two requirements. If both have keypoints, these must be the same.
Extras both(const Extras& a, const Extras& b);

// Fills everything except DataFrame::pairs and DataFrame::scans, which relate frames: DataFrame::objects,
// DataFrame::keypoints and DataFrame::samples. Called once per frame if any format requires them, with the arguments
// that the frame's picture was rendered with. The frame's metadata must have its ids. `geometry` caches the geometry
// hashes of `scene`.
void renderExtras(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                  const render::Settings& settings, const render::SceneState& moment, const Extras& needed,
                  GeometryHashes& geometry, DataFrame& frame);

}  // namespace latelight::data
