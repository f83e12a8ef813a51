// The loss of precision of G-buffer layouts, per value and in images; and supersampling.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "models/models.h"
#include "render/frame/view.h"
#include "render/gbuffer_reader.h"
#include "scene/load/load.h"
#include "scene/textures/texture.h"
#include "shared/brdf/blinn_phong.h"
#include "shared/color.h"
#include "shared/diffuse_specular.h"
#include "shared/normal_bounds.h"
#include "shared/random.h"
#include "shared/shade.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using output::Aov;
using shared::Random;
using shared::Surface;
using shared::vec2;
using shared::vec3;

TEST(Layouts, BytesPerPixelAreTheSumOfTheirFormats) {
  for (const Layout& layout : layouts())
    for (const NormalEncoding& encoding : normalEncodings()) {
      uint32_t bytes = 0;
      for (size_t i = 0; i < layout.targets.size(); ++i) bytes += vk::texelBytes(layout.format(i, encoding.index));
      const LayoutBytes here = layout.bytesPerPixel(encoding.index);
      EXPECT_EQ(here.targets, bytes) << layout.name << ", " << encoding.name;
      EXPECT_EQ(here.depth, 4u);
      EXPECT_EQ(here.light, 8u);
      EXPECT_EQ(here.total(), bytes + 12);
      EXPECT_EQ(layout.originalBytesPerPixel(encoding.index).targets, bytes);
    }
}

// The sizes are stated in the layouts' own files; they include depth but not the light accumulation target.
TEST(Layouts, HaveTheSizesThatTheirFilesState) {
  const std::pair<const char*, uint32_t> said[] = {
      {"compact", 20}, {"thin", 12},         {"optimized", 16}, {"exact", 116},    {"plain", 68},
      {"engine", 16},  {"battlefield3", 20}, {"blog", 60},      {"killzone2", 16}, {"visibility", 4}};
  for (const auto& [name, bytes] : said)
    for (const NormalEncoding& encoding : normalEncodings()) {
      const LayoutBytes here = findLayout(name).bytesPerPixel(encoding.index);
      EXPECT_EQ(here.targets + here.depth, bytes) << name << ", " << encoding.name;
    }
}

// Valient 2007: four targets of R8G8B8A8, 24 bits of depth and 8 of stencil, about 36 MB at 1280x720 with 2 samples.
TEST(Layouts, KillzonesGbufferIs36Megabytes) {
  const LayoutBytes bytes = findLayout("killzone2").originalBytesPerPixel(0);
  EXPECT_EQ(bytes.total(), 20u);
  EXPECT_EQ(bytes.total() * 1280ull * 720 * 2 / 1'000'000, 36u);
}

// --- round trips ----------------------------------------------------------------------------------------------------

constexpr double kAny = std::numeric_limits<double>::infinity();

// The maximum change of a value by storage. Colors are in units of one 8-bit sRGB code, and diffuse is the color
// reflected at normal incidence. `f0Root` is the root of a dielectric's f0 / 0.16, and the Blinn-Phong power is capped
// at 255.
struct Bounds {
  double normal = 0.1;  // in radians
  double baseColor = kAny, diffuse = 10, specular = 10, metallic = kAny, roughness = kAny, f0Root = kAny, f90 = kAny,
         power = kAny, ao = 0, motion = kAny;
  bool viewersSide = false;  // normals that point away from the view plane are returned mirrored
};
constexpr double kHalfCode = 0.501;           // in units of a code
constexpr double kUnorm8 = 0.5 / 255 + 1e-6;  // for a value in [0, 1]

// The bound for 2^bits - 1 levels per channel, plus the rounding of floats.
double normalBound(const std::string& encoding, double bits) {
  return shared::normalBound(encoding, std::exp2(bits) - 1).radians * 1.001 + 2e-6;
}
std::string encodingFile(const NormalEncoding& encoding) {
  std::string file = encoding.name;
  std::replace(file.begin(), file.end(), '-', '_');
  return file;
}
double normalBound(const NormalEncoding& encoding, double bitsOfTwo, double bitsOfThree) {
  return normalBound(encodingFile(encoding), encoding.channels == 2 ? bitsOfTwo : bitsOfThree);
}

