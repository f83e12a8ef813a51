#include "materials/integral.h"

#include <cmath>
#include <optional>
#include <vector>

namespace latelight::materials {

namespace {

using glm::dvec3;
using shared::vec3;

// Points of a lattice that is uniform in any two of its dimensions (Roberts 2018), shifted for each pixel so that the
// error is not the same everywhere.
class Lattice {
 public:
  explicit Lattice(uint32_t pixel) {
    for (int d = 0; d < 3; ++d) start_[d] = double(pixel * 2654435761u + uint32_t(d) * 1640531527u) / 4294967296.0;
  }
  double at(uint32_t i, int dimension) const {
    constexpr double kSteps[] = {0.8191725134, 0.6710436067, 0.5497004779};
    const double x = start_[dimension] + (i + 0.5) * kSteps[dimension];
    return x - std::floor(x);
  }

 private:
  double start_[3];
};

// A lobe of half vectors about a normal, for light that is reflected to the eye or, mirrored, transmitted.
struct Facets {
  shared::StretchedFrame frame;
  vec3 eye;
  bool passes;

  vec3 mirrored(vec3 l) const { return l - frame.normal * (2.0f * glm::dot(frame.normal, l)); }
  std::optional<vec3> sample(double u, double v) const {
    const double radius = std::sqrt(u / (1.0 - u)), turn = 2.0 * M_PI * v;
    const vec3 slope = frame.tangent * float(frame.along * radius * std::cos(turn)) +
                       frame.bitangent * float(frame.across * radius * std::sin(turn));
    const vec3 h = glm::normalize(frame.normal + slope);
    const float vh = glm::dot(eye, h);
    const vec3 l = h * (2.0f * vh) - eye;
    if (vh <= 0.0f || glm::dot(l, frame.normal) <= 0.0f) return std::nullopt;
    return passes ? mirrored(l) : l;
  }
  double density(vec3 l) const {
    if (passes) l = mirrored(l);
    if (glm::dot(l, frame.normal) <= 0.0f) return 0.0;
    const vec3 h = shared::halfVector(l, eye);
    const double vh = glm::dot(eye, h);
    return vh > 0.0 ? shared::stretchedDistribution(frame, h) * glm::dot(frame.normal, h) / (4.0 * vh) : 0.0;
  }
};

shared::StretchedFrame roundFrame(vec3 normal, vec3 tangent, float roughness) {
  return shared::stretchedFrame(normal, tangent, roughness, 0.0f);
}

vec3 cosineSample(const shared::StretchedFrame& f, double side, double u, double v) {
  const double r = std::sqrt(u), turn = 2.0 * M_PI * v;
  return f.tangent * float(r * std::cos(turn)) + f.bitangent * float(r * std::sin(turn)) +
         f.normal * float(side * std::sqrt(1.0 - u));
}

}  // namespace

dvec3 integrate(const Point& p, const shared::LayerTables& tables, const study::EnvironmentTruth& environment,
                uint32_t samples) {
  constexpr uint32_t kShading = shared::kShadingGgxCompensated;
  const shared::LayeredBrdf b = shared::layeredBrdf(p.surface, p.layers, p.toEye, kShading, tables);
  const vec3 n = p.surface.normal, tangent = p.layers.anisotropyDirection;
  std::vector<Facets> lobes{{b.stretched, p.toEye, false}};
  if (p.layers.clearcoat > 0.0f)
    lobes.push_back({roundFrame(p.layers.clearcoatNormal, tangent, p.layers.clearcoatRoughness), p.toEye, false});
  if (p.layers.transmission > 0.0f)
    lobes.push_back({roundFrame(n, tangent, shared::transmittedRoughness(p.surface.roughness, p.layers.ior)),
                     shared::eyeThrough(n, p.toEye, p.layers, 1u), true});
  std::vector<double> sides{1.0};
  if (p.layers.transmission > 0.0f || p.layers.diffuseTransmission > 0.0f) sides.push_back(-1.0);
  const uint32_t each = samples / uint32_t(lobes.size() + 1 + sides.size());
  dvec3 sum(0.0);
  const auto add = [&](vec3 l) {
    const double cosine = glm::dot(n, l);
    double density = environment.density(dvec3(l));
    if (cosine > 0.0 || sides.size() > 1) density += std::abs(cosine) / M_PI;
    for (const Facets& f : lobes) density += f.density(l);
    const vec3 light(environment.at(dvec3(l)));
    sum += dvec3(shared::shadeLayeredLight(b, {l, light, 1.0f}, kShading)) / (density * each);
  };
  const Lattice lattice(p.pixel);
  for (uint32_t i = 0; i < each; ++i) {
    const double u = lattice.at(i, 0), v = lattice.at(i, 1), w = lattice.at(i, 2);
    for (const Facets& f : lobes)
      if (const std::optional<vec3> l = f.sample(u, v)) add(*l);
    add(vec3(environment.sampleLight(w, u, v)));
    for (const double side : sides) add(cosineSample(b.stretched, side, u, v));
  }
  return sum;
}

}  // namespace latelight::materials
