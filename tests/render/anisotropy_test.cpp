// Anisotropic texture filtering on a floor at a grazing angle, against the integral of its texture over each pixel.
#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>

#include "base/error.h"
#include "render/support.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;
using output::Aov;

constexpr uint32_t kWidth = 64, kHeight = 24, kTexels = 512, kBlock = 4;
constexpr float kFov = 0.0233f, kDistance = 12;

// Black and white blocks of texels, chosen by a hash.
bool isWhite(uint32_t column, uint32_t row) {
  uint32_t x = (column / kBlock) * 0x9e3779b1u ^ (row / kBlock) * 0x85ebca77u;
  x = (x ^ x >> 15) * 0x2c1b3c6du;
  return ((x ^ x >> 13) & 1) != 0;
}

// Leans the square [-1, 1]^2 back, so that its normal is 80 degrees from the direction to the camera.
glm::mat4 lean() {
  return glm::rotate(glm::mat4(1), -1.396f, vec3(1, 0, 0));
}

struct Floor {
  scene::SceneBuilder builder{"floor"};

  explicit Floor(const std::function<void(scene::Material&)>& change) {
    scene::Scene& scene = builder.scene;
    scene.meshes.push_back(squareMesh());
    std::vector<glm::u8vec4> texels;
    for (uint32_t row = 0; row < kTexels; ++row)
      for (uint32_t column = 0; column < kTexels; ++column)
        texels.push_back(isWhite(column, row) ? glm::u8vec4(255) : glm::u8vec4(0, 0, 0, 255));
    scene.textures.push_back(textureOf(kTexels, kTexels, false, texels));
    scene::Material material = scene::plainMaterial("floor", vec3(1), 0, 1);
    setTexture(material, shared::kTextureBaseColor, 0);
    material.data.flags |= shared::kMaterialUnlit;
    change(material);
    scene.materials.push_back(std::move(material));
    builder.addInstance("floor", builder.kRoot, 0, 0, lean());
  }
};

// The mean of the texture over a pixel, sampled by 32 x 32 rays; empty if a ray misses the floor.
std::optional<double> meanOver(uint32_t x, uint32_t y) {
  constexpr int kRays = 32;
  const glm::dmat3 toLocal = glm::inverse(glm::dmat3(lean()));
  const dvec3 eye = toLocal * dvec3(0, 0, kDistance);
  const double half = std::tan(0.5 * kFov);
  double sum = 0;
  for (int i = 0; i < kRays * kRays; ++i) {
    const dvec2 place(x + (i % kRays + 0.5) / kRays, y + (i / kRays + 0.5) / kRays);
    const dvec3 d = toLocal * dvec3((2 * place.x - kWidth) / kHeight * half, (1 - 2 * place.y / kHeight) * half, -1);
    const dvec3 hit = eye - d * (eye.z / d.z);
    if (std::abs(hit.x) >= 1 || std::abs(hit.y) >= 1) return std::nullopt;
    sum += isWhite(static_cast<uint32_t>((hit.x + 1) / 2 * kTexels), static_cast<uint32_t>((1 - hit.y) / 2 * kTexels));
  }
  return sum / (kRays * kRays);
}