Bounds boundsOf(const Layout& layout, const NormalEncoding& encoding) {
  // The values are divided and multiplied again in floats.
  const Bounds floats{.baseColor = 0.01,
                      .diffuse = 0.01,
                      .specular = 0.01,
                      .metallic = 0,
                      .roughness = 1e-5,
                      .f90 = 1e-6,
                      .power = 0.01};
  const Bounds colors{.diffuse = 2 * kHalfCode, .specular = kHalfCode, .f90 = kUnorm8, .power = kHalfCode};
  Bounds b;
  if (layout.name == "exact")
    return {.normal = 0,
            .baseColor = 0,
            .diffuse = 0,
            .specular = 0,
            .metallic = 0,
            .roughness = 0,
            .f0Root = 0,
            .f90 = 0,
            .power = 0};
  if (layout.name == "plain") return b = floats, b.normal = 0, b;
  if (layout.name == "blog") return b = floats, b.normal = normalBound("octahedral", 16), b;
  if (layout.name == "optimized") return b = colors, b.normal = normalBound(encoding, 16, 10), b;
  if (layout.name == "engine") return b = colors, b.normal = normalBound("xyz", 10), b.ao = kUnorm8, b;
  if (layout.name == "thin")
    return {.normal = normalBound(encoding, 12, 8),
            .baseColor = kHalfCode,
            .diffuse = kAny,
            .specular = kAny,
            .metallic = 0.5 / 31 + 1e-6,
            .roughness = kUnorm8,
            .f0Root = 0.5 / 6 + 1e-6,
            .f90 = 0};
  // The layout stores roots: a step is largest for large values, and for metalness in the middle of the range.
  if (layout.name == "compact")
    return {.normal = normalBound(encoding, 20, 13),
            .baseColor = 0.2,
            .diffuse = 0.5,
            .specular = 0.5,
            .metallic = 1.0 / 1023 + 1e-6,
            .roughness = 1.0 / 4095 + 1e-6,
            .f0Root = 0.5 / 65535 / 0.4 + 1e-6,
            .f90 = 0};
  if (layout.name == "battlefield3")
    return {.normal = normalBound("xyz", 8),
            .baseColor = kHalfCode,
            .diffuse = kAny,
            .specular = kAny,
            .metallic = kUnorm8,
            .roughness = kUnorm8,
            .f0Root = kUnorm8 / 0.4,
            .f90 = 0,
            .ao = kUnorm8};
  // The third component is the root of 1 minus the squares of two halves. This difference may be as small as their
  // rounding error: 2^-11 of each on a device that truncates, which Vulkan permits.
  if (layout.name == "killzone2")
    return {.normal = std::sqrt(2 * std::sqrt(2.0) / 2048) + 1e-3,
            .baseColor = kHalfCode,
            .diffuse = kAny,
            .specular = kAny,
            .f90 = 0,
            .power = kHalfCode,
            .motion = 0.126,
            .viewersSide = true};
  // For a layout that states no bounds: bounds that no usable layout exceeds.
  b.normal = std::max(b.normal, shared::normalBound(encodingFile(encoding), 255).radians);
  b.ao = 0.1;
  return b;
}

struct Sample {
  Surface surface;
  shared::GbufferContext context;
};

Sample randomSample(Random& random, uint32_t encoding, uint32_t space = 0, uint32_t position = 0) {
  scene::Camera camera;
  const vec3 away = random.direction(), right = glm::normalize(glm::cross(away, random.direction()));
  camera.toWorld = glm::mat4(glm::vec4(right, 0), glm::vec4(away, 0), glm::vec4(glm::cross(right, away), 0),
                             glm::vec4(random.direction() * 5.0f, 1));
  camera.nearClip = 0.1f;
  Sample sample{};
  sample.context.view = makeView(camera, 640, 360);
  sample.context.pixel = {random.uniform(0, 640), random.uniform(0, 360)};
  sample.context.normalEncoding = encoding;
  sample.context.normalSpace = space;
  sample.context.positionMethod = position;
  const float depth = random.logUniform(0.2f, 500);
  sample.context.depth = shared::deviceDepth(sample.context.view.projection, depth);

  Surface& s = sample.surface;
  s = shared::emptySurface();
  s.position = shared::positionFromDepth(sample.context);
  s.normal = random.direction();
  if (shared::normalHemisphereOnly(encoding) && shared::rotateToView(sample.context.view, s.normal).y > 0)
    s.normal = -s.normal;
  s.geonormal = random.direction();
  s.baseColor = random.color();
  s.metallic = random.uniform();
  s.roughness = random.uniform();
  s.f0 = vec3(random.uniform(0.0012f, 0.2f));
  s.f90 = 1;
  s.emissive = random.color() * 10.0f;
  s.ao = sample.context.ao = random.uniform();
  s.uv = vec2(random.uniform(-3, 3), random.uniform(-3, 3));
  for (uint32_t* id : {&s.id, &s.part, &s.material}) *id = static_cast<uint32_t>(random.bits());
  s.motion = vec2(random.uniform(-31.75f, 31.75f), random.uniform(-31.75f, 31.75f));
  return sample;
}

double codes(vec3 a, vec3 b) {
  return 255 * shared::maxChannel(glm::abs(shared::srgbFromLinear(a) - shared::srgbFromLinear(b)));
}

double cappedPower(float roughness) {
  return std::min(double{shared::exponentFromRoughness(roughness)}, 255.0);
}

