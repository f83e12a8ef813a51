// Ambient occlusion against ray casting (Embree) and a closed form. The radiance of a white surface without reflectance
// under an environment of radiance 1 equals its visible fraction of the sky.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/base/registry.h"
#include "render/lighting/technique.h"
#include "render/sky_visibility.h"
#include "scene/framing.h"
#include "shared/ambient_occlusion.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using output::Aov;

class AmbientOcclusionTest : public RenderTest {
 protected:
  static std::vector<float> render(const scene::Scene& scene, const scene::Camera& camera, const Settings& settings) {
    const scene::Environment environment = constantEnvironment();
    return visibleSky(renderOne(device(), scene, camera, settings, &environment));
  }
};

// --- an open plane does not occlude itself --------------------------------------------------------------------------

// The view directions range from nearly parallel to the plane to straight down; the horizon is 2 km away.
std::vector<scene::Camera> camerasOver(const scene::Scene& plane) {
  std::vector<scene::Camera> cameras;
  for (vec3 eye : {vec3(0.3f, 0.05f, 0), vec3(0, 1.7f, 0), vec3(40, 300, 10)}) {
    cameras.push_back(scene::lookAt(plane, eye, eye + vec3(0.3f, -0.2f * eye.y / (eye.y + 1), -1)));
    cameras.push_back(scene::lookAt(plane, eye, eye + vec3(0.1f, -1, -0.2f)));
  }
  for (scene::Camera& camera : cameras) camera.nearClip = 0.02f;
  scene::Camera shifted = cameras[2];
  shifted.principal = {0.4f, -0.3f};
  cameras.push_back(shifted);
  scene::Camera orthographic = cameras[2];
  orthographic.orthographic = true;
  orthographic.yHalf = 1;
  orthographic.farClip = 500;
  cameras.push_back(orthographic);
  return cameras;
}

TEST_F(AmbientOcclusionTest, AnOpenPlaneDoesNotOccludeItself) {
  const scene::Scene plane = whiteSquares({floorOf(2000)});
  const scene::Environment environment = constantEnvironment();
  for (const char* lighting : {"fullscreen", "forward"})
    for (const char* layout : {"thin", "exact", "killzone2", "engine"}) {
      if (!std::strcmp(lighting, "forward") && std::strcmp(layout, "thin")) continue;
      SCOPED_TRACE(std::string(lighting) + " " + layout);
      Renderer renderer(device(), plane, &environment);
      for (float radius : {0.5f, 20.0f}) {
        Settings settings = occlusionSettings(160, 90, radius);
        settings.layout = &findLayout(layout);
        settings.lighting = &findTechnique(lighting);
        const std::vector<scene::Camera> cameras = camerasOver(plane);
        const std::vector<output::FrameOutput> frames = renderer.render(cameras, settings);
        for (size_t i = 0; i < frames.size(); ++i) {
          double least = 1;
          size_t covered = 0;
          for (float v : visibleSky(frames[i]))
            if (v >= 0) ++covered, least = std::min(least, double{v});
          EXPECT_GT(covered, 2000u) << "camera " << i;
          EXPECT_GT(least, 1 - 2e-3) << "camera " << i << ", radius " << radius;
        }
      }
    }
}

// --- a wall on a floor, in closed form ------------------------------------------------------------------------------

