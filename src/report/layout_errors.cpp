#include "report/layout_errors.h"

#include <algorithm>
#include <cmath>

#include "render/frame/view.h"
#include "render/gbuffer/layout.h"
#include "shared/color.h"
#include "shared/diffuse_specular.h"
#include "shared/projection.h"
#include "shared/surface.h"

namespace latelight::report {

namespace {

// The surfaces of a G-buffer, unpacked as lighting does.
class Surfaces {
 public:
  Surfaces(const render::Layout& layout, const output::RawGbuffer& gbuffer, const render::Settings& s,
           const shared::View& view)
      : layout_(layout), gbuffer_(gbuffer), values_(layout.targets.size()) {
    context_.view = view;
    context_.ao = 1;
    context_.normalEncoding = s.normals->index;
    context_.normalSpace = render::indexOf(s.normalSpace);
    context_.positionMethod = render::indexOf(s.position);
  }

  shared::Surface at(size_t pixel) {
    for (size_t i = 0; i < values_.size(); ++i) {
      const output::RawTarget& target = gbuffer_.targets[i];
      for (int c = 0; c < 4; ++c)
        target.words.empty() ? values_[i].f[c] = target.values[4 * pixel + c]
                             : values_[i].u[c] = target.words[4 * pixel + c];
    }
    context_.pixel = {static_cast<float>(pixel % gbuffer_.width) + 0.5f,
                      static_cast<float>(pixel / gbuffer_.width) + 0.5f};
    context_.depth = shared::deviceDepth(context_.view.projection, gbuffer_.depth[pixel]);
    return layout_.unpack(values_, context_);
  }

 private:
  const render::Layout& layout_;
  const output::RawGbuffer& gbuffer_;
  std::vector<render::TargetValue> values_;
  shared::GbufferContext context_{};
};

// Uses the tangent of the half angle, because the cosine of a small angle rounds to 1.
double degreesBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return 2 * std::atan2(glm::length(a - b), glm::length(a + b)) * 180 / M_PI;
}

void add(Error& error, double value) {
  error.mean += value;
  error.most = std::max(error.most, value);
}

}  // namespace

LayoutErrors layoutErrors(const render::Layout& layout, const output::RawGbuffer& stored,
                          const output::RawGbuffer& exact, const render::Settings& settings,
                          const scene::Camera& camera) {
  const shared::View view = render::makeView(camera, settings.width, settings.height);
  Surfaces decoded(layout, stored, settings, view), truth(render::findLayout("exact"), exact, settings, view);
  LayoutErrors errors;
  size_t count = 0;
  for (size_t pixel = 0; pixel < exact.depth.size(); ++pixel) {
    if (!std::isfinite(exact.depth[pixel])) continue;
    const shared::Surface a = shared::litSurface(decoded.at(pixel)), b = shared::litSurface(truth.at(pixel));
    ++count;
    add(errors.normal, degreesBetween(a.normal, b.normal));
    add(errors.position, 1000 * glm::length(glm::dvec3(a.position) - glm::dvec3(b.position)));
    add(errors.albedo,
        shared::maxChannel(glm::abs(shared::diffuseAtNormalIncidence(a) - shared::diffuseAtNormalIncidence(b))));
    add(errors.roughness, std::abs(double{a.roughness} - b.roughness));
  }
  for (Error* error : {&errors.normal, &errors.position, &errors.albedo, &errors.roughness})
    error->mean /= static_cast<double>(std::max<size_t>(count, 1));
  return errors;
}

}  // namespace latelight::report