void expectWithin(const Surface& a, const Surface& b, const Bounds& bounds) {
  EXPECT_LE(glm::length(a.normal - b.normal), bounds.normal);
  EXPECT_LE(codes(a.baseColor, b.baseColor), bounds.baseColor);
  // The diffuse color is divided by one minus the specular color and then limited to 1. Half a code of a specular color
  // near white is therefore more than one code of a dark diffuse color.
  const vec3 diffuseA = shared::diffuseAtNormalIncidence(a), diffuseB = shared::diffuseAtNormalIncidence(b);
  constexpr float kHalfCodeNearWhite = 0.0046f;
  if (shared::maxChannel(glm::abs(diffuseA - diffuseB)) > kHalfCodeNearWhite) {
    EXPECT_LE(codes(diffuseA, diffuseB), bounds.diffuse);
  }
  EXPECT_LE(codes(shared::specularF0(a), shared::specularF0(b)), bounds.specular);
  EXPECT_LE(std::abs(a.metallic - b.metallic), bounds.metallic);
  EXPECT_LE(std::abs(a.roughness - b.roughness), bounds.roughness);
  EXPECT_LE(std::abs(std::sqrt(a.f0.x / 0.16f) - std::sqrt(b.f0.x / 0.16f)), bounds.f0Root);
  EXPECT_LE(std::abs(shared::specularF90(a) - shared::specularF90(b)), bounds.f90);
  EXPECT_LE(std::abs(cappedPower(a.roughness) - cappedPower(b.roughness)), bounds.power);
  EXPECT_LE(glm::length(a.position - b.position), 1e-5f * (5.0f + glm::length(a.position)));
  EXPECT_LE(std::abs(a.ao - b.ao), bounds.ao);
  EXPECT_LE(std::max(std::abs(a.motion.x - b.motion.x), std::abs(a.motion.y - b.motion.y)), bounds.motion);
}

Surface stored(const Layout& layout, const Sample& sample) {
  std::vector<TargetValue> values = layout.pack(sample.surface, sample.context);
  EXPECT_EQ(values.size(), layout.targets.size());
  for (size_t t = 0; t < values.size(); ++t)
    values[t] = storedValue(layout.format(t, sample.context.normalEncoding), values[t]);
  return layout.unpack(values, sample.context);
}

// Mirrors a normal that points away from the view plane.
void turnToViewer(Sample& sample) {
  vec3 n = shared::rotateToView(sample.context.view, sample.surface.normal);
  n.y = -std::abs(n.y);
  sample.surface.normal = shared::rotateToWorld(sample.context.view, n);
}

TEST(Layouts, RandomSurfacesSurviveTheirStoredBits) {
  for (const Layout& layout : layouts())
    for (const NormalEncoding& encoding : normalEncodings()) {
      if (!layout.hasTargets()) continue;
      SCOPED_TRACE(layout.name + ", " + encoding.name);
      const Bounds bounds = boundsOf(layout, encoding);
      Random random(7);
      for (int i = 0; i < 20000 && !testing::Test::HasFailure(); ++i) {
        SCOPED_TRACE(i);
        const uint32_t space = i % choices<NormalSpace>().size(), position = i / 3 % choices<PositionMethod>().size();
        Sample sample = randomSample(random, encoding.index, space, position);
        if (bounds.viewersSide) turnToViewer(sample);
        expectWithin(sample.surface, stored(layout, sample), bounds);
      }
    }
}

// Unit normals that point away from the view plane are returned as their mirror images, of the same length: the layout
// stores no sign of the third component.
TEST(Layouts, Killzone2MirrorsNormalsThatPointAway) {
  Random random(17);
  const Layout& layout = findLayout("killzone2");
  size_t mirrored = 0;
  constexpr size_t kCount = 20000;
  for (size_t i = 0; i < kCount; ++i) {
    Sample sample = randomSample(random, shared::kNormal_octahedral);
    const vec3 back = stored(layout, sample).normal;
    mirrored += glm::length(back - sample.surface.normal) > 0.1f;
    EXPECT_NEAR(glm::length(back), 1, 1e-6);
    turnToViewer(sample);
    EXPECT_LE(glm::length(back - sample.surface.normal), 0.03f);
  }
  // Half of all directions, minus those close to the plane.
  EXPECT_NEAR(static_cast<double>(mirrored) / kCount, 0.5 * (1 - 0.05), 0.02);
}

// A static surface has no motion after storage, and each component of a fast motion is clamped with its sign.
TEST(Layouts, Killzone2StoresZeroMotionExactlyAndClampsFastMotion) {
  Random random(37);
  const Layout& layout = findLayout("killzone2");
  Sample sample = randomSample(random, shared::kNormal_octahedral);
  sample.surface.motion = vec2(0);
  EXPECT_EQ(stored(layout, sample).motion, vec2(0));
  sample.surface.motion = vec2(500, -500);
  EXPECT_EQ(stored(layout, sample).motion, vec2(31.75f, -32));
}

TEST(Layouts, BlogNamesTheObjectToPick) {
  Random random(29);
  for (int i = 0; i < 1000; ++i) {
    const Sample sample = randomSample(random, shared::kNormal_octahedral);
    ASSERT_EQ(stored(findLayout("blog"), sample).id, sample.surface.id);
  }
}