TEST_F(AmbientOcclusionTest, AWallOccludesByItsClosedForm) {
  const scene::Scene scene = whiteSquares({floorOf(8), wallOf(8)});
  constexpr uint32_t kWidth = 240, kHeight = 160;
  for (bool orthographic : {false, true}) {
    scene::Camera camera = scene::lookAt(scene, {0.5f, 2.5f, 3}, {0, 0.2f, 0.3f});
    if (orthographic) {
      camera.orthographic = true;
      camera.yHalf = 1.2f, camera.farClip = 20;
    } else {
      camera.principal = {0.2f, 0.1f};
    }
    const ReferenceCaster caster(scene, camera, kWidth, kHeight);
    for (float radius : {0.4f, 1.0f}) {
      const std::vector<float> found = render(scene, camera, occlusionSettings(kWidth, kHeight, radius));
      double worst = 0, sum = 0;
      size_t count = 0;
      constexpr double kPixel = 0.02;  // meters, approximately
      // Occluders outside the image are unknown.
      const uint32_t margin = static_cast<uint32_t>(60 * radius);
      for (uint32_t y = margin; y < kHeight - margin; y += 3)
        for (uint32_t x = margin; x < kWidth - margin; x += 7) {
          const auto hit = caster.cast({x + 0.5, y + 0.5});
          // In the world frame, the wall is the plane y = 0 and the floor is z = 0. Each occludes the other.
          const double away = std::max(std::abs(hit->position.y), std::abs(hit->position.z));
          const double error = found[size_t{y} * kWidth + x] - visibilityNearWall(away, radius);
          sum += std::abs(error), ++count;
          // In the corner itself, a pixel is as large as the features that it shows and is averaged with its neighbors.
          if (away > 3 * kPixel) worst = std::max(worst, std::abs(error));
          EXPECT_LT(std::abs(error), 0.15);
        }
      fmt::print("wall, {}, radius {}: mean error {:.4f}, worst {:.4f}\n",
                 orthographic ? "orthographic" : "perspective", radius, sum / double(count), worst);
      EXPECT_LT(sum / double(count), 0.01);
      EXPECT_LT(worst, 0.04);
    }
  }
}

// --- boxes against rays ---------------------------------------------------------------------------------------------

TEST_F(AmbientOcclusionTest, BoxesOccludeAsRaysDo) {
  const scene::Scene scene = whiteBoxes();
  constexpr uint32_t kWidth = 320, kHeight = 180;
  constexpr float kRadius = 3;
  const ReferenceCaster caster(scene, scene.cameras.front(), kWidth, kHeight);
  const std::vector<float> found = render(scene, scene.cameras.front(), occlusionSettings(kWidth, kHeight, kRadius));
  double sum = 0, squares = 0, without = 0;
  size_t count = 0;
  for (uint32_t y = 2; y < kHeight; y += 5)
    for (uint32_t x = 2; x < kWidth; x += 5) {
      const auto hit = caster.cast({x + 0.5, y + 0.5});
      if (!hit) continue;
      const double expected = visibilityByRays(caster, *hit, kRadius);
      const double error = found[size_t{y} * kWidth + x] - expected;
      sum += std::abs(error), squares += error * error, without += std::abs(1 - expected), ++count;
    }
  const double mean = sum / double(count), rms = std::sqrt(squares / double(count));
  fmt::print("boxes: mean error {:.4f}, root mean square {:.4f}; without ambient occlusion {:.4f}\n", mean, rms,
             without / double(count));
  EXPECT_GT(count, 1000u);
  // Screen-space occlusion misses occluders that are not visible to the camera, which causes the remaining error.
  EXPECT_LT(mean, 0.04);
  EXPECT_LT(mean, 0.5 * without / double(count));
}

// --- every layout, technique and number of views --------------------------------------------------------------------

TEST_F(AmbientOcclusionTest, EveryLayoutAndTechniqueShowsTheSame) {
  const scene::Scene scene = whiteBoxes();
  const scene::Environment environment = constantEnvironment();
  Settings settings = occlusionSettings(97, 55, 1);
  settings.layout = &findLayout("exact");
  Renderer renderer(device(), scene, &environment);
  const auto shown = [&] {
    return visibleSky(renderer.render({&scene.cameras.front(), 1}, inTheirRaster(settings)).front());
  };
  const std::vector<float> exact = shown();
  const auto meanFrom = [&](const std::vector<float>& other) {
    double sum = 0;
    for (size_t i = 0; i < exact.size(); ++i) sum += std::abs(exact[i] - other[i]);
    return sum / double(exact.size());
  };
  for (const Layout& layout : layouts()) {
    settings.layout = &layout;
    EXPECT_LT(meanFrom(shown()), 2e-3) << layout.name;
  }
  settings.layout = &findLayout("exact");
  for (const TechniqueInfo& technique : techniques()) {
    settings.lighting = &technique;
    // Boxes are flat, so normals from depth differ only at their edges.
    EXPECT_LT(meanFrom(shown()), technique.forward ? 5e-3 : 1e-6) << technique.name;
  }
  settings.lighting = &findTechnique("fullscreen");
  settings.aoStrength = 0;
  for (float v : shown()) EXPECT_TRUE(v < 0 || v > 1 - 1e-3);
}

