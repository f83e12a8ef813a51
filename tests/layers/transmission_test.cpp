// Transmissive surfaces in front of stripes at known positions: refraction against Snell's law, attenuation against
// Beer's law, and blended surfaces in front of and behind them.
#include <fmt/core.h>

#include <array>
#include <cmath>

#include "layers/scenes.h"
#include "render/transparency/transparency.h"

namespace latelight::render::test {
namespace {

using output::Aov;
using Values = std::vector<float>;

constexpr uint32_t kSize = 200;
constexpr float kFov = 0.5f;
constexpr double kDistance = 4, kStripe = 0.25, kAway = 1;

class Transmission : public RenderTest {
 protected:
  static Values seen(const scene::Scene& scene, const char* method = "exact") {
    Settings settings = settingsOf(kSize, kSize, {Aov::Color});
    settings.transparency = choiceNamed<TransparencyMethod>(method).value();
    const scene::Camera camera = frontPerspective(kFov, static_cast<float>(kDistance));
    return imageOf(renderOne(device(), scene, camera, settings), Aov::Color).values;
  }
  static scene::Scene behindPlate(const scene::Material& plate) {
    return stripesBehind(plate, static_cast<float>(kStripe), static_cast<float>(kAway));
  }
};

// The center of a pixel on the plane z = 0.
glm::dvec2 placeOf(size_t pixel) {
  const double scale = std::tan(kFov / 2.0) * kDistance * 2 / kSize;
  return {(static_cast<double>(pixel % kSize) + 0.5 - kSize / 2.0) * scale,
          -(static_cast<double>(pixel / kSize) + 0.5 - kSize / 2.0) * scale};
}

// The point of the stripes' plane that is visible through a plate with this index: the ray is refracted for the length
// `thickness`, and the background is sampled where the eye sees the ray's end.
double strikes(glm::dvec2 at, double ior, double thickness) {
  const glm::dvec3 in = glm::normalize(glm::dvec3(at, -kDistance));
  const glm::dvec2 side = glm::dvec2(in) / ior;
  const glm::dvec3 exit = glm::dvec3(at, 0) + thickness * glm::dvec3(side, -std::sqrt(1 - glm::dot(side, side)));
  return exit.x * (kDistance + kAway) / (kDistance - exit.z);
}

bool isBright(double x) {
  return static_cast<int>(std::floor(x / kStripe)) % 2 == 0;
}

// The distance to the next edge on the stripes' plane, in meters.
double toEdge(double x) {
  const double share = x / kStripe - std::floor(x / kStripe);
  return std::min(share, 1 - share) * kStripe;
}

// Calls the function for each channel of each pixel on the plate, except next to an edge.
void expectStripes(const Values& picture, double thickness, const std::array<double, 3>& ior) {
  const double pixel = std::tan(kFov / 2.0) * (kDistance + kAway) * 2 / kSize;
  size_t checked = 0;
  for (size_t i = 0; i < picture.size() / 4; ++i) {
    const glm::dvec2 at = placeOf(i);
    if (std::abs(at.x) > 0.8 || std::abs(at.y) > 0.8) continue;
    for (size_t c = 0; c < 3; ++c) {
      const double x = strikes(at, ior[c], thickness);
      if (toEdge(x) < 1.5 * pixel) continue;
      ASSERT_NEAR(picture[4 * i + c], isBright(x) ? 1 : 0, 2e-3) << i % kSize << "," << i / kSize << " channel " << c;
      ++checked;
    }
  }
  EXPECT_GT(checked, size_t{kSize} * kSize * 3 / 4);
}

TEST_F(Transmission, ShowsWhatLiesBehindWhereSnellsLawHasIt) {
  for (const float thickness : {0.0f, 0.5f, 0.9f})
    expectStripes(seen(behindPlate(clearPlate(thickness))), thickness, {1.5, 1.5, 1.5});
}

TEST_F(Transmission, DispersionPartsTheChannels) {
  scene::Material plate = clearPlate(0.9f);
  plate.data.layers.dispersion = 6;
  const double spread = 0.5 * 0.025 * 6;  // KHR_materials_dispersion
  expectStripes(seen(behindPlate(plate)), 0.9, {1.5 - spread, 1.5, 1.5 + spread});
}

// The thickness is in object space, so a plate that is stretched along its normal is thicker.
TEST_F(Transmission, ThicknessFollowsTheNode) {
  scene::Scene scene = behindPlate(clearPlate(0.3f));
  scene::Instance& plate = scene.instances.back();
  plate.toWorld = plate.toWorld * glm::scale(glm::dmat4(1), glm::dvec3(1, 1, 3));
  expectStripes(seen(scene), 0.9, {1.5, 1.5, 1.5});
}

TEST_F(Transmission, AbsorbsByBeersLaw) {
  scene::Material plate = clearPlate(0.5f);
  plate.data.layers.attenuationColor = {0.9f, 0.5f, 0.2f};
  plate.data.layers.attenuationDistance = 0.25f;
  plate.data.baseColor = vec4(0.5f, 1, 1, 1);
  const Values picture = seen(behindPlate(plate));
  const size_t middle = (kSize / 2) * kSize + kSize / 2;
  size_t pixel = middle;
  while (!isBright(strikes(placeOf(pixel), 1.5, 0.5)) || toEdge(strikes(placeOf(pixel), 1.5, 0.5)) < kStripe / 3)
    ++pixel;
  const std::array<double, 3> left{0.5 * 0.9 * 0.9, 0.5 * 0.5, 0.2 * 0.2};
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(picture[4 * pixel + c], left[c], 1e-3) << c;
  EXPECT_EQ(picture[4 * pixel + 3], 1);
}

// Blurred stripes lose contrast, but no light.
TEST_F(Transmission, RoughnessBlurs) {
  double before = 1;
  for (const float roughness : {0.0f, 0.15f, 0.3f, 0.5f, 0.8f}) {
    scene::Material plate = clearPlate(0);
    plate.data.roughness = roughness;
    const Values picture = seen(behindPlate(plate));
    double sum = 0, squares = 0, count = 0;
    for (size_t i = 0; i < picture.size() / 4; ++i) {
      const glm::dvec2 at = placeOf(i);
      if (std::abs(at.x) > 0.6 || std::abs(at.y) > 0.6) continue;
      sum += picture[4 * i];
      squares += static_cast<double>(picture[4 * i]) * picture[4 * i];
      ++count;
    }
    const double mean = sum / count, deviation = std::sqrt(std::max(squares / count - mean * mean, 0.0));
    EXPECT_NEAR(mean, 0.5, 0.06) << roughness;
    EXPECT_LT(deviation, before * (roughness > 0 ? 0.97 : 1)) << roughness;
    before = deviation;
  }
  EXPECT_LT(before, 0.05);
}

// If nothing is drawn behind the plate, the environment is visible.
TEST_F(Transmission, ShowsTheEnvironmentWhereNothingElseIs) {
  scene::Scene scene = behindPlate(clearPlate(0.5f));
  for (scene::Instance& instance : scene.instances)
    if (instance.material < 2) instance.removed = true;
  const scene::Environment environment = constantEnvironment();
  const scene::Camera camera = frontPerspective(kFov, static_cast<float>(kDistance));
  const Values picture =
      imageOf(renderOne(device(), scene, camera, settingsOf(kSize, kSize, {Aov::Color}), &environment), Aov::Color)
          .values;
  const size_t middle = 4 * ((kSize / 2) * kSize + kSize / 2);
  for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(picture[middle + c], 1, 2e-3);
  EXPECT_EQ(picture[3], 0);
}

// In front: blended over the plate by alpha. Behind the plate, inside its volume or farther away: transmissive surfaces
// show only opaque ones.
TEST_F(Transmission, MixesWithBlendedSurfacesInOneOrder) {
  const Values alone = seen(behindPlate(clearPlate(0.5f)));
  for (const char* method : {"exact", "sorted"}) {
    for (const float z : {0.5f, -0.2f, -0.8f}) {
      scene::Scene scene = behindPlate(clearPlate(0.5f));
      scene::Material pane = scene::plainMaterial("pane", {0.2f, 0.4f, 0.8f}, 0, 1);
      pane.data.baseColor.a = 0.5f;
      pane.data.flags |= shared::kMaterialBlended | shared::kMaterialUnlit;
      scene.materials.push_back(pane);
      scene::Instance instance = scene.instances.back();
      instance.material = 3;
      instance.toWorld = instance.toWorld * glm::translate(glm::dmat4(1), glm::dvec3(0, 0, z));
      scene.instances.push_back(instance);
      const Values picture = seen(scene, method);
      for (size_t i = 0; i < picture.size() / 4; ++i) {
        const glm::dvec2 at = placeOf(i);
        if (std::abs(at.x) > 0.8 || std::abs(at.y) > 0.8) continue;
        for (size_t c = 0; c < 3; ++c) {
          const float expected =
              z > 0 ? 0.5f * pane.data.baseColor[static_cast<int>(c)] + 0.5f * alone[4 * i + c] : alone[4 * i + c];
          ASSERT_NEAR(picture[4 * i + c], expected, 1e-3) << method << " " << z << " " << i;
        }
      }
    }
  }
}

// A fraction of transmission leaves the rest diffuse, and alpha applies to both.
TEST_F(Transmission, AlphaCoversTransmissionToo) {
  scene::Material plate = clearPlate(0);
  const Values whole = seen(behindPlate(plate));
  plate.data.layers.attenuationColor = vec3(1);
  plate.data.baseColor = vec4(0.5f, 0.5f, 0.5f, 0.25f);
  plate.data.flags |= shared::kMaterialBlended;
  const Values picture = seen(behindPlate(plate));
  const size_t bright = 4 * ((kSize / 2) * kSize + kSize / 2 + 4);
  ASSERT_NEAR(whole[bright], 1, 1e-3);
  EXPECT_NEAR(picture[bright], 0.25 * 0.5 + 0.75, 2e-3);
}

}  // namespace
}  // namespace latelight::render::test