TEST(Layouts, Battlefield3sMaterialIdChoosesTheShading) {
  Random random(31);
  for (int i = 0; i < 1000; ++i) {
    Sample sample = randomSample(random, shared::kNormal_octahedral);
    sample.surface.flags = i % 3 == 1 ? shared::kSurfaceUnlit : 0;
    if (i % 3 == 2) sample.surface.f0 = vec3(0), sample.surface.f90 = 0;
    const Surface b = stored(findLayout("battlefield3"), sample);
    ASSERT_EQ(b.flags, sample.surface.flags);
    ASSERT_EQ(b.f90, sample.surface.f90);
    ASSERT_EQ(b.f0.x == 0, i % 3 == 2);
  }
}

// The usual dielectric and a metal of any color: the layout derives metalness from the diffuse and specular colors.
TEST(Layouts, Killzone2TellsMetalsFromTheUsualDielectric) {
  Random random(19);
  const Layout& layout = findLayout("killzone2");
  for (int i = 0; i < 10000; ++i) {
    Sample sample = randomSample(random, shared::kNormal_octahedral);
    Surface& s = sample.surface;
    s.f0 = vec3(0.04f);
    s.metallic = i % 2 ? 1.0f : 0.0f;
    if (s.metallic == 1) s.baseColor = glm::max(s.baseColor, vec3(0.3f));
    const Surface b = stored(layout, sample);
    ASSERT_NEAR(b.metallic, s.metallic, s.metallic == 1 ? 0.02 : 1e-5);
    ASSERT_LE(codes(shared::specularF0(s), shared::specularF0(b)), 2.5);
  }
}

// A partly metallic surface has the same radiance when shaded from diffuse and specular colors as from metalness.
TEST(Layouts, DiffuseAndSpecularColorsShadeAsMetalnessDoes) {
  Random random(23);
  for (int i = 0; i < 20000; ++i) {
    const Sample sample = randomSample(random, shared::kNormal_octahedral);
    const Surface& a = sample.surface;
    const Surface b = shared::withDiffuseSpecular(a, shared::diffuseAtNormalIncidence(a), shared::specularF0(a),
                                                  shared::specularF90(a));
    vec3 toEye = random.direction();
    if (glm::dot(toEye, a.normal) < 0) toEye = -toEye;
    const shared::LightSample light{.toLight = random.direction(), .intensity = vec3(1), .attenuation = 1};
    for (const uint32_t shading : {shared::kShadingGgx, shared::kShadingBlinnPhong}) {
      const vec3 expected = shared::shadeLight(shared::surfaceBrdf(a, toEye, shading), light, shading);
      ASSERT_LE(glm::length(shared::shadeLight(shared::surfaceBrdf(b, toEye, shading), light, shading) - expected),
                1e-5f + 1e-4f * glm::length(expected))
          << i << ", shading " << shading;
    }
  }
}

TEST(Layouts, ExactKeepsEverything) {
  Random random(11);
  const Layout& exact = findLayout("exact");
  for (int i = 0; i < 1000; ++i) {
    Sample sample = randomSample(random, shared::kNormal_octahedral);
    sample.surface.flags = i % 2 ? shared::kSurfaceUnlit : 0;
    const Surface& a = sample.surface;
    const Surface b = exact.unpack(exact.pack(a, sample.context), sample.context);
    ASSERT_EQ(a.position, b.position);
    ASSERT_EQ(a.geonormal, b.geonormal);
    ASSERT_EQ(a.emissive, b.emissive);
    ASSERT_EQ(a.uv, b.uv);
    ASSERT_EQ(a.id, b.id);
    ASSERT_EQ(a.part, b.part);
    ASSERT_EQ(a.material, b.material);
    ASSERT_EQ(a.flags, b.flags);
    ASSERT_EQ(a.f0, b.f0);
  }
}

// Tinted and reduced reflectances are stored as roots in nine bits (f90 in eight). The usual dielectric and a
// reflectance of zero are exact.
TEST(Layouts, CompactKeepsReflectance) {
  Random random(41);
  const Layout& compact = findLayout("compact");
  for (int i = 0; i < 20000; ++i) {
    Sample sample = randomSample(random, shared::kNormal_octahedral);
    Surface& s = sample.surface;
    s.f90 = i % 3 ? random.uniform() : 1;
    s.f0 = (i % 2 ? random.color() : vec3(random.uniform())) * s.f90;
    const Surface b = stored(compact, sample);
    ASSERT_NEAR(std::sqrt(b.f90), std::sqrt(s.f90), 0.5 / 255 + 1e-6);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(std::sqrt(b.f0[c]), std::sqrt(s.f0[c]), 0.5 / 511 + 0.5 / 255 + 1e-5) << i;
  }
  Sample sample = randomSample(random, shared::kNormal_octahedral);
  for (const auto& [f0, f90] : {std::pair(0.04f, 1.0f), {0.0f, 1.0f}, {0.0f, 0.0f}, {1.0f, 1.0f}}) {
    sample.surface.f0 = vec3(f0);
    sample.surface.f90 = f90;
    EXPECT_FLOAT_EQ(stored(compact, sample).f0.y, f0);
    EXPECT_EQ(stored(compact, sample).f90, f90);
  }
}