TEST_F(AmbientOcclusionTest, ViewsOfABatchEqualSingleViews) {
  const scene::Scene scene = whiteBoxes();
  const scene::Environment environment = constantEnvironment();
  std::vector<scene::Camera> cameras(2, scene.cameras.front());
  cameras[1].toWorld[3].x += 0.7f;
  const Settings settings = occlusionSettings(61, 33, 1);
  Renderer renderer(device(), scene, &environment);
  const auto together = renderer.render(cameras, settings);
  for (size_t i = 0; i < 2; ++i) {
    const auto alone = renderer.render({&cameras[i], 1}, settings);
    EXPECT_EQ(imageOf(together[i], Aov::Color).values, imageOf(alone.front(), Aov::Color).values);
  }
}

// --- the shared functions -------------------------------------------------------------------------------------------

TEST(AmbientOcclusionMath, ArcsAreTheirIntegrals) {
  for (float n = -1.5f; n <= 1.5f; n += 0.25f) {
    const shared::SliceNormal normal{n, std::cos(n), std::sin(n)};
    double integral = 0;
    constexpr int kSteps = 20000;
    const double end = n + M_PI / 2;
    for (int i = 0; i < kSteps; ++i) {
      const double h = end * (i + 0.5) / kSteps;
      if (i % 1000 == 0) {
        EXPECT_NEAR(shared::visibleArc(normal, static_cast<float>(std::cos(end * i / kSteps))), integral, 2e-4);
      }
      integral += std::cos(h - n) * std::sin(h) * end / kSteps;
    }
    EXPECT_NEAR(shared::wholeArc(normal), integral, 1e-4);
  }
}

TEST(AmbientOcclusionMath, PlanesAreKnownByTheirDepth) {
  const vec3 normal = glm::normalize(vec3(0.3f, -0.8f, 0.5f));
  for (uint32_t kind : {shared::kPerspective, shared::kOrthographic})
    for (bool reversed : {true, false}) {
      shared::Projection p{.H = 1.2f, .V = 1.9f, .X = 0.1f, .Z = -0.2f, .kind = kind};
      const float near = 0.5f, far = 60;
      const float first = reversed ? 1.0f : 0.0f, last = 1 - first;
      p.B = kind == shared::kPerspective ? (first - last) / (1 / near - 1 / far) : 0;
      p.A = kind == shared::kPerspective ? first - p.B / near : (last - first) / (far - near);
      if (kind == shared::kOrthographic) p.B = first - p.A * near;
      const auto depthAt = [&](glm::vec2 ndc) {
        // The device depth of the plane through (0, 7, 0) at this position of the image.
        const vec3 a = shared::viewPositionAtDepth(p, ndc, 0), b = shared::viewPositionAtDepth(p, ndc, 1);
        const float t = (glm::dot(normal, vec3(0, 7, 0)) - glm::dot(normal, a)) / glm::dot(normal, b - a);
        return shared::deviceDepth(p, t);
      };
      const glm::vec2 ndc(0.2f, 0.1f);
      const float d = depthAt(ndc), e = 0.01f;
      const glm::vec2 gradient((depthAt(ndc + glm::vec2(e, 0)) - d) / e, (depthAt(ndc + glm::vec2(0, e)) - d) / e);
      const vec3 found = shared::normalFromDepth(p, ndc, d, gradient);
      EXPECT_LT(glm::length(found - normal), 2e-3f);
      // The same with a near plane that is 2^70 times as near.
      constexpr float kNearer = 0x1p-70f;
      p.A *= kNearer, p.B *= kNearer;
      EXPECT_EQ(shared::normalFromDepth(p, ndc, d * kNearer, gradient * kNearer), found);
    }
}

}  // namespace
}  // namespace latelight::render::test
