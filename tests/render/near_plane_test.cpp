// Cameras without a specified near plane. Their images are compared with an independent CPU ray caster whose rays start
// at the camera, and must not depend on the distance of the near plane.
#include <fmt/core.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "render/reference_caster.h"
#include "render/support.h"
#include "scene/framing.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using output::Aov;

constexpr uint32_t kWidth = 160, kHeight = 90;

// Boxes whose faces are visible from outside and from inside; the transforms are in the file's frame.
scene::Scene boxesAt(const std::vector<glm::mat4>& places) {
  scene::SceneBuilder builder("boxes");
  builder.scene.meshes = {squareMesh()};
  builder.scene.materials = {scene::plainMaterial("m", vec3(0.8f), 0, 1)};
  builder.scene.materials.front().data.flags |= shared::kMaterialDoubleSided;
  for (const glm::mat4& place : places)
    for (int face = 0; face < 6; ++face) {
      const float turn = shared::kPi / 2 * static_cast<float>(face);
      glm::mat4 turned = face < 4 ? glm::rotate(glm::mat4(1), turn, vec3(0, 1, 0))
                                  : glm::rotate(glm::mat4(1), turn + shared::kPi / 2, vec3(1, 0, 0));
      turned[3] = turned[2];  // from the box's center to the face's center
      turned[3].w = 1;
      builder.addInstance("face", builder.kRoot, 0, 0, place * turned);
    }
  return std::move(builder.scene);
}

glm::mat4 box(vec3 center, vec3 half) {
  return glm::scale(glm::translate(glm::mat4(1), center), half);
}

class NearPlaneTest : public RenderTest {
 protected:
  // `seen` is the scene at the time of rendering.
  static void expectNothingCut(const std::string& name, const scene::Scene& seen, const scene::Camera& camera,
                               double minCover) {
    const output::FrameOutput frame =
        renderOne(device(), seen, camera, settingsOf(kWidth, kHeight, {Aov::Depth, Aov::Id}));
    scene::Camera ideal = camera;
    ideal.nearClip = 0;
    const ReferenceCaster caster(seen, ideal, kWidth, kHeight);
    // In a view this wide, the clipped ends of an edge lie far away, and snapping them moves the edge by more than a
    // grid cell.
    const auto atOutline = [&](glm::dvec2 center, bool seen) {
      constexpr double kOffset = 0.05;
      return caster.cast(center + glm::dvec2(kOffset, 0)).has_value() != seen ||
             caster.cast(center - glm::dvec2(kOffset, 0)).has_value() != seen ||
             caster.cast(center + glm::dvec2(0, kOffset)).has_value() != seen ||
             caster.cast(center - glm::dvec2(0, kOffset)).has_value() != seen;
    };
    size_t covered = 0, missing = 0, wrong = 0;
    for (size_t i = 0; i < size_t{kWidth} * kHeight; ++i) {
      const glm::dvec2 center(static_cast<double>(i % kWidth) + 0.5, static_cast<double>(i / kWidth) + 0.5);
      const std::optional<Hit> hit = caster.cast(center);
      const double depth = imageOf(frame, Aov::Depth).values[i];
      if (hit) ++covered;
      if (caster.edgeDepth(i) <= (hit ? std::min(hit->depth, depth) : depth) * 1.001) continue;
      if (!hit && std::isinf(depth)) continue;
      if (!hit || std::isinf(depth))
        missing += !atOutline(center, hit.has_value());
      else
        wrong += !(std::abs(depth - hit->depth) <= 1e-4 * hit->depth);
    }
    fmt::print("{}: {} pixels covered, {} missing, {} of another depth\n", name, covered, missing, wrong);
    EXPECT_GE(static_cast<double>(covered), minCover * kWidth * kHeight) << name;
    EXPECT_EQ(missing, 0u) << name;
    EXPECT_EQ(wrong, 0u) << name;
  }
};

