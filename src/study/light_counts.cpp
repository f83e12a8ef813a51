#include "study/light_counts.h"

#include <numeric>

namespace latelight::study {

namespace {

double meanOf(const output::AovImage& image) {
  return std::accumulate(image.values.begin(), image.values.end(), 0.0) / static_cast<double>(image.values.size());
}

}  // namespace

LightCounts countLights(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
                        render::Settings settings) {
  settings.display = false;
  settings.aovs = {output::Aov::LightsTested, output::Aov::LightsUsed};
  const output::FrameOutput counts = std::move(renderer.render({&camera, 1}, settings, moment).front());
  return {meanOf(counts.aovs[0]), meanOf(counts.aovs[1])};
}

}  // namespace latelight::study
