// The reference for shading: the papers' formulas in double precision, integrated numerically. The renderer's
// approximations are measured against it. It shares no code with the shaders.
//
// The surface is that of glTF 2.0 (appendix B): a rough dielectric or metal with the Trowbridge-Reitz (GGX) microfacet
// distribution, Smith's masking and shadowing (height-correlated) and Schlick's Fresnel term. Single reflections follow
// the BRDF of the specification. Multiple scattering between microfacets is computed by a random walk (Heitz et al.
// 2016, Multiple-Scattering Microfacet BSDFs with the Smith Model), so that a white surface returns all light (furnace
// test). The diffuse part of a dielectric receives the light from the eye's direction that is not reflected.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/environment/picture_io.h"
#include "shared/surface.h"

namespace latelight::study {

// Returns the sRGB code of a linear value, clamped to 0 to 255 and not rounded.
double srgbLevel(double linear);

// The BRDF of single reflections in 1/sr, by appendix B with KHR_materials_specular. It is 0 if the light or the eye is
// below the surface.
glm::dvec3 gltfBrdf(const shared::Surface& surface, const glm::dvec3& toLight, const glm::dvec3& toEye);

// The directions in which light from the eye leaves a surface after more than one reflection between microfacets, and
// its share of the light, mixed by metalness. Cells are indexed by height and by azimuth from the eye, symmetric on
// both sides. The constructor runs the given number of random walks.
class Bounces {
 public:
  Bounces(const shared::Surface& surface, const glm::dvec3& toEye, uint32_t walks);
  glm::dvec3 towards(const glm::dvec3& direction) const;  // in the surface's frame, up to a factor
  const glm::dvec3& whole() const { return whole_; }
  const glm::dvec3& dielectric() const { return dielectric_; }  // the total for a dielectric

 private:
  static constexpr int kSide = 16;
  void walk(const shared::Surface& surface, const glm::dvec3& eye, uint32_t number);

  std::array<std::array<glm::dvec3, kSide>, kSide> cells_{};
  glm::dvec3 whole_{0}, dielectric_{0};
};

class EnvironmentTruth {
 public:
  // The image is equirectangular, as in scene/environment/environment.h; each pixel has constant radiance.
  explicit EnvironmentTruth(scene::FloatImage picture);

  // Returns the radiance that leaves `surface` in the unit direction `toEye`. It uses multiple importance sampling
  // (Veach 1997) of the lobe's visible normals, of the cosine and of the image's radiance, with `samples` directions
  // each. `bounces` are those of the surface. Ambient occlusion is not included. The same arguments return the same
  // bits.
  glm::dvec3 radiance(const shared::Surface& surface, const glm::dvec3& toEye, const Bounces& bounces,
                      uint32_t samples) const;

  glm::dvec3 at(const glm::dvec3& direction) const;  // the image's radiance
  // Samples a direction from three random numbers in [0, 1), in proportion to radiance. density() is its density in
  // 1/sr.
  glm::dvec3 sampleLight(double choice, double u, double v) const;
  double density(const glm::dvec3& direction) const;

 private:
  struct Direct;
  Direct direct(const shared::Surface& surface, const glm::dvec3& toEye, uint32_t samples) const;
  glm::dvec3 afterBounces(const Bounces& bounces, const shared::Surface& surface, const glm::dvec3& toEye) const;

  scene::FloatImage picture_, small_;  // small_: for lobes nearly as wide as a cosine
  std::vector<double> sums_;           // cumulative power, up to each pixel
};

}  // namespace latelight::study
