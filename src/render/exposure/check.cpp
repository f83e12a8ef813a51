#include "render/exposure/check.h"

#include "base/error.h"
#include "render/outputs/outputs.h"

namespace latelight::render {

namespace {

void checkRows(const Settings& s, bool refracts) {
  const auto reject = [](const char* what) {
    badUsage("--readout renders each row by itself, so it does not support {}", what);
  };
  if (requestsOutput(s, Origin::Motion)) reject("the output motion");
  if (s.exports.channelsFirst) reject("arrays with channels first");
  if (!showsPicture(s)) return;
  if (s.aa.temporal || s.aa.fxaa) reject("--aa taa and fxaa: use ss2 or more");
  if (keepsIndirect(s)) reject("--indirect-filter temporal: use none");
  if (s.bloom > 0) reject("--bloom");
  if (s.ambientOcclusion != AmbientOcclusion::None) reject("--ao");
  if (refracts) reject("transmissive materials, which refract the picture around them");
}

}  // namespace

void checkExposure(const Settings& s, const ExposureUse& use) {
  if (use.exposes && s.aa.temporal)
    badUsage("--aa taa cannot be combined with --shutter or --aperture, which average frames of their own: use ss2");
  if (use.exposes && keepsIndirect(s))
    badUsage(
        "--indirect-filter temporal cannot be combined with --shutter or --aperture, which average frames of their "
        "own: use spatial");
  if (use.worlds && (s.shutter > 0 || s.readout != 0))
    badUsage("worlds are rendered at an instant: leave out --shutter and --readout");
  if (use.byRows) checkRows(s, use.refracts);
}

}  // namespace latelight::render
