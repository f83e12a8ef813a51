#include "study/light_truth.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scene/environment/picture.h"

namespace latelight::study {

namespace {

using glm::dvec3;
using shared::Surface;

constexpr double kPi = std::numbers::pi;
constexpr double kMinCosine = 1e-4;  // between normal and eye

// --- the microsurface: the normal is Z -------------------------------------------------------------------------------

double alphaOf(const Surface& s) {
  return std::max(double{s.roughness} * s.roughness, 1.0 / 1024);
}

double distribution(double cosine, double alpha) {
  if (cosine <= 0) return 0;
  const double sin2 = std::max(1 - cosine * cosine, 0.0), d = cosine * cosine * alpha * alpha + sin2;
  return alpha * alpha / (kPi * d * d);
}

// Smith's lambda of a unit direction, which may point to either side.
double lambda(double cosine, double alpha) {
  const double tangent2 = (1 - cosine * cosine) / (cosine * cosine);
  return 0.5 * (std::copysign(std::sqrt(1 + alpha * alpha * tangent2), cosine) - 1);
}

double schlickWeight(double cosine) {
  return std::pow(std::clamp(1 - cosine, 0.0, 1.0), 5);
}

struct Fresnel {
  dvec3 dielectric, metal;
};
Fresnel fresnel(const Surface& s, double cosine) {
  const double w = schlickWeight(cosine);
  const dvec3 f0(s.f0), base(s.baseColor);
  return {f0 + (dvec3(double{s.f90}) - f0) * w, base + (dvec3(1) - base) * w};
}
dvec3 mixed(const Surface& s, const Fresnel& f) {
  return f.dielectric * (1.0 - s.metallic) + f.metal * double{s.metallic};
}
double largest(const dvec3& v) {
  return std::max({v.x, v.y, v.z});
}

// Samples the facet normals visible from `from`, which may lie below the surface (Heitz 2018, Sampling the GGX
// Distribution of Visible Normals, JCGT 7(4)).
dvec3 visibleNormal(const dvec3& from, double alpha, double u, double v) {
  const dvec3 stretched = glm::normalize(dvec3(alpha * from.x, alpha * from.y, from.z));
  const double across = std::hypot(stretched.x, stretched.y);
  const dvec3 t = across > 1e-9 ? dvec3(-stretched.y, stretched.x, 0) / across : dvec3(1, 0, 0);
  const dvec3 b = glm::cross(stretched, t);
  const double r = std::sqrt(u), x = r * std::cos(2 * kPi * v), half = 0.5 * (1 + stretched.z);
  const double y = (1 - half) * std::sqrt(1 - x * x) + half * r * std::sin(2 * kPi * v);
  const dvec3 h = t * x + b * y + stretched * std::sqrt(std::max(1 - x * x - y * y, 0.0));
  return glm::normalize(dvec3(alpha * h.x, alpha * h.y, std::max(h.z, 1e-12)));
}

// Facet heights are uniform in [-1, 1]. Returns the height at which a ray from `height` along `ray` hits the next
// facet, or a value above 1 if the ray leaves the surface.
double nextHeight(double height, const dvec3& ray, double alpha, double u) {
  constexpr double kLeft = 2;
  if (ray.z > 0.9999) return kLeft;
  const double below = (height + 1) / 2;  // share of facets below
  if (ray.z < -0.9999) return 2 * u * below - 1;
  if (std::abs(ray.z) < 1e-4) return height;
  const double l = lambda(ray.z, alpha);
  if (ray.z > 0 && u > 1 - std::pow(below, l)) return kLeft;
  return std::clamp(2 * below / std::pow(1 - u, 1 / l) - 1, -1.0, 1.0);
}

constexpr double kGolden[] = {0.8566748838545029, 0.733891856627126,  0.6287067210378087,
                              0.5385972572236101, 0.4613973803326306, 0.3952706131292894};
// Returns the i-th point of a lattice that is even in any subset of these dimensions (Roberts 2018).
double lattice(uint32_t i, int dimension) {
  const double x = (i + 0.5) * kGolden[dimension];
  return x - std::floor(x);
}

// The random numbers of one of many walks. The most important ones come from the lattice; the others are pseudo-random.
class WalkNumbers {
 public:
  explicit WalkNumbers(uint32_t walk) : walk_(walk), state_(walk) {}
  double next() {
    if (used_ < 6) return lattice(walk_, used_++);
    uint64_t x = state_ += 0x9e3779b97f4a7c15;  // splitmix64
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
    return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-53;
  }

 private:
  uint32_t walk_;
  int used_ = 0;
  uint64_t state_;
};

// Returns the azimuth about the normal from the eye's side, 0 to 1, symmetric on both sides.
double turn(const dvec3& d) {
  return std::abs(std::atan2(d.y, d.x)) / kPi;
}

// The surface's own frame: the normal is Z, and the eye is above +X.
struct ShadingFrame {
  dvec3 x, y, z, eye;

