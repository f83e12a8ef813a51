// The visible surfaces that rays find (--raster rays) are those of rasterization, except at pixels whose center lies
// near an edge, where rasterization snaps vertices to 1/256 pixel. Other tests compare both with Embree and closed
// forms (the test render_rays).
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "models/models.h"
#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using output::Aov;

class TracedVisibility : public RenderTest {
 protected:
  static output::FrameOutput render(const scene::Scene& scene, const scene::Camera& camera, Settings settings,
                                    Raster raster) {
    settings.raster = raster;
    return renderOne(device(), scene, camera, settings);
  }

  // Compares instances, triangles and depths at the pixels whose triangle remains the same if the image is moved by
  // 1/64 pixel in four directions. Depths may differ by as much as they change over 1/4096 pixel, because the planes of
  // slivers at silhouettes are steep. Returns the share of these pixels.
  static double compare(const scene::Scene& scene, const scene::Camera& camera, const Settings& settings) {
    const output::FrameOutput traced = render(scene, camera, settings, Raster::Rays);
    std::array<output::FrameOutput, 5> rastered;
    for (size_t i = 0; i < rastered.size(); ++i) {
      constexpr float kPixels[5][2] = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}};
      scene::Camera moved = camera;
      moved.principal += glm::vec2(kPixels[i][0] / settings.width, kPixels[i][1] / settings.height) / 32.0f;
      rastered[i] = render(scene, moved, settings, Raster::Compute);
    }
    const size_t pixels = size_t{settings.width} * settings.height;
    size_t inside = 0, wrong = 0, coincident = 0;
    for (size_t i = 0; i < pixels; ++i) {
      const auto same = [&](const output::FrameOutput& frame) {
        for (const Aov aov : {Aov::Triangle, Aov::Part, Aov::Id, Aov::Material})
          if (imageOf(frame, aov).ids[i] != imageOf(rastered[0], aov).ids[i]) return false;
        return true;
      };
      if (!std::ranges::all_of(rastered, same)) continue;
      ++inside;
      const auto depthIn = [&](const output::FrameOutput& frame) { return imageOf(frame, Aov::Depth).values[i]; };
      const float depth = depthIn(rastered[0]), found = depthIn(traced);
      float change = 0;  // over 1/64 pixel; 0 for the background, whose depth is infinite
      for (const output::FrameOutput& moved : rastered)
        if (depthIn(moved) != depth) change = std::max(change, std::abs(depthIn(moved) - depth));
      const bool near = depth == found || std::abs(found - depth) <= 1e-6f * depth + change / 64;
      if (near && !same(traced)) ++coincident;
      if (!near && wrong++ < 5)
        ADD_FAILURE() << "pixel " << i % settings.width << ", " << i / settings.width << ": depth " << found
                      << " instead of " << depth;
    }
    EXPECT_EQ(wrong, 0u);
    // Rounding decides which of two surfaces in one plane is visible.
    EXPECT_LE(coincident, pixels / 10'000);
    return static_cast<double>(inside) / static_cast<double>(pixels);
  }

  // Returns the share of color values that differ by more than 1 %.
  static double differingShare(const output::FrameOutput& rastered, const output::FrameOutput& traced) {
    const std::vector<float>& a = imageOf(rastered, Aov::Color).values;
    const std::vector<float>& b = imageOf(traced, Aov::Color).values;
    size_t different = 0;
    for (size_t i = 0; i < a.size(); ++i) different += std::abs(a[i] - b[i]) > 0.01f * (1 + std::abs(a[i]));
    return static_cast<double>(different) / static_cast<double>(a.size());
  }

  static Settings surfaceSettings(uint32_t width, uint32_t height) {
    return settingsOf(width, height, {Aov::Id, Aov::Part, Aov::Material, Aov::Triangle, Aov::Depth});
  }
};

TEST_F(TracedVisibility, HasTheTrianglesOfTheHall) {
  const scene::Scene scene = scene::load("builtin:hall,triangles=60k,lights=20");
  EXPECT_GT(compare(scene, cameraOf(scene, 320, 180), surfaceSettings(320, 180)), 0.8);
}

TEST_F(TracedVisibility, HasTheTrianglesOfModels) {
  for (const char* name : {"punctual.glb", "intricate.glb", "skinned.glb", "many_materials.glb"}) {
    SCOPED_TRACE(name);
    const scene::Scene scene = scene::load(models::modelPath(name).string());
    compare(scene, cameraOf(scene, 160, 120), surfaceSettings(160, 120));
  }
}

