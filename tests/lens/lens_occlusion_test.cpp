// Ambient occlusion through lenses that bend rays, against the same references as that of projections
// (tests/render/ambient_occlusion_test.cpp): an open plane, a floor and a wall in closed form, and rays. Without
// distortion, the picture is that of a pinhole.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "render/sky_visibility.h"
#include "scene/framing.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;
using scene::LensModel;

struct Wide {
  const char* name;
  scene::Lens lens;
  uint32_t width, height;

  friend void PrintTo(const Wide& wide, std::ostream* out) { *out << wide.name; }
};

const Wide kWide[] = {
    {"opencv", {LensModel::OpenCv, 160, 120, 110, 112, 82, 57, {-0.28, 0.07, 1.2e-3, -8e-4, -0.005}}, 160, 120},
    {"rational",
     {LensModel::OpenCv, 160, 120, 100, 100, 80, 60, {0.9, 0.1, 1e-4, 2e-4, 0.01, 1.2, 0.25, 0.02}},
     160,
     120},
    {"fisheye", {LensModel::Fisheye, 180, 180, 50, 50, 90, 91, {-0.03, 0.012, -0.004, 0.0007}}, 180, 180},
    {"ftheta", {LensModel::FTheta, 180, 180, 1, 1, 90, 91, {0, 0.02, 1e-5, -1e-7}}, 180, 180},
    {"equirectangular", {.model = LensModel::Equirectangular}, 320, 160},
    {"cubemap", {.model = LensModel::CubeMap}, 480, 80},
};

// The surface that a pixel of a lens shows.
class LensCaster {
 public:
  LensCaster(const scene::Scene& scene, const scene::Camera& camera, const Wide& wide)
      : projection_(scene::scaledTo(wide.lens, wide.width, wide.height)),
        rays(scene, camera, wide.width, wide.height) {}

  std::optional<Hit> cast(dvec2 pixel) const {
    const std::optional<dvec3> ray = projection_.unproject(pixel);
    if (!ray) return std::nullopt;
    return rays.castAlong({ray->x, ray->z, -ray->y});
  }

 private:
  scene::LensProjection projection_;

 public:
  ReferenceCaster rays;
};

class LensOcclusion : public RenderTest {
 protected:
  static std::vector<float> render(const scene::Scene& scene, scene::Camera camera, const Wide& wide, float radius) {
    const scene::Environment environment = constantEnvironment();
    camera.lens = wide.lens;
    return visibleSky(
        renderOne(device(), scene, camera, occlusionSettings(wide.width, wide.height, radius), &environment));
  }
};

