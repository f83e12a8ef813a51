// What a G-buffer layout loses of a scene: its surfaces beside those of the layout `exact`.
#pragma once

#include "output/targets.h"
#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::report {

// Of the pixels that show a surface.
struct Error {
  double mean = 0, most = 0;
};
struct LayoutErrors {
  Error normal;     // degrees
  Error position;   // millimetres
  Error albedo;     // diffuse colour at normal incidence, linear, the channel that is farthest off
  Error roughness;  // perceptual
};

// Both as Renderer::readTargets() reads them with these settings, but for the layout: `layout` and `exact`.
LayoutErrors layoutErrors(const render::Layout& layout, const output::RawGbuffer& stored,
                          const output::RawGbuffer& exact, const render::Settings& settings,
                          const scene::Camera& camera);

}  // namespace latelight::report
