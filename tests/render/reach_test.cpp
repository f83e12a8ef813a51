// Unbounded lights (without a range) reach everything: their contribution from far away is present in sums of many
// lights, in highlights, and with every technique. References are KHR_lights_punctual and appendix B of glTF 2.0 in
// double precision, without any window.
#include <fmt/core.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "base/error.h"
#include "render/lighting/technique.h"
#include "render/support.h"
#include "shared/brdf_reference.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::dvec3;
using glm::vec3;
using output::Aov;

// The square [-2, 2]^2 in the plane z = 0 of glTF's frame, viewed along -Z from z = 4.
struct Plane {
  scene::SceneBuilder builder{"plane"};
  shared::Surface surface = shared::emptySurface();

  Plane(float roughness, float specular) {
    builder.scene.meshes.push_back(squareMesh());
    scene::Material material = scene::plainMaterial("plain", vec3(0.5f, 0.8f, 0.3f), 0, roughness);
    material.data.specular = specular;
    builder.scene.materials.push_back(std::move(material));
    builder.addInstance("square", builder.kRoot, 0, 0, glm::scale(glm::mat4(1), vec3(2)));
    surface.baseColor = {0.5f, 0.8f, 0.3f};
    surface.roughness = std::max(roughness, 1 / 32.0f);  // kGgxMinAlpha
    surface.f0 = vec3(0.04f * specular);
    surface.f90 = specular;
  }

  void add(vec3 position, float intensity, std::optional<vec3> direction = {}) {
    const glm::mat4 toWorld = scene::toWorldFromGltf();
    scene::Light light;
    light.position = toWorld * glm::vec4(position, 1);
    light.intensity = intensity;
    if (direction) {
      light.type = shared::kLightSpot;
      light.direction = toWorld * glm::vec4(glm::normalize(*direction), 0);
      light.innerCone = 0.05f;
      light.outerCone = 0.3f;
    }
    builder.scene.lights.push_back(light);
  }

  // Radiance that a point of the plane reflects in the direction `toEye`.
  dvec3 radiance(dvec3 point, dvec3 toEye) const {
    dvec3 sum(0);
    const glm::mat4 fromWorld = glm::inverse(scene::toWorldFromGltf());
    for (const scene::Light& light : builder.scene.lights) {
      const dvec3 to = dvec3(fromWorld * glm::vec4(light.position, 1)) - point, l = glm::normalize(to);
      double irradiance = light.intensity / glm::dot(to, to) * l.z;
      if (light.type == shared::kLightSpot) {
        const double outer = std::cos(double{light.outerCone}), inner = std::cos(double{light.innerCone});
        const dvec3 axis(fromWorld * glm::vec4(light.direction, 0));
        const double cone = std::clamp((-glm::dot(l, axis) - outer) / (inner - outer), 0.0, 1.0);
        irradiance *= cone * cone;
      }
      if (l.z <= 0) continue;
      const reference::Vec brdf = reference::gltfBrdf(surface, {0, 0, 1}, {l.x, l.y, l.z}, {toEye.x, toEye.y, toEye.z});
      sum += dvec3(brdf[0], brdf[1], brdf[2]) * irradiance;
    }
    return sum;
  }
};