TEST_F(NearPlaneTest, NothingIsCutHoweverNear) {
  const scene::Scene scene = boxesAt({box({0, 0, 0}, {1, 1, 1}), box({0, -500, 0}, {500, 0.5f, 500})});
  for (const float distance : {10.0f, 0.5f, 0.02f, 3e-4f}) {
    const vec3 eye(0.013f, 0.027f, 1 + distance);
    expectNothingCut(fmt::format("{} m before the box", distance), scene,
                     scene::lookAt(scene, eye, vec3(0.3f, 0.1f, 0)), distance < 1 ? 0.99 : 0.03);
  }
  expectNothingCut("inside the box", scene, scene::lookAt(scene, {0.2f, 0.3f, 0.1f}, {0.9f, -0.3f, -0.4f}), 1);
}

// Far from a plane's center, its pixels are much nearer along the view direction than along their rays.
TEST_F(NearPlaneTest, NothingIsCutHoweverWide) {
  const scene::Scene scene = boxesAt({box({0, 0, -1}, {500, 500, 1})});
  // A smaller plane: if depth runs from 1 m to 500 m within a few pixels, floats resolve it only to 2e-4.
  const scene::Scene smaller = boxesAt({box({0, 0, -1}, {60, 60, 1})});
  for (const float degrees : {90.0f, 140.0f, 170.0f, 179.0f}) {
    const float fov = glm::radians(degrees);
    expectNothingCut(fmt::format("{} degrees", degrees), scene, scene::lookAt(scene, {0, 0, 1}, {0, 0, 0}, {}, fov),
                     0.99);
    expectNothingCut(fmt::format("{} degrees, aslant", degrees), smaller,
                     scene::lookAt(smaller, {0, 0, 1}, {0.9f, 0.2f, 0.6f}, {}, fov), 0.4);
  }
}

// The camera is created once, for its first position. Then the camera or the scene moves.
TEST_F(NearPlaneTest, NothingIsCutThatMoves) {
  const scene::Scene scene = boxesAt({box({0, 0, 0}, {1, 1, 1}), box({-7, 0, 2}, {2, 2, 2})});
  const scene::Camera far = scene::lookAt(scene, {-200, 3, 0}, {-80, 3, 0});
  const glm::mat4 about = glm::translate(glm::mat4(1), vec3(-100, 0, 0));
  scene::Camera moved = far;
  moved.toWorld =
      glm::dmat4(glm::translate(glm::rotate(about, shared::kPi, vec3(0, 0, 1)), vec3(100, 0, 0))) * far.toWorld;
  expectNothingCut("the camera turned", scene, moved, 0.001);
  moved = far;
  moved.toWorld[3] = glm::vec4(-5.01f, -1.9f, 0.1f, 1);
  expectNothingCut("the camera came near", scene, moved, 0.9);

  const scene::Scene one = boxesAt({box({0, 0, 0}, {1, 1, 1})});
  const scene::Camera before = scene::orbitCamera(one, 0.1f, 0.1f, 40.0f);
  for (const float nearer : {20.0f, 38.5f, 38.99f}) {
    scene::Scene later = boxesAt({box({0, 0, 0}, {1, 1, 1})});
    const glm::mat4 shift = glm::translate(glm::mat4(1), vec3(before.toWorld[1]) * -nearer);
    for (scene::Instance& instance : later.instances) instance.toWorld = glm::dmat4(shift) * instance.toWorld;
    expectNothingCut(fmt::format("the scene came {} m nearer", nearer), later, before, 0.01);
  }
}

TEST_F(NearPlaneTest, NothingIsCutWhateverTheScale) {
  for (const float scale : {1e-6f, 1.0f, 1e9f}) {
    const scene::Scene scene = boxesAt({box({0, 0, 0}, vec3(scale)), box({0, 0, -30 * scale}, vec3(scale * 7))});
    const std::string name = fmt::format("boxes of {} m", scale);
    expectNothingCut(name, scene, scene::frameScene(scene, 16.0f / 9), 0.02);
    expectNothingCut(name + ", near", scene,
                     scene::lookAt(scene, vec3(0.1f, 0.2f, 1.001f) * scale, vec3(0.3f, 0.1f, 0) * scale), 0.99);
  }
}