// For any bits in a target, the values to be shaded are valid numbers.
TEST(Layouts, CompactReturnsNumbersForAnyBits) {
  Random random(43);
  const Layout& compact = findLayout("compact");
  for (int i = 0; i < 20000; ++i) {
    const Sample sample = randomSample(random, normalEncodings()[i % normalEncodings().size()].index);
    TargetValue bits;
    for (int word = 0; word < 4; ++word)
      bits.u[word] = i == 0 ? 0u : i == 1 ? ~0u : static_cast<uint32_t>(random.bits());
    const Surface s = compact.unpack({&bits, 1}, sample.context);
    ASSERT_NEAR(glm::length(s.normal), 1, 1e-4) << i;
    for (const float value : {s.baseColor.x, s.baseColor.z, s.metallic, s.roughness, s.f0.x, s.f0.y, s.f0.z, s.f90}) {
      ASSERT_GE(value, 0) << i;
      ASSERT_LE(value, 1) << i;
    }
  }
}

TEST(Layouts, ThinKeepsTheUsualDielectricAndNoReflectionAtAll) {
  Random random(13);
  const Layout& thin = findLayout("thin");
  Sample sample = randomSample(random, shared::kNormal_octahedral);
  sample.surface.f0 = vec3(0.04f);
  EXPECT_FLOAT_EQ(thin.unpack(thin.pack(sample.surface, sample.context), sample.context).f0.y, 0.04f);
  sample.surface.f0 = vec3(0);
  sample.surface.f90 = 0;
  const Surface none = thin.unpack(thin.pack(sample.surface, sample.context), sample.context);
  EXPECT_EQ(none.f0, vec3(0));
  EXPECT_EQ(none.f90, 0.0f);
}

// --- images ---------------------------------------------------------------------------------------------------------

// Differences of 8-bit images, in levels, over the channels of covered pixels.
struct Difference {
  double mean = 0;
  int percentile = 0;  // the 99.9th percentile
  int most = 0;
  double beyond = 0;  // fraction of channels that differ by more than 2 levels
  size_t count = 0;
};

Difference difference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  std::vector<int> levels;
  for (size_t i = 0; i < a.size(); i += 4) {
    EXPECT_EQ(a[i + 3], b[i + 3]);
    if (b[i + 3] == 0) continue;
    for (size_t c = 0; c < 3; ++c) levels.push_back(std::abs(int{a[i + c]} - int{b[i + c]}));
  }
  std::sort(levels.begin(), levels.end());
  Difference d;
  d.count = levels.size();
  if (levels.empty()) return d;
  d.mean = std::accumulate(levels.begin(), levels.end(), 0.0) / static_cast<double>(levels.size());
  d.most = levels.back();
  d.beyond = static_cast<double>(levels.end() - std::upper_bound(levels.begin(), levels.end(), 2)) /
             static_cast<double>(levels.size());
  d.percentile = levels[static_cast<size_t>(0.999 * static_cast<double>(levels.size() - 1))];
  return d;
}

struct Allowed {
  const char* layout;
  const char* normals;
  double mean;
  int percentile;
};

// Raises perceptual roughness to at least 0.30, where `optimized` ends: a power of 255.
void roughen(scene::Scene& scene) {
  constexpr float kMin = 0.3f;
  for (scene::Material& material : scene.materials) {
    const int index = material.slots[shared::kTextureMetallicRoughness].texture;
    if (index < 0) {
      material.data.roughness = std::max(material.data.roughness, kMin);
      continue;
    }
    scene::Texture& texture = scene.textures[size_t(index)];
    const auto least = static_cast<std::byte>(std::ceil(255 * kMin));
    for (size_t i = 0; i < size_t{texture.width} * texture.height; ++i)
      texture.pixels[4 * i + 1] = std::max(texture.pixels[4 * i + 1], least);
    scene::buildMips(texture);
  }
}

// Bounds are about 1.5 times the values measured on the CPU device (mean, 99.9th percentile), which the comments state.
class LayoutImagesTest : public RenderTest {
 protected:
  static void compare(const char* name, const scene::Scene& scene, std::span<const Allowed> allowed,
                      const scene::Environment* environment) {
    Settings settings = settingsOf(320, 180);
    settings.display = true;
    settings.layout = &findLayout("exact");
    const scene::Camera camera = cameraOf(scene, settings.width, settings.height);
    Renderer renderer(device(), scene, environment);
    const std::vector<uint8_t> exact = renderer.render({&camera, 1}, settings).front().display;
    for (const Allowed& a : allowed) {
      SCOPED_TRACE(fmt::format("{}, {}, {}", name, a.layout, a.normals));
      settings.layout = &findLayout(a.layout);
      settings.normals = &findNormalEncoding(a.normals);
      const Difference d = difference(renderer.render({&camera, 1}, settings).front().display, exact);
      fmt::print("{}, {}, {}: mean {:.3f} levels, 99.9 % within {}\n", name, a.layout, a.normals, d.mean, d.percentile);
      EXPECT_GT(d.count, 10000u);
      EXPECT_LE(d.mean, a.mean);
      EXPECT_LE(d.percentile, a.percentile);
    }
  }
};

