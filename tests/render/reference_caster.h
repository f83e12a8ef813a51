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
  double depth;                            // metres along the view axis
  double distance;                         // metres from where the ray starts: the eye, or the camera's plane
  glm::dvec3 position, geonormal, normal;  // world; normals unit, towards the viewer; `normal` without a normal map
  glm::dvec2 uv;                           // set 0
  double uvPerPixel, normalPerPixel;       // their change over one pixel, at most
  double flatness;  // the triangle's least height over its largest coordinate: how well float32 knows its normal
};

class ReferenceCaster {
 public:
  ReferenceCaster(const scene::Scene& scene, const scene::Camera& camera, uint32_t width, uint32_t height);
  ~ReferenceCaster();
  ReferenceCaster(const ReferenceCaster&) = delete;
  ReferenceCaster& operator=(const ReferenceCaster&) = delete;

  // The nearest surface at a picture coordinate (y down, pixel centres at .5): single-sided materials seen from behind
  // are looked through, and so is what an alpha mask cuts out (by its texture's level 0).
  std::optional<Hit> cast(glm::dvec2 pixel) const;

  // The same along a ray from the eye in view space (X right, Y away, Z up), whose length is the unit of `depth`.
  std::optional<Hit> castAlong(glm::dvec3 direction) const;

  // How many surfaces lie along the ray within this relative distance behind and before `depth`.
  int surfacesNear(glm::dvec2 pixel, double depth, double tolerance) const;

  // Metres along the unit direction to the nearest surface within `farthest`, or +inf.
  double freeDistance(glm::dvec3 origin, glm::dvec3 direction, double farthest) const;

  // Depth of the nearest triangle edge that passes a pixel's centre within `kEdgeReach` on the picture; +inf: none.
  double edgeDepth(size_t pixel) const { return edges_[pixel]; }
  // Pixels. Devices snap vertices to a grid of 1/256 pixel (8 sub-pixel bits), so an edge moves by up to half the
  // diagonal of a cell, 0.0028; the rest is the rounding of the vertices' own projection in float32.
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
  glm::dmat3 axes_;  // right, away, up in the world
  glm::dvec3 eye_;
  glm::dvec2 scale_;  // view x and z over depth at the picture's right and upper edge
  RTCDevice device_;
  RTCScene embree_;
  std::vector<std::unique_ptr<Surface>> surfaces_;  // one an instance
  std::vector<double> edges_;
};

}  // namespace latelight::render::test
