// What some formats need of a frame beside its outputs.
#pragma once

#include "data/frame.h"
#include "render/renderer.h"

namespace latelight::data {

// What either needs.
Extras both(const Extras& a, const Extras& b);

// Fills the frame's objects and samples; called once a frame, with what its picture was rendered with, where any format
// needs some. `geometry`: of the scene.
void renderExtras(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                  const render::Settings& settings, const render::Moment& moment, const Extras& needed,
                  GeometryHashes& geometry, DataFrame& frame);

}  // namespace latelight::data
