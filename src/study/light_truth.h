// The reference for shading: the papers' formulas in double precision, and integration. The renderer's approximations
// are measured against it. Shares no code with the shaders.
//
// The surface is glTF 2.0's (appendix B): a rough dielectric or metal with the Trowbridge-Reitz microfacet
// distribution, Smith's masking and shadowing (height-correlated) and Schlick's Fresnel term. Single reflections are
// the BRDF of the specification. Multiple scattering between facets is computed by a random walk over them (Heitz et
// al. 2016, Multiple-Scattering Microfacet BSDFs with the Smith Model), so that a white surface returns all light. The
// diffuse part of a dielectric gets what reflection leaves of light from the eye's direction.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/environment/picture_io.h"
#include "shared/surface.h"

namespace latelight::study {

// sRGB code of a linear value, 0 to 255, not rounded, clamped.
double srgbLevel(double linear);

// Appendix B with KHR_materials_specular: the BRDF of single reflections, 1/sr; 0 where light or eye is below the
// surface.
glm::dvec3 gltfBrdf(const shared::Surface& surface, const glm::dvec3& toLight, const glm::dvec3& toEye);

// The directions in which light from the eye leaves a surface after more than one reflection between facets: by height
// and by azimuth from the eye, symmetric on both sides; and the share of it, mixed by metalness. Found by the given
// number of walks.
class Bounces {
 public:
  Bounces(const shared::Surface& surface, const glm::dvec3& toEye, uint32_t walks);
  glm::dvec3 towards(const glm::dvec3& direction) const;  // in the surface's frame, up to a factor
  const glm::dvec3& whole() const { return whole_; }
  const glm::dvec3& dielectric() const { return dielectric_; }  // the total for a dielectric alone

 private:
  static constexpr int kSide = 16;
  void walk(const shared::Surface& surface, const glm::dvec3& eye, uint32_t number);

  std::array<std::array<glm::dvec3, kSide>, kSide> cells_{};
  glm::dvec3 whole_{0}, dielectric_{0};
};

class EnvironmentTruth {
 public:
  // Equirectangular, as in scene/environment/environment.h; each pixel has constant radiance.
  explicit EnvironmentTruth(scene::FloatImage picture);

  // Radiance that leaves `surface` to the unit direction `toEye`, by multiple importance sampling (Veach 1997) of the
  // lobe's visible normals, of the cosine, and of the picture's light, `samples` directions of each; `bounces` are the
  // surface's. Ambient occlusion is left out. The same bits for the same arguments.
  glm::dvec3 radiance(const shared::Surface& surface, const glm::dvec3& toEye, const Bounces& bounces,
                      uint32_t samples) const;

  glm::dvec3 at(const glm::dvec3& direction) const;  // the picture's radiance
  // A direction by three random numbers in [0, 1), more often where the picture is bright; and how often, 1/sr.
  glm::dvec3 sampleLight(double choice, double u, double v) const;
  double density(const glm::dvec3& direction) const;

 private:
  struct Direct;
  Direct direct(const shared::Surface& surface, const glm::dvec3& toEye, uint32_t samples) const;
  glm::dvec3 afterBounces(const Bounces& bounces, const shared::Surface& surface, const glm::dvec3& toEye) const;

  scene::FloatImage picture_, small_;  // small: for lobes nearly as wide as a cosine
  std::vector<double> sums_;           // of power, up to each pixel
};

}  // namespace latelight::study