// All surfaces are matte or have roughness 0.5, and there is one light, so the only error is rounding, mostly of
// normals.
TEST_F(LayoutImagesTest, BoxesDifferByRounding) {
  constexpr Allowed kAllowed[] = {{"thin", "octahedral", 0.4, 2},       // 0.20, 1
                                  {"thin", "xyz", 0.9, 3},              // 0.60, 2: 8 bits per component
                                  {"optimized", "octahedral", 0.6, 2},  // 0.38, 1
                                  {"optimized", "xyz", 0.9, 2}};        // 0.57, 1
  compare("boxes", scene::load("builtin:boxes"), kAllowed, nullptr);
}

// Shiny models under soft boxes: one with bands of metal and, if available, a real one. `optimized` differs strongly,
// because it caps the power at 255. Without surfaces shinier than that, it is within rounding.
TEST_F(LayoutImagesTest, ShinyModelsDifferByRoundingAndTheCapOfThePower) {
  const scene::Environment studio = scene::loadEnvironment("studio");
  scene::Scene bands = scene::load(models::modelPath("textured.glb"));
  roughen(bands);
  constexpr Allowed kBands[] = {{"thin", "octahedral", 0.25, 2},        // 0.15, 1
                                {"optimized", "octahedral", 0.35, 4}};  // 0.22, 3
  compare("bands, nothing below roughness 0.3", bands, kBands, &studio);
  if (models::withReal({}, {"DamagedHelmet.glb"}).empty()) return;
  scene::Scene scene = scene::load(models::modelPath("DamagedHelmet.glb"));
  constexpr Allowed kAsItIs[] = {{"thin", "octahedral", 0.6, 5},        // 0.38, 3
                                 {"thin", "xyz", 0.9, 10},              // 0.59, 7
                                 {"optimized", "octahedral", 11, 75}};  // 7.85, 53
  compare("helmet", scene, kAsItIs, &studio);
  roughen(scene);
  constexpr Allowed kRoughened[] = {{"thin", "octahedral", 0.5, 3},       // 0.32, 2
                                    {"thin", "xyz", 0.7, 5},              // 0.45, 3
                                    {"optimized", "octahedral", 0.4, 3},  // 0.26, 2
                                    {"optimized", "xyz", 0.45, 3}};       // 0.27, 2
  compare("helmet, nothing below roughness 0.3", scene, kRoughened, &studio);
}

TEST_F(LayoutImagesTest, TheHallDiffersByRoundingAndTheCapOfThePower) {
  constexpr Allowed kAllowed[] = {{"thin", "octahedral", 0.4, 2},         // 0.19, 1
                                  {"thin", "xyz", 0.5, 6},                // 0.25, 4
                                  {"optimized", "octahedral", 1.3, 45}};  // 0.78, 30
  compare("hall", hall(), kAllowed, nullptr);
}

// --- every layout against `plain` -----------------------------------------------------------------------------------

// Maximum difference between the hall lit from a layout and from `plain`, in 8-bit levels over the channels of covered
// pixels: about 1.5 times the values measured on the CPU device. `beyond` is the fraction of channels off by more than
// 2.
struct Quantization {
  const char* layout;
  double mean;
  int most;
  double beyond;
  const char* reason;
};
constexpr Quantization kQuantization[] = {
    // measured: mean, most, beyond
    {"exact", 0.001, 1, 0, "floats both"},                                                       // 0, 0, 0
    {"visibility", 0.001, 1, 0, "what is emitted is rounded with the rest"},                     // 0.0004, 1, 0
    {"blog", 0.0015, 1, 0, "normals of 16 bits a channel"},                                      // 0.0009, 1, 0
    {"compact", 0.07, 1, 0, "roots in 9 to 16 bits, normals of 20 bits a channel"},              // 0.044, 1, 0
    {"thin", 0.3, 5, 0.0002, "normals of 12 bits a channel, metalness of 5, reflectance of 3"},  // 0.189, 3, 1e-5
    {"battlefield3", 0.4, 20, 0.006, "normals of 8 bits a component"},                           // 0.268, 13, 0.0039
    {"optimized", 1.15, 105, 0.08, "the power ends at 255: highlights are wider and dimmer"},    // 0.765, 71, 0.054
    {"engine", 1.15, 105, 0.08, "the power ends at 255: highlights are wider and dimmer"},       // 0.776, 71, 0.053
    {"killzone2", 10, 255, 0.46,
     "normals mirrored, the power's end, one intensity for three channels"},  // 6.58, 218, 0.306
};
// For a layout that states no bounds yet: still an image of the same scene.
constexpr Quantization kUnstated{"", 12, 255, 0.5, "states no bound of its own"};

