// Helpers for the tests of cameras: scenes, folders, and the projection of points.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include <numbers>
#include <string>

#include "app/folder.h"
#include "base/error.h"
#include "data/cameras/calibrated.h"
#include "data/cameras/cameras.h"
#include "error_of.h"
#include "render/frame/view.h"
#include "scene/load/load.h"

namespace latelight::data::test {

using app::Folder;
using glm::dmat4, glm::dvec2, glm::dvec3, glm::dvec4;
using Json = nlohmann::ordered_json;

inline constexpr double kPi = std::numbers::pi;

// builtin:boxes, created once.
inline const scene::Scene& boxes() {
  static const scene::Scene scene = scene::load("builtin:boxes");
  return scene;
}

inline std::vector<JobCamera> made(const std::string& spec, const scene::Scene& scene = boxes(), uint64_t seed = 1) {
  return makeCameras(Json::parse(spec), scene, seed);
}

// Transforms a point from the file's frame (Y up) to the camera's (X right, Y down, Z forward), with the renderer's
// view.
inline dvec3 seenFrom(const JobCamera& camera, dvec3 point) {
  const shared::View view = render::makeView(camera.camera, 100, 100);
  const dvec3 v = dvec3(view.worldToView * glm::vec4(float(point.x), float(-point.z), float(point.y), 1));
  return {v.x, -v.z, v.y};
}

// Projects a point to pixel coordinates, with the renderer's projection.
inline dvec2 pixelOf(const JobCamera& camera, dvec3 point, uint32_t width, uint32_t height) {
  const shared::Projection p = render::makeView(camera.camera, width, height).projection;
  const dvec3 v = seenFrom(camera, point);
  return {width * 0.5 * (1 + p.X + p.H * v.x / v.z), height * 0.5 * (1 - p.Z + p.V * v.y / v.z)};
}

inline dvec3 eyeOf(const JobCamera& camera) {
  const dvec3 world(camera.camera.toWorld[3]);
  return {world.x, world.z, -world.y};
}

inline void expectNear(dvec3 actual, dvec3 expected, double tolerance) {
  EXPECT_LE(glm::length(actual - expected), tolerance)
      << "(" << actual.x << ", " << actual.y << ", " << actual.z << ") is to be (" << expected.x << ", " << expected.y
      << ", " << expected.z << ")";
}

}  // namespace latelight::data::test