// A near plane at half the distance halves device depth and changes no digit of its mantissa, so every image is the
// same to the bit. Code that interprets device depth or its square as meters fails this test.
TEST_F(NearPlaneTest, NothingDependsOnHowNearItIs) {
  scene::Scene scene = boxesAt({box({0, 1, 0}, {1, 1, 1}), box({2.5f, 0.5f, 1}, {0.5f, 0.5f, 0.5f}),
                                box({0, -1, 0}, {30, 1, 30}), box({1.2f, 1, 2.2f}, {0.9f, 0.9f, 0.02f})});
  scene.materials.push_back(scene.materials.front());
  scene.materials.back().data.flags |= shared::kMaterialBlended;
  scene.materials.back().data.baseColor.a = 0.5f;
  for (size_t i = scene.instances.size() - 6; i < scene.instances.size(); ++i) scene.instances[i].material = 1;
  for (const uint32_t type : {shared::kLightDirectional, shared::kLightPoint, shared::kLightSpot}) {
    scene::Light light;
    light.type = type;
    light.position = vec3(2, -3, 4);
    light.direction = glm::normalize(vec3(-0.4f, 0.5f, -0.8f));
    light.intensity = type == shared::kLightDirectional ? 2.0f : 40.0f;
    light.outerCone = 0.9f;
    scene.lights.push_back(light);
  }
  scene::Camera camera = scene::lookAt(scene, {3, 2, 7}, {0, 0.5f, 0});
  Settings plain = settingsOf(96, 54, {Aov::Color, Aov::Depth, Aov::Position, Aov::Normal, Aov::Motion});
  plain.shadows = ShadowFormat::D32;
  plain.ambientOcclusion = AmbientOcclusion::Gtao;
  plain.fogDensity = 0.02f;
  const auto with = [&](auto&& change) {
    Settings settings = plain;
    change(settings);
    return settings;
  };
  const std::vector<Settings> all{
      plain,
      with([](Settings& s) {
        s.lighting = &findTechnique("tiled"), s.position = PositionMethod::Matrix,
        s.transparency = TransparencyMethod::Sorted;
      }),
      with([](Settings& s) {
        s.lighting = &findTechnique("clustered"), s.position = PositionMethod::Reciprocal,
        s.transparency = TransparencyMethod::Weighted;
      }),
      with([](Settings& s) {
        s.lighting = &findTechnique("volumes"), s.volumesOrder = VolumesOrder::Killzone,
        s.layout = &findLayout("killzone2");
      }),
      with([](Settings& s) { s.lighting = &findTechnique("forward"), s.aa.temporal = true; }),
      with([](Settings& s) { s.lighting = &findTechnique("clustered"), s.aa.samples = 4; })};
  Renderer renderer(device(), scene, nullptr);
  for (const Settings& settings : all) {
    std::vector<output::FrameOutput> frames;
    for (const float near : {0x1p-20f, 0x1p-40f, 0x1p-64f}) {
      camera.nearClip = near;
      frames.push_back(std::move(renderer.render({&camera, 1}, settings).front()));
    }
    for (const Aov aov : settings.aovs) {
      const std::vector<float>& first = imageOf(frames[0], aov).values;
      size_t same = 0;
      for (size_t i = 0; i < first.size(); ++i)
        same += first[i] == imageOf(frames[1], aov).values[i] && first[i] == imageOf(frames[2], aov).values[i];
      EXPECT_EQ(same, first.size()) << output::info(aov).name << " with " << settings.lighting;
    }
  }
}

}  // namespace
}  // namespace latelight::render::test