class LensOcclusionTest : public LensOcclusion, public testing::WithParamInterface<Wide> {};
INSTANTIATE_TEST_SUITE_P(Lenses, LensOcclusionTest, testing::ValuesIn(kWide),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(LensOcclusionTest, AnOpenPlaneDoesNotOccludeItself) {
  const scene::Scene plane = whiteSquares({floorOf(2000)});
  for (const vec3 eye : {vec3(0.3f, 0.05f, 0), vec3(0, 1.7f, 0), vec3(40, 300, 10)})
    for (const vec3 ahead : {vec3(0.3f, -0.2f * eye.y / (eye.y + 1), -1), vec3(0.1f, -1, -0.2f)})
      for (const float radius : {0.5f, 20.0f}) {
        const scene::Camera camera = scene::lookAt(plane, eye, eye + ahead);
        double least = 1;
        size_t covered = 0;
        for (const float v : render(plane, camera, GetParam(), radius))
          if (v >= 0) ++covered, least = std::min(least, double{v});
        EXPECT_GT(covered, 2000u);
        EXPECT_GT(least, 1 - 2e-3) << "from " << eye.y << " m, radius " << radius;
      }
}

bool isCentral(uint32_t x, uint32_t width, uint32_t y, uint32_t height) {
  return x > width / 4 && x < width * 3 / 4 && y > height / 4 && y < height * 3 / 4;
}

TEST_P(LensOcclusionTest, AWallOccludesByItsClosedForm) {
  constexpr float kRadius = 1;
  const scene::Scene scene = whiteSquares({floorOf(8), wallOf(8)});
  const scene::Camera camera = scene::lookAt(scene, {0.3f, 1.4f, 1.5f}, {0, 0.2f, 0.2f});
  const Wide& wide = GetParam();
  const LensCaster caster(scene, camera, wide);
  const std::vector<float> found = render(scene, camera, wide, kRadius);
  const bool cropped = wide.lens.model == LensModel::OpenCv;
  double sum = 0, worst = 0;
  size_t count = 0;
  for (uint32_t y = 1; y < wide.height; y += 3)
    for (uint32_t x = 1; x < wide.width; x += 3) {
      const auto hit = caster.cast({x + 0.5, y + 0.5});
      // Pixels of distant surfaces are as large as the radius, and occluders outside the image are unknown.
      if (!hit || hit->distance > 3 || (cropped && !isCentral(x, wide.width, y, wide.height))) continue;
      // In the world frame, the wall is the plane y = 0 and the floor is z = 0.
      const double away = std::max(std::abs(hit->position.y), std::abs(hit->position.z));
      const double error = std::abs(found[size_t{y} * wide.width + x] - visibilityNearWall(away, kRadius));
      sum += error, ++count;
      if (away > 0.15) worst = std::max(worst, error);
    }
  fmt::print("wall, {}: mean error {:.4f}, worst {:.4f} of {}\n", wide.name, sum / double(count), worst, count);
  EXPECT_GT(count, 300u);
  EXPECT_LT(sum / double(count), 0.02);
  EXPECT_LT(worst, 0.08);
}

// Screen-space occlusion misses occluders that the camera does not see.
TEST_P(LensOcclusionTest, BoxesOccludeAsRaysDo) {
  constexpr float kRadius = 3;
  const scene::Scene scene = whiteBoxes();
  const scene::Camera camera = scene::lookAt(scene, {3, 2.5f, 6}, {0, 0.5f, 0});
  const Wide& wide = GetParam();
  const LensCaster caster(scene, camera, wide);
  const std::vector<float> found = render(scene, camera, wide, kRadius);
  double sum = 0, without = 0;
  size_t count = 0;
  for (uint32_t y = 1; y < wide.height; y += 4)
    for (uint32_t x = 1; x < wide.width; x += 4) {
      const auto hit = caster.cast({x + 0.5, y + 0.5});
      if (!hit || hit->distance > 12) continue;
      const double expected = visibilityByRays(caster.rays, *hit, kRadius);
      sum += std::abs(found[size_t{y} * wide.width + x] - expected), without += std::abs(1 - expected), ++count;
    }
  fmt::print("boxes, {}: mean error {:.4f}; without ambient occlusion {:.4f}\n", wide.name, sum / double(count),
             without / double(count));
  EXPECT_GT(count, 300u);
  EXPECT_LT(sum / double(count), 0.04);
  EXPECT_LT(sum / double(count), 0.5 * without / double(count));
}

TEST_F(LensOcclusion, WithoutDistortionIsThatOfAPinhole) {
  const scene::Scene scene = whiteBoxes();
  const Wide wide{"opencv", {LensModel::OpenCv, 160, 120, 170, 160, 75, 63}, 160, 120};
  Wide pinhole = wide;
  pinhole.lens.model = LensModel::Pinhole;
  const scene::Camera camera = scene.cameras.front();
  const std::vector<float> expected = render(scene, camera, pinhole, 2), found = render(scene, camera, wide, 2);
  double sum = 0, occlusion = 0;
  for (size_t i = 0; i < found.size(); ++i)
    sum += std::abs(found[i] - expected[i]), occlusion += 1 - std::abs(expected[i]);
  const double pixels = double(found.size());
  fmt::print("without distortion: mean difference {:.4f} of {:.4f}\n", sum / pixels, occlusion / pixels);
  EXPECT_LT(sum, 0.05 * occlusion);
}

// Samples off the pixels' centers find the same occlusion.
TEST_F(LensOcclusion, ManySamplesFindTheSameOcclusion) {
  const scene::Scene scene = whiteBoxes();
  const scene::Environment environment = constantEnvironment();
  const Wide& wide = kWide[2];
  scene::Camera camera = scene.cameras.front();
  camera.lens = wide.lens;
  Settings settings = occlusionSettings(wide.width, wide.height, 3);
  const std::vector<float> once = visibleSky(renderOne(device(), scene, camera, settings, &environment));
  settings.aa.superSampling = 2;
  const std::vector<float> often = visibleSky(renderOne(device(), scene, camera, settings, &environment));
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < once.size(); ++i)
    if (once[i] >= 0 && often[i] >= 0) sum += often[i] - once[i], ++count;
  EXPECT_GT(count, 1000u);
  EXPECT_LT(std::abs(sum / double(count)), 0.005);
}

}  // namespace
}  // namespace latelight::render::test