  ShadingFrame(const dvec3& normal, const dvec3& toEye) : z(glm::normalize(normal)) {
    const dvec3 along = toEye - z * glm::dot(z, toEye);
    const dvec3 other = std::abs(z.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
    x = glm::length(along) > 1e-7 ? glm::normalize(along) : glm::normalize(glm::cross(other, z));
    y = glm::cross(z, x);
    const double cosine = std::clamp(glm::dot(z, toEye), kMinCosine, 1.0);
    eye = dvec3(std::sqrt(1 - cosine * cosine), 0, cosine);
  }
  dvec3 toWorld(const dvec3& d) const { return x * d.x + y * d.y + z * d.z; }
  dvec3 toLocal(const dvec3& d) const { return {glm::dot(d, x), glm::dot(d, y), glm::dot(d, z)}; }
};

}  // namespace

double srgbLevel(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

dvec3 gltfBrdf(const Surface& s, const dvec3& toLight, const dvec3& toEye) {
  const dvec3 n = glm::normalize(dvec3(s.normal)), h = glm::normalize(toLight + toEye);
  const double nl = glm::dot(n, toLight), nv = glm::dot(n, toEye), alpha = alphaOf(s);
  if (nl <= 0 || nv <= 0) return dvec3(0);
  const double lobe = distribution(glm::dot(n, h), alpha) / (1 + lambda(nl, alpha) + lambda(nv, alpha)) / (4 * nl * nv);
  const Fresnel f = fresnel(s, glm::dot(toEye, h));
  return mixed(s, f) * lobe + dvec3(s.baseColor) * ((1.0 - s.metallic) * (1 - largest(f.dielectric)) / kPi);
}

struct EnvironmentTruth::Direct {
  dvec3 once{0}, irradiance{0};  // irradiance divided by pi
  dvec3 dielectric{0};           // share of light from all directions that the dielectric reflects once
};

Bounces::Bounces(const Surface& s, const dvec3& toEye, uint32_t walks) {
  const ShadingFrame frame(dvec3(s.normal), toEye);
  for (uint32_t i = 0; i < walks; ++i) walk(s, frame.eye, i);
  for (auto& row : cells_)
    for (dvec3& cell : row) cell /= walks;
  whole_ /= walks, dielectric_ /= walks;
}

void Bounces::walk(const Surface& s, const dvec3& eye, uint32_t number) {
  constexpr int kMaxBounces = 64;
  const double alpha = alphaOf(s);
  WalkNumbers numbers(number);
  Fresnel left{dvec3(1), dvec3(1)};
  dvec3 ray = -eye;
  double height = 1;
  for (int bounces = 0; bounces < kMaxBounces; ++bounces) {
    height = nextHeight(height, ray, alpha, numbers.next());
    if (height > 1) {
      if (bounces < 2) return;
      const auto cell = [](double share) { return static_cast<size_t>(std::clamp(share * kSide, 0.0, kSide - 1.0)); };
      const dvec3 share = mixed(s, left);
      cells_[cell(ray.z)][cell(turn(ray))] += share;
      whole_ += share, dielectric_ += left.dielectric;
      return;
    }
    const double u = numbers.next(), v = numbers.next();
    const dvec3 facet = visibleNormal(-ray, alpha, u, v);
    const double cosine = -glm::dot(ray, facet);
    const Fresnel f = fresnel(s, cosine);
    left.dielectric *= f.dielectric, left.metal *= f.metal;
    ray = glm::normalize(ray + facet * (2 * cosine));
  }
}

dvec3 Bounces::towards(const dvec3& d) const {
  const auto place = [](double share) { return std::clamp(share * kSide - 0.5, 0.0, kSide - 1.001); };
  const double row = place(d.z), column = place(turn(d));
  const auto i = static_cast<size_t>(row), j = static_cast<size_t>(column);
  const double fi = row - std::floor(row), fj = column - std::floor(column);
  return glm::mix(glm::mix(cells_[i][j], cells_[i][j + 1], fj), glm::mix(cells_[i + 1][j], cells_[i + 1][j + 1], fj),
                  fi);
}

EnvironmentTruth::EnvironmentTruth(scene::FloatImage picture) : picture_(std::move(picture)) {
  small_ = scene::resizeEquirectangular(picture_, 128, 64);
  double sum = 0;
  for (uint32_t y = 0; y < picture_.height; ++y) {
    const double solidAngle =
        (std::cos(y * kPi / picture_.height) - std::cos((y + 1) * kPi / picture_.height)) * 2 * kPi / picture_.width;
    for (uint32_t x = 0; x < picture_.width; ++x) {
      const float* p = picture_.at(x, y);
      sums_.push_back(sum += solidAngle * (double{p[0]} + p[1] + p[2]));
    }
  }
}

// The center column is at +X of the world, the columns to its right turn to -Y, and the top row is the zenith.
dvec3 EnvironmentTruth::at(const dvec3& d) const {
  const double u = 0.5 + std::atan2(-d.y, d.x) / (2 * kPi), v = std::acos(std::clamp(d.z, -1.0, 1.0)) / kPi;
  const float* p = picture_.at(std::min(static_cast<uint32_t>(u * picture_.width), picture_.width - 1),
                               std::min(static_cast<uint32_t>(v * picture_.height), picture_.height - 1));
  return {p[0], p[1], p[2]};
}

double EnvironmentTruth::density(const dvec3& direction) const {
  const dvec3 light = at(direction);
  return sums_.back() > 0 ? (light.x + light.y + light.z) / sums_.back() : 0;
}

dvec3 EnvironmentTruth::sampleLight(double choice, double u, double v) const {
  const auto found = std::lower_bound(sums_.begin(), sums_.end() - 1, choice * sums_.back());
  const auto pixel = static_cast<uint32_t>(found - sums_.begin());
  const double row = pixel / picture_.width, column = pixel % picture_.width + u;
  const double top = std::cos(row * kPi / picture_.height), bottom = std::cos((row + 1) * kPi / picture_.height);
  const double z = top + (bottom - top) * v, r = std::sqrt(std::max(1 - z * z, 0.0));
  const double azimuth = (column / picture_.width - 0.5) * 2 * kPi;
  return {r * std::cos(azimuth), -r * std::sin(azimuth), z};
}

EnvironmentTruth::Direct EnvironmentTruth::direct(const Surface& s, const dvec3& toEye, uint32_t samples) const {
  const ShadingFrame frame(dvec3(s.normal), toEye);
  Direct result;
  const double alpha = alphaOf(s), nv = frame.eye.z;
  const auto add = [&](const dvec3& l, const dvec3& world) {
    if (l.z <= 0) return;
    const dvec3 h = glm::normalize(l + frame.eye);
    const double d = distribution(h.z, alpha), lambdaEye = lambda(nv, alpha);
    const double ofLobe = d / (1 + lambdaEye) / (4 * nv);
    const double weight = 1 / (samples * (ofLobe + l.z / kPi + density(world)));
    const double lobe = d / (1 + lambda(l.z, alpha) + lambdaEye) / (4 * nv);  // includes n.l
    const Fresnel f = fresnel(s, glm::dot(frame.eye, h));
    const dvec3 light = at(world);
    result.once += light * mixed(s, f) * (lobe * weight);
    result.irradiance += light * (l.z / kPi * weight);
    result.dielectric += f.dielectric * (lobe * weight);
  };
  for (uint32_t i = 0; i < samples; ++i) {
    const dvec3 h = visibleNormal(frame.eye, alpha, lattice(i, 0), lattice(i, 1));
    const dvec3 reflected = h * (2 * glm::dot(frame.eye, h)) - frame.eye;
    add(reflected, frame.toWorld(reflected));
    const double r = std::sqrt(lattice(i, 2)), turn = 2 * kPi * lattice(i, 3);
    const dvec3 cosine(r * std::cos(turn), r * std::sin(turn), std::sqrt(1 - r * r));
    add(cosine, frame.toWorld(cosine));
    const dvec3 light = sampleLight(lattice(i, 4), lattice(i, 5), lattice(i, 0));
    add(frame.toLocal(light), light);
  }
  return result;
}

dvec3 EnvironmentTruth::afterBounces(const Bounces& bounces, const Surface& s, const dvec3& toEye) const {
  const ShadingFrame frame(dvec3(s.normal), toEye);
  dvec3 light(0), whole(0);
  for (uint32_t y = 0; y < small_.height; ++y) {
    const double polar = (y + 0.5) * kPi / small_.height, sine = std::sin(polar);
    for (uint32_t x = 0; x < small_.width; ++x) {
      const double azimuth = ((x + 0.5) / small_.width - 0.5) * 2 * kPi;
      const dvec3 d = frame.toLocal({sine * std::cos(azimuth), -sine * std::sin(azimuth), std::cos(polar)});
      if (d.z <= 0) continue;
      const dvec3 share = bounces.towards(d) * sine;
      const float* p = small_.at(x, y);
      light += share * dvec3(p[0], p[1], p[2]);
      whole += share;
    }
  }
  dvec3 result(0);
  for (int c = 0; c < 3; ++c)
    if (whole[c] > 0) result[c] = light[c] / whole[c] * bounces.whole()[c];
  return result;
}

dvec3 EnvironmentTruth::radiance(const Surface& s, const dvec3& toEye, const Bounces& bounces, uint32_t samples) const {
  const Direct direct = this->direct(s, toEye, samples);
  const double left = 1 - largest(direct.dielectric + bounces.dielectric());
  return direct.once + afterBounces(bounces, s, toEye) +
         dvec3(s.baseColor) * direct.irradiance * ((1.0 - s.metallic) * std::max(left, 0.0));
}

}  // namespace latelight::study
