#include "render/submit/lens_settings.h"

#include "base/error.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/outputs/outputs.h"

namespace latelight::render {

Settings lensSettings(const Settings& settings) {
  const auto needsPinhole = [](const char* what) {
    badUsage("{} requires a pinhole or orthographic camera, but this camera has another lens", what);
  };
  if (requestsOutput(settings, Origin::Motion)) needsPinhole("the output motion");
  if (requestsOutput(settings, Origin::Raster)) needsPinhole("an output named raster");
  if (showsPicture(settings) || requestsOutput(settings, Origin::LightCounts)) {
    if (settings.lighting->draws)
      badUsage("{} lighting takes a pinhole or orthographic camera: choose {}", settings.lighting->name,
               techniquesThatCompute());
    if (settings.aa.samples > 1 || settings.aa.temporal) needsPinhole("--aa msaaN or taa");
    if (settings.ambientOcclusion != AmbientOcclusion::None) needsPinhole("--ao");
  }
  Settings changed = settings;
  changed.raster = Raster::Compute;
  if (settings.layout->hasTargets()) changed.layout = &findLayout("exact");
  return changed;
}

}  // namespace latelight::render