const Quantization& quantizationOf(const Layout& layout) {
  for (const Quantization& q : kQuantization)
    if (layout.name == q.layout) return q;
  return kUnstated;
}

class PlainTest : public RenderTest {};

TEST_F(PlainTest, DiffersFromEveryLayoutOnlyByQuantization) {
  const scene::Scene scene = scene::load("builtin:hall,triangles=60k,lights=20");
  Settings settings = settingsOf(320, 180);
  settings.display = true;
  const scene::Camera camera = cameraOf(scene, settings.width, settings.height);
  Renderer renderer(device(), scene, nullptr);
  const auto render = [&](const std::string& layout) {
    settings.layout = &findLayout(layout);
    return renderer.render({&camera, 1}, settings).front().display;
  };
  std::vector<uint8_t> plain = render("plain");
  for (const Layout& layout : layouts()) {
    if (layout.name == "plain") continue;
    if (!layout.hasTargets() && std::exchange(settings.raster, Raster::Compute) != Raster::Compute)
      plain = render("plain");  // rasters differ at edges
    const Quantization& allowed = quantizationOf(layout);
    SCOPED_TRACE(fmt::format("{}: {}", layout.name, allowed.reason));
    const Difference d = difference(render(layout.name), plain);
    fmt::print("{}: mean {:.4f} levels, at most {}, {:.5f} beyond 2\n", layout.name, d.mean, d.most, d.beyond);
    EXPECT_GT(d.count, 100000u);
    EXPECT_LE(d.mean, allowed.mean);
    EXPECT_LE(d.most, allowed.most);
    EXPECT_LE(d.beyond, allowed.beyond);
  }
}

// Reports the fraction of the hall's pixels whose normal points away from the view plane, so that killzone2 mirrors it.
TEST_F(PlainTest, TellsHowManyNormalsKillzone2Mirrors) {
  const scene::Scene scene = scene::load("builtin:hall,triangles=60k,lights=20");
  constexpr uint32_t kWidth = 320, kHeight = 180;
  const scene::Camera camera = cameraOf(scene, kWidth, kHeight);
  GbufferReader reader(device(), scene, nullptr);
  const auto read = [&](const char* layout) {
    return reader.read({.layout = &findLayout(layout), .lighting = &findTechnique("fullscreen")}, camera, kWidth,
                       kHeight);
  };
  const ReadGbuffer plain = read("plain"), killzone2 = read("killzone2");
  size_t covered = 0, away = 0;
  double worstMirror = 0, worstKept = 0;
  for (size_t pixel = 0; pixel < plain.depth.size(); ++pixel) {
    if (plain.depth[pixel] == 0.0f) continue;
    ++covered;
    const vec3 expected = shared::rotateToView(plain.view, plain.surface(pixel).normal);
    const vec3 got = shared::rotateToView(plain.view, killzone2.surface(pixel).normal);
    const bool mirrored = expected.y > 0;
    away += mirrored;
    double& worst = mirrored ? worstMirror : worstKept;
    worst = std::max(worst, double{glm::length(got - vec3(expected.x, -std::abs(expected.y), expected.z))});
  }
  const double share = static_cast<double>(away) / static_cast<double>(covered);
  fmt::print("{:.1f} % of {} normals point away; others are off by {:.4f}, mirror images by {:.4f} at most\n",
             100 * share, covered, worstKept, worstMirror);
  EXPECT_GT(share, 0.02);
  EXPECT_LT(share, 0.5);
  const double bound = boundsOf(findLayout("killzone2"), normalEncodings().front()).normal;
  EXPECT_LE(worstKept, bound);
  EXPECT_LE(worstMirror, bound);
}

// --- supersampling --------------------------------------------------------------------------------------------------

// The half-plane to the left of a slanted line through the image's center.
class HalfPlaneTest : public RenderTest {
 protected:
  static constexpr uint32_t kSize = 48;
  static constexpr double kAngle = 0.37;
  // In image coordinates (y down, in pixels): the edge's unit normal, which points into the half-plane.
  static dvec2 inward() { return {-std::cos(kAngle), std::sin(kAngle)}; }
  static double insideBy(dvec2 pixel) { return glm::dot(pixel - dvec2(kSize / 2.0), inward()); }