double srgbLevel(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

struct Choice {
  std::string name, lighting, order = "classic";
};
std::vector<Choice> reachChoices() {
  std::vector<Choice> all{{"volumes killzone", "volumes", "killzone"}};
  for (const TechniqueInfo& technique : techniques()) all.push_back({technique.name, technique.name});
  return all;
}

class ReachTest : public RenderTest {
 protected:
  static constexpr uint32_t kSize = 24;

  // The largest difference from the reference, in 8-bit levels before rounding, and the level of the brightest pixel.
  struct Result {
    double worst = 0, brightest = 0;
  };
  Result compare(Renderer& renderer, const Plane& plane, const Choice& choice, float half, float exposure = 0) {
    Settings settings = settingsOf(kSize, kSize, {Aov::Color});
    settings.layout = &findLayout("exact");
    settings.lighting = &findTechnique(choice.lighting);
    settings.volumesOrder = choiceNamed<VolumesOrder>(choice.order).value();
    settings.exposure = exposure;
    const scene::Camera camera = frontCamera(half);
    const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
    const auto& color = imageOf(frame, Aov::Color).values;
    Result result;
    for (size_t i = 0; i < size_t{kSize} * kSize; ++i) {
      const auto across = [&](size_t pixel) { return (2.0 * (static_cast<double>(pixel) + 0.5) / kSize - 1) * half; };
      const dvec3 expected =
          plane.radiance({across(i % kSize), -across(i / kSize), 0}, {0, 0, 1}) * double{std::exp2(exposure)};
      for (int c = 0; c < 3; ++c) {
        const double level = srgbLevel(expected[c]);
        result.worst = std::max(result.worst, std::abs(srgbLevel(color[4 * i + size_t(c)]) - level));
        result.brightest = std::max(result.brightest, level);
      }
    }
    return result;
  }

  void expectEverywhere(const Plane& plane, float half, double brightest, float exposure = 0) {
    Renderer renderer(device(), plane.builder.scene, nullptr);
    for (const Choice& choice : reachChoices()) {
      SCOPED_TRACE(choice.name);
      const Result result = compare(renderer, plane, choice, half, exposure);
      EXPECT_LT(result.worst, 0.1);  // half floats (0.055 levels), and the BRDF in floats
      EXPECT_GT(result.brightest, brightest);
    }
  }
};

// Each light contributes at most 1.8e-4 lux, which is a sixth of a level; together they contribute 28 levels.
TEST_F(ReachTest, AThousandDimLightsAddUp) {
  std::mt19937 engine(5);
  const auto between = [&](float low, float high) { return std::uniform_real_distribution(low, high)(engine); };
  Plane plane(1, 0);
  for (int i = 0; i < 1000; ++i) plane.add({between(-15, 15), between(-15, 15), between(15, 40)}, 0.04f);
  expectEverywhere(plane, 2, 25);
}

// A light of 0.5 cd at 50 m contributes 2e-4 lux, and a dielectric as smooth as a mirror reflects it as a bright spot.
TEST_F(ReachTest, ADimLightIsVisibleInAMirror) {
  Plane plane(0, 1);
  plane.add({0, 0, 50}, 0.5f);
  expectEverywhere(plane, 0.05f, 150);
}

// Unbounded spot lights end only at their cones, in front of the camera and behind it, at any exposure.
TEST_F(ReachTest, UnboundedSpotLightsEndOnlyAtTheirCones) {
  Plane plane(0.7f, 1);
  plane.add({1, 1, 3}, 40, vec3(-0.2f, -0.3f, -1));
  plane.add({-3, 2, 30}, 2000, vec3(0.1f, -0.05f, -1));
  plane.add({0, -300, 300}, 4e5f, vec3(0, 1, -1));
  plane.add({0, 0.5f, 0.01f}, 0.1f, vec3(1, 0, -0.2f));
  plane.add({0, 0, 5}, 1e4f, vec3(0, 0.3f, 1));  // faces away from the plane
  for (float exposure : {-1.0f, -5.0f}) expectEverywhere(plane, 2, 20, exposure);
}

// lavapipe limits the number of loop iterations. Lights just within the limit are rendered correctly, and one more
// light is rejected.
TEST_F(ReachTest, ManyUnboundedLightsAreCorrectOrRejected) {
  if (!device().isCpu()) GTEST_SKIP() << "skipped: only CPU devices have a limit";
  Plane plane(1, 0), more(1, 0);
  for (int i = 0; i < 20001; ++i)
    for (Plane* p : {&plane, &more})
      if (p == &more || i < 20000) p->add({0.001f * static_cast<float>(i % 200 - 100), 0, 20}, 0.01f);
  Renderer renderer(device(), plane.builder.scene, nullptr);
  for (const char* technique : {"fullscreen", "tiled", "clustered", "forward"}) {
    SCOPED_TRACE(technique);
    const Result result = compare(renderer, plane, {technique, technique}, 2);
    EXPECT_LT(result.worst, 0.1);
    EXPECT_GT(result.brightest, 50);
  }
  Renderer beyond(device(), more.builder.scene, nullptr);
  try {
    compare(beyond, more, {"tiled", "tiled"}, 2);
    FAIL() << "one more light was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
    EXPECT_NE(std::string(error.what()).find("20001"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace latelight::render::test
