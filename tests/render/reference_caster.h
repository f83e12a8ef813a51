// An independent reference for the visible surface of each pixel: rays through pixel centers against every triangle of
// a scene, by Embree in its robust mode, refined in double precision. It shares only the scene's plain data with the
// renderer.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "scene/scene.h"

namespace latelight::render::test {

struct Hit {
  uint32_t instance, triangle;
  uint32_t part;
  double depth;     // in meters along the view axis
  double distance;  // in meters from the ray's origin: the eye or, if orthographic, the camera's plane
  glm::dvec3 position, geonormal, normal;  // world space; unit normals toward the viewer, without normal maps
  glm::dvec2 uv;                           // UV set 0
  double uvPerPixel, normalPerPixel;       // maximum change over one pixel
  // The triangle's smallest height over its largest coordinate, which determines the precision of its normal in
  // float32.
  double flatness;
};

class ReferenceCaster {
 public:
  ReferenceCaster(const scene::Scene& scene, const scene::Camera& camera, uint32_t width, uint32_t height);
  ~ReferenceCaster();
  ReferenceCaster(const ReferenceCaster&) = delete;
  ReferenceCaster& operator=(const ReferenceCaster&) = delete;

  // The nearest surface at an image coordinate (y down, pixel centers at .5). The ray passes through single-sided
  // materials hit from behind, and through texels that an alpha mask removes (by mip level 0 of the texture).
  std::optional<Hit> cast(glm::dvec2 pixel) const;

  // The same along a ray from the eye in view space (X right, Y away, Z up). The length of the direction is the unit of
  // `depth`.
  std::optional<Hit> castAlong(glm::dvec3 direction) const;

  // The number of surfaces along the ray within this relative distance of `depth`, in front of it and behind it.
  int surfacesNear(glm::dvec2 pixel, double depth, double tolerance) const;

  // The distance in meters along the unit direction to the nearest surface within `farthest`, or +inf.
  double freeDistance(glm::dvec3 origin, glm::dvec3 direction, double farthest) const;

  // The depth of the nearest triangle edge that passes a pixel's center within `kEdgeReach` in the image, or +inf.
  double edgeDepth(size_t pixel) const { return edges_[pixel]; }
  // In pixels. Devices snap vertices to a grid of 1/256 pixel (8 sub-pixel bits), so an edge moves by up to half the
  // diagonal of a cell, 0.0028; the rest is for the rounding of the vertices' projection in float32.
  static constexpr double kEdgeReach = 1.0 / 256.0;

 private:
  struct Surface;
  struct Ray {
    glm::dvec3 origin, direction;  // the direction's component along the view axis is 1
  };
  Ray rayThrough(glm::dvec2 pixel) const;
  std::optional<Hit> cast(const Ray& ray) const;
  glm::dvec3 project(glm::dvec3 view) const;  // pixel x, y, and depth
  Hit refine(const Ray& ray, uint32_t instance, uint32_t triangle) const;
  void markEdges();
  void markEdge(glm::dvec3 a, glm::dvec3 b);
  static void filter(const RTCFilterFunctionNArguments* arguments);

  scene::Camera camera_;
  uint32_t width_, height_;
  glm::dmat3 axes_;  // right, away and up in world space
  glm::dvec3 eye_;
  glm::dvec2 scale_;  // view x and z over depth at the image's right and upper edges
  RTCDevice device_;
  RTCScene embree_;
  std::vector<std::unique_ptr<Surface>> surfaces_;  // one per instance
  std::vector<double> edges_;
};

}  // namespace latelight::render::test
