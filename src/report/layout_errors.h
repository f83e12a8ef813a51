// The error of a G-buffer layout in a scene: its surfaces compared with those of the layout `exact`.
#pragma once

#include "output/targets.h"
#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::report {

// Over the pixels that show a surface.
struct Error {
  double mean = 0, most = 0;
};
struct LayoutErrors {
  Error normal;     // degrees
  Error position;   // millimeters
  Error albedo;     // diffuse color at normal incidence, linear, the channel with the largest error
  Error roughness;  // perceptual
};

// Both G-buffers are results of Renderer::readTargets() with these settings, except for the layout: `layout` and
// `exact`.
LayoutErrors layoutErrors(const render::Layout& layout, const output::RawGbuffer& stored,
                          const output::RawGbuffer& exact, const render::Settings& settings,
                          const scene::Camera& camera);

}  // namespace latelight::report