class AnisotropyTest : public RenderTest {
 protected:
  static void SetUpTestSuite() {
    reference.clear();
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) reference.push_back(meanOver(x, y));
  }
  static std::vector<std::optional<double>> reference;

  // Root mean square difference from the reference.
  static double error(const output::AovImage& image, size_t channels) {
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < reference.size(); ++i) {
      if (!reference[i]) continue;
      const double difference = image.values[channels * i] - *reference[i];
      sum += difference * difference;
      ++count;
    }
    EXPECT_GT(count, reference.size() / 2);
    return std::sqrt(sum / static_cast<double>(count));
  }

  // Expects that each degree of anisotropic filtering reduces the error of isotropic filtering.
  void expectSharper(const char* name, const std::function<void(Settings&)>& set,
                     const std::function<void(scene::Material&)>& change, Aov aov = Aov::Color) {
    SCOPED_TRACE(name);
    const Floor floor(change);
    Renderer renderer(device(), floor.builder.scene, nullptr);
    Settings settings = settingsOf(kWidth, kHeight, {aov});
    set(settings);
    const scene::Camera camera = frontPerspective(kFov, kDistance);
    const auto errorWith = [&](std::optional<uint32_t> samples) {
      settings.anisotropy = samples;
      const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
      return error(imageOf(frame, aov), aov == Aov::Color ? 4 : 3);
    };
    const double none = errorWith(1), two = errorWith(2), eight = errorWith(8), sixteen = errorWith(16);
    fmt::print("{}: {:.4f} off without, {:.4f} with 2, {:.4f} with 8, {:.4f} with 16\n", name, none, two, eight,
               sixteen);
    EXPECT_LT(two, 0.95 * none);
    EXPECT_LT(eight, 0.6 * none);  // 0.45 with one sample per pixel
    EXPECT_LT(sixteen, 0.6 * none);
    // Isotropic filtering again: earlier settings have no effect on later frames.
    EXPECT_EQ(errorWith(1), none);
    EXPECT_EQ(errorWith(std::nullopt), device().isCpu() ? none : eight);
  }
};
std::vector<std::optional<double>> AnisotropyTest::reference;

TEST_F(AnisotropyTest, FollowsTheTextureInEveryRenderingPath) {
  const auto same = [](scene::Material&) {};
  expectSharper(
      "deferred", [](Settings&) {}, same);
  // With several samples, shaders state gradients, for which lavapipe of Mesa 25 ignores the sampler's anisotropy:
  // images change if they sample without stating them.
  if (device().info().driver.find("llvmpipe Mesa 25.") == std::string::npos)
    expectSharper(
        "msaa4", [](Settings& s) { s.aa.samples = 4; }, same);
  expectSharper(
      "ss2", [](Settings& s) { s.aa.superSampling = 2; }, same);
  expectSharper(
      "forward", [](Settings& s) { s.lighting = &findTechnique("forward"); }, same);
  expectSharper(
      "blended", [](Settings&) {},
      [](scene::Material& m) {
        m.data.flags |= shared::kMaterialBlended;
        m.data.baseColor.a = 0.999f;  // alpha 1 would make it opaque
      });
  expectSharper(
      "masked", [](Settings&) {},
      [](scene::Material& m) {
        m.data.flags |= shared::kMaterialMasked;
        m.data.alphaCutoff = 0.5f;
      });
  expectSharper(
      "albedo", [](Settings&) {}, same, Aov::Albedo);
}

// Nearest filtering and textures without mip levels are requested by the file and must not change.
TEST_F(AnisotropyTest, LeavesFiltersThatAFileChooses) {
  for (const scene::Sampler& sampler :
       {kNearest, scene::Sampler{.magnify = scene::Filter::Nearest}, scene::Sampler{.mip = scene::MipFilter::None}}) {
    const Floor floor([&](scene::Material& m) { setTexture(m, shared::kTextureBaseColor, 0, sampler); });
    Renderer renderer(device(), floor.builder.scene, nullptr);
    Settings settings = settingsOf(kWidth, kHeight, {Aov::Color});
    const scene::Camera camera = frontPerspective(kFov, kDistance);
    settings.anisotropy = 1;
    const std::vector<float> none = imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values;
    settings.anisotropy = 16;
    EXPECT_EQ(imageOf(renderer.render({&camera, 1}, settings).front(), Aov::Color).values, none);
  }
}

TEST_F(AnisotropyTest, TakesOneToSixteenSamples) {
  const Floor floor([](scene::Material&) {});
  Renderer renderer(device(), floor.builder.scene, nullptr);
  const scene::Camera camera = frontPerspective(kFov, kDistance);
  for (uint32_t samples : {0u, 17u}) {
    Settings settings = settingsOf(kWidth, kHeight, {Aov::Color});
    settings.anisotropy = samples;
    EXPECT_THROW(renderer.render({&camera, 1}, settings), Error) << samples;
  }
}

}  // namespace
}  // namespace latelight::render::test
