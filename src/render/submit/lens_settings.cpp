#include "render/submit/lens_settings.h"

#include <cmath>

#include "base/error.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/outputs/outputs.h"

namespace latelight::render {

Settings lensSettings(const Settings& settings) {
  if (requestsOutput(settings, Origin::Raster))
    badUsage("an output named raster requires a pinhole or orthographic camera, but this camera has another lens");
  const bool lights = showsPicture(settings) || requestsOutput(settings, Origin::LightCounts);
  if (lights && settings.lighting->draws)
    badUsage("{} lighting takes a pinhole or orthographic camera: choose {}", settings.lighting->name,
             techniquesThatCompute());
  Settings changed = settings;
  if (settings.raster != Raster::Rays) changed.raster = Raster::Compute;
  // Every sample needs a ray of its own, which only whole frames have: the smallest grid with as many samples.
  if (settings.aa.samples > 1) {
    changed.aa.superSampling = static_cast<uint32_t>(std::ceil(std::sqrt(settings.aa.samples)));
    changed.aa.samples = 1;
  }
  if (settings.layout->hasTargets()) changed.layout = &findLayout("exact");
  return changed;
}

}  // namespace latelight::render