  static scene::Scene halfPlane() {
    scene::SceneBuilder builder("half-plane");
    builder.scene.meshes.push_back(squareMesh());
    scene::Material material = scene::plainMaterial("white", vec3(1), 0, 1);
    material.data.flags |= shared::kMaterialUnlit;
    builder.scene.materials.push_back(std::move(material));
    const float c = static_cast<float>(std::cos(kAngle)), s = static_cast<float>(std::sin(kAngle));
    glm::mat4 local(1);
    local[0] = glm::vec4(c, s, 0, 0) * 10.0f;
    local[1] = glm::vec4(-s, c, 0, 0) * 10.0f;
    local[3] = glm::vec4(-c * 10, -s * 10, 0, 1);
    builder.addInstance("half", builder.kRoot, 0, 0, local);
    return std::move(builder.scene);
  }

  // The fraction of a pixel's square inside the half-plane: the area of the square clipped by the line.
  static double coverage(uint32_t x, uint32_t y) {
    const dvec2 corners[] = {{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}};
    std::vector<dvec2> clipped;
    for (int i = 0; i < 4; ++i) {
      const dvec2 a = corners[i], b = corners[(i + 1) % 4];
      const double da = insideBy(a), db = insideBy(b);
      if (da >= 0) clipped.push_back(a);
      if ((da >= 0) != (db >= 0)) clipped.push_back(glm::mix(a, b, da / (da - db)));
    }
    double area = 0;
    for (size_t i = 0; i < clipped.size(); ++i) {
      const dvec2 a = clipped[i] - dvec2(x, y), b = clipped[(i + 1) % clipped.size()] - dvec2(x, y);
      area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    return std::abs(area);
  }
};

TEST_F(HalfPlaneTest, SamplesAreCountedAndApproachTheCoverage) {
  const scene::Scene scene = halfPlane();
  double before = 1;
  for (uint32_t n : {1u, 2u, 4u}) {
    SCOPED_TRACE(n);
    Settings settings = settingsOf(kSize, kSize, {Aov::Color});
    settings.aa.superSampling = n;
    settings.display = true;
    settings.tonemap = Tonemap::None;
    const output::FrameOutput frame = renderOne(device(), scene, frontCamera(), settings);
    double sum = 0, worst = 0;
    size_t crossed = 0;
    for (uint32_t y = 0; y < kSize; ++y)
      for (uint32_t x = 0; x < kSize; ++x) {
        int least = 0, most = 0;  // samples inside, without and with those on the edge
        for (uint32_t i = 0; i < n * n; ++i) {
          const double d = insideBy(dvec2(x, y) + (dvec2(i % n, i / n) + 0.5) / double(n));
          least += d > 1.0 / 256;
          most += d > -1.0 / 256;
        }
        const size_t pixel = size_t{y} * kSize + x;
        const float* rgba = &imageOf(frame, Aov::Color).values[4 * pixel];
        const float samples = static_cast<float>(n * n);
        ASSERT_GE(rgba[3] * samples, static_cast<float>(least) - 1e-4f) << x << ' ' << y;
        ASSERT_LE(rgba[3] * samples, static_cast<float>(most) + 1e-4f) << x << ' ' << y;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgba[c], rgba[3], 1e-3f);  // premultiplied white
        // Straight alpha: the color is white wherever any sample is covered.
        ASSERT_EQ(frame.display[4 * pixel], rgba[3] > 0 ? 255 : 0);
        ASSERT_NEAR(frame.display[4 * pixel + 3], 255 * rgba[3], 0.51);
        const double exact = coverage(x, y);
        if (exact <= 0 || exact >= 1) continue;
        ++crossed;
        sum += std::abs(rgba[3] - exact);
        worst = std::max(worst, std::abs(rgba[3] - exact));
      }
    const double mean = sum / static_cast<double>(crossed);
    fmt::print("ss{}: coverage of {} edge pixels off by {:.4f} in the mean, {:.4f} at most\n", n, crossed, mean, worst);
    EXPECT_GT(crossed, kSize);
    // For at most about n of the n * n cells, the line passes on the wrong side of their center.
    EXPECT_LE(worst, 0.6 / n);
    EXPECT_LT(mean, before * 0.6);
    before = mean;
  }
}

TEST_F(HalfPlaneTest, DataAreSampledAtPixelCenters) {
  const scene::Scene scene = scene::load("builtin:boxes");
  std::vector<Aov> data;
  for (const output::AovInfo& info : output::aovs())
    if (info.aov != Aov::Color && info.aov != Aov::Raw) data.push_back(info.aov);
  Settings settings = settingsOf(160, 90, data);
  settings.display = true;
  const output::FrameOutput one = renderOne(device(), scene, scene.cameras.front(), settings);
  settings.aa.superSampling = 4;
  const output::FrameOutput sixteen = renderOne(device(), scene, scene.cameras.front(), settings);
  EXPECT_FALSE(one.display == sixteen.display);
  for (Aov aov : data) {
    EXPECT_EQ(imageOf(one, aov).values, imageOf(sixteen, aov).values) << output::info(aov).name;
    EXPECT_EQ(imageOf(one, aov).ids, imageOf(sixteen, aov).ids);
  }
}

}  // namespace
}  // namespace latelight::render::test