// Single-sided and double-sided squares, two of them with holes by an alpha mask, upright and mirrored, from the front
// and from behind, through perspective and orthographic cameras.
TEST_F(TracedVisibility, CullsBackFacesAndTestsAlpha) {
  for (const float mirror : {1.0f, -1.0f})
    for (const float turned : {0.0f, 3.0f}) {
      scene::SceneBuilder builder("squares");
      addSquareOfFourKinds(builder.scene);
      for (uint32_t kind = 0; kind < 4; ++kind) {
        glm::mat4 place =
            glm::translate(glm::mat4(1), glm::vec3(0.9f * (kind % 2) - 0.45f, 0.9f * (kind / 2) - 0.45f, 0));
        place = glm::rotate(place, turned + 0.3f, glm::vec3(0, 1, 0));
        place = glm::scale(place, glm::vec3(mirror * 0.4f, 0.4f, 0.4f));
        builder.addInstance("square" + std::to_string(kind), builder.kRoot, 0, kind, place);
      }
      const scene::Scene scene = std::move(builder.scene);
      for (const scene::Camera& camera : {frontCamera(1, 4), frontPerspective(0.6f, 4)}) {
        SCOPED_TRACE(fmt::format("mirror {}, turned {}, orthographic {}", mirror, turned, camera.orthographic));
        EXPECT_GT(compare(scene, camera, surfaceSettings(128, 128)), 0.9);
      }
    }
}

// At equal depth, the surface that is drawn last is visible: the order is by material, not by instance.
TEST_F(TracedVisibility, ShowsTheLastOfCoincidentSurfaces) {
  scene::SceneBuilder builder("coincident");
  builder.scene.meshes.push_back(squareMesh());
  for (uint32_t i = 0; i < 3; ++i) {
    scene::Material material = scene::plainMaterial("plain" + std::to_string(i), glm::vec3(0.5f), 0, 1);
    builder.scene.materials.push_back(material);
  }
  for (const uint32_t material : {1u, 2u, 0u})
    builder.addInstance("square" + std::to_string(material), builder.kRoot, 0, material, glm::mat4(1));
  const scene::Scene scene = std::move(builder.scene);
  const Settings settings = surfaceSettings(32, 32);
  const output::FrameOutput rastered = render(scene, frontCamera(1.5f, 4), settings, Raster::Compute);
  const output::FrameOutput traced = render(scene, frontCamera(1.5f, 4), settings, Raster::Rays);
  EXPECT_EQ(imageOf(traced, Aov::Part).ids, imageOf(rastered, Aov::Part).ids);
  EXPECT_EQ(std::set<uint32_t>(imageOf(traced, Aov::Part).ids.begin(), imageOf(traced, Aov::Part).ids.end()).size(),
            2u);
}

// Samples of a pixel have rays of their own, so the image converges to the same anti-aliased edges.
TEST_F(TracedVisibility, SamplesPixels) {
  const scene::Scene scene = scene::load("builtin:boxes");
  const scene::Camera camera = cameraOf(scene, 160, 120);
  for (const uint32_t samples : {2u, 4u, 8u, 16u}) {
    SCOPED_TRACE(samples);
    Settings settings = settingsOf(160, 120, {Aov::Color});
    settings.aa.samples = samples;
    settings.lighting = &findTechnique("clustered");
    const output::FrameOutput rastered = render(scene, camera, settings, Raster::Compute);
    const output::FrameOutput traced = render(scene, camera, settings, Raster::Rays);
    EXPECT_LT(differingShare(rastered, traced), 0.002);
  }
}

// Blended surfaces are rasterized in front of what rays find.
TEST_F(TracedVisibility, ShowsBlendedSurfaces) {
  const scene::Scene scene = scene::load(models::modelPath("blended.glb").string());
  const scene::Camera camera = cameraOf(scene, 96, 96);
  Settings settings = settingsOf(96, 96, {Aov::Color});
  settings.lighting = &findTechnique("clustered");
  const output::FrameOutput rastered = render(scene, camera, settings, Raster::Compute);
  EXPECT_LT(differingShare(rastered, render(scene, camera, settings, Raster::Rays)), 0.005);
}

}  // namespace
}  // namespace latelight::render::test
