// Each object of a frame rendered alone: the pixels that it would cover if nothing were in front of it.
#pragma once

#include <vector>

#include "data/objects.h"
#include "render/renderer.h"

namespace latelight::data {

// Fills Object::alone, pixels and full, by the surfaces that the frame's ids show: the same settings, without light.
// Objects that lie apart in the picture share a view, and several views are rendered at once. Those that reach beyond
// the picture are rendered once more, in one three times as wide and high around it; where there can be none (a camera
// with a lens, the largest sizes), what lies beyond does not count. One that stands exactly where another of the same
// mesh and material does is never drawn, and covers nothing.
void renderAlone(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                 const render::Settings& settings, const render::Moment& moment, std::vector<Object>& objects);

}  // namespace latelight::data
