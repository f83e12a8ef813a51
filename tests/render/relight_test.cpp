// Each deferred lighting technique against the host, which shades the device's G-buffer with the same shared headers.
// Covers every pair of layout, normal encoding, technique, shading and kind of light. It requires no golden images: a
// difference is a bug in a shader's reads, lookups or light loops.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "long_tests.h"
#include "pairwise.h"
#include "render/gbuffer_reader.h"
#include "render/host_environment.h"
#include "render/settings/settings.h"
#include "scene/builtin/builtin.h"
#include "scene/half.h"
#include "scene/load/load.h"
#include "shared/diffuse_specular.h"
#include "shared/environment.h"
#include "shared/light.h"
#include "shared/normal_bounds.h"
#include "shared/shade.h"

namespace latelight::render::test {
namespace {

using shared::Surface;
using shared::vec2;
using shared::vec3;
using shared::vec4;

constexpr uint32_t kRelightSize = 100;

shared::Light hostLight(const scene::Light& light) {
  shared::Light l{};
  l.position = light.position;
  l.direction = light.direction;
  l.type = light.type;
  l.intensity = light.color * light.intensity;
  l.radius = light.range.value_or(std::numeric_limits<float>::infinity());
  l.inverseRadius2 = shared::inverseRadius2(l.radius);
  if (light.type == shared::kLightSpot) shared::spotCone(light.innerCone, light.outerCone, l.spotScale, l.spotOffset);
  return l;
}

// --- the scene: a grid of metalness and roughness, and materials that emit, occlude or are unlit --------------------

scene::Scene litSpheres() {
  scene::Scene scene = scene::load("builtin:spheres");
  scene.meshes[0] = sphereMesh(scene::kSpheresRadius);
  scene.textures.push_back(
      textureOf(2, 2, false, {{255, 0, 0, 255}, {90, 0, 0, 255}, {160, 0, 0, 255}, {30, 0, 0, 255}}));
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    shared::Material& m = scene.materials[i].data;
    if (i % 5 == 1) m.emissive = {0.2f, 0.05f, 3.0f};
    if (i % 7 == 2) m.flags |= shared::kMaterialUnlit;
    if (i % 3 == 0) setTexture(scene.materials[i], shared::kTextureOcclusion, 0);
    if (i % 4 == 3) m.specularColor = {0.9f, 0.3f, 2.0f}, m.specular = 0.7f;
  }
  return scene;
}

scene::Light makeLight(uint32_t type, vec3 position, vec3 target, vec3 color, float intensity) {
  scene::Light light;
  light.type = type;
  light.position = position;
  light.direction = glm::normalize(target - position);
  light.color = color;
  light.intensity = intensity;
  return light;
}

// World space: the spheres stand in the plane y = 0 and are viewed from -y. Lights of the same kind are contiguous.
std::vector<scene::Light> directionalLights() {
  return {makeLight(shared::kLightDirectional, {3, -4, 5}, {0, 0, 0}, {1, 0.9f, 0.8f}, 2.5f),
          makeLight(shared::kLightDirectional, {-3, 2, -5}, {0, 0, 0}, {0.2f, 0.3f, 1}, 1.0f)};
}

std::vector<scene::Light> pointLights() {
  std::vector<scene::Light> lights;
  for (int i = 0; i < 11; ++i) {  // more than a subgroup of the CPU device
    const float a = 0.7f * static_cast<float>(i);
    lights.push_back(makeLight(shared::kLightPoint, {3.5f * std::cos(a), -1.5f, 3 * std::sin(1.3f * a)}, vec3(0, 0, 9),
                               {1, 0.3f + 0.06f * static_cast<float>(i), 0.5f}, 1.5f));
    if (i % 2) lights.back().range = 2.0f + 0.3f * static_cast<float>(i);
  }
  return lights;
}

std::vector<scene::Light> spotLights() {
  std::vector<scene::Light> lights{makeLight(shared::kLightSpot, {-2, -4, 2}, {-1, 0, 0}, {1, 1, 0.5f}, 40.0f),
                                   makeLight(shared::kLightSpot, {2, -3, -2}, {1, 0, 0}, {0.3f, 1, 0.9f}, 30.0f)};
  lights[0].innerCone = 0.2f, lights[0].outerCone = 0.45f;
  lights[1].innerCone = 0.0f, lights[1].outerCone = 0.6f, lights[1].range = 6.0f;
  return lights;
}

struct LightCase {
  const char* name;
  LightSettings settings;
};

// Adds all lights to the scene and returns the range of each kind.
std::vector<LightCase> addLights(scene::Scene& scene) {
  std::vector<LightCase> cases{{"no", {}}, {"environment", {.environmentIntensity = 0.7f}}};
  for (auto& [name, lights] :
       {std::pair{"directional", directionalLights()}, {"point", pointLights()}, {"spot", spotLights()}}) {
    cases.push_back({name, {.firstLight = uint32_t(scene.lights.size()), .lightCount = uint32_t(lights.size())}});
    scene.lights.insert(scene.lights.end(), lights.begin(), lights.end());
  }
  cases.push_back({"every", {.environmentIntensity = 0.7f, .lightCount = uint32_t(scene.lights.size())}});
  for (LightCase& light : cases) light.settings.exposure = 1.5f, light.settings.environmentRotation = 0.8f;
  return cases;
}

// --- the comparison -------------------------------------------------------------------------------------------------

// Host and device perform the same operations in the same order. The remaining differences are the result's half float
// (2^-11), a few ULP of pow, exp2 and inversesqrt in narrow lobes, and the filtering of the environment's maps, whose
// weights a device may truncate to 8 bits. The last one matters only if a texel's neighbor is a thousand times as
// bright, so a few pixels may exceed the tolerance. Devices other than the CPU also fuse products into sums, which
// tilts normals at the rim of the discs lambert and spheremap (a root of 1 minus nearly 1) by up to 2^-11.
constexpr float kRelative = 0.01f, kAbsolute = 1e-3f;
constexpr double kMaxBeyond = 1e-4, kMaxBeyondFused = 2e-3;

struct Agreement {
  size_t lit = 0, beyond = 0;
  double worst = 0;      // relative to the tolerance
  double brightest = 0;  // radiance, so that a black image fails
};

vec3 expectedRadiance(const ReadGbuffer& gbuffer, size_t pixel, std::span<const shared::Light> lights,
                      const HostEnvironment& environment, uint32_t shading, const LightSettings& settings) {
  Surface s = gbuffer.surface(pixel);
  if (s.flags & shared::kSurfaceUnlit) s = shared::withoutReflection(s);
  const vec3 toEye = shared::directionToEye(gbuffer.view, s.position);
  vec3 radiance(0);
  const vec2 table = environment.splitSum(glm::dot(s.normal, toEye), s.roughness);
  if (settings.environmentIntensity > 0)
    radiance += environment.turned(settings.environmentRotation).light(s, toEye) * settings.environmentIntensity;
  s.scattered = shared::surfaceReflectance(s, table).scattered;
  const shared::SurfaceBrdf brdf = shared::surfaceBrdf(s, toEye, shading);
  for (const shared::Light& light : lights)
    radiance += shared::shadeLight(brdf, shared::sampleLight(light, s.position), shading);
  return glm::min(vec3(gbuffer.before[pixel]) + radiance * settings.exposure, vec3(65504.0f));
}

Agreement compare(const ReadGbuffer& gbuffer, std::span<const shared::Light> lights, const HostEnvironment& environment,
                  uint32_t shading, const LightSettings& settings) {
  Agreement a;
  for (size_t pixel = 0; pixel < gbuffer.depth.size(); ++pixel) {
    if (gbuffer.depth[pixel] == 0.0f) {
      EXPECT_EQ(gbuffer.after[pixel], vec4(0)) << "background " << pixel;
      continue;
    }
    EXPECT_EQ(gbuffer.after[pixel].w, 1.0f);
    const vec3 expected = expectedRadiance(gbuffer, pixel, lights, environment, shading, settings);
    double beyond = 0;
    for (int i = 0; i < 3; ++i) {
      const float allowed = kRelative * std::abs(expected[i]) + kAbsolute;
      beyond = std::max(beyond, double{std::abs(gbuffer.after[pixel][i] - expected[i]) / allowed});
      a.brightest = std::max(a.brightest, double{expected[i]});
      if (std::isnan(gbuffer.after[pixel][i])) beyond = std::numeric_limits<double>::infinity();
    }
    ++a.lit;
    a.beyond += beyond > 1;
    a.worst = std::max(a.worst, beyond);
  }
  return a;
}

void add(Agreement& to, const Agreement& a) {
  to.lit += a.lit, to.beyond += a.beyond;
  to.worst = std::max(to.worst, a.worst);
}

class RelightTest : public RenderTest {
 protected:
  struct Bench {  // the scene on host and device
    scene::Scene scene = litSpheres();
    std::vector<LightCase> cases = addLights(scene);
    scene::Environment studio = scene::loadEnvironment("studio");
    HostEnvironment hostStudio{studio};
    std::vector<shared::Light> lights;
    GbufferReader reader;
    explicit Bench(vk::Device& device) : reader(device, scene, &studio) {
      for (const scene::Light& light : scene.lights) lights.push_back(hostLight(light));
    }
    ReadGbuffer read(const FrameConfig& setup, const LightSettings& settings) {
      return reader.read(setup, scene.cameras.front(), kRelightSize, kRelightSize, settings);
    }
  };
  static void SetUpTestSuite() { bench = std::make_unique<Bench>(device()); }
  static void TearDownTestSuite() { bench.reset(); }
  static std::unique_ptr<Bench> bench;
};
std::unique_ptr<RelightTest::Bench> RelightTest::bench;

std::vector<const TechniqueInfo*> deferredTechniques() {
  std::vector<const TechniqueInfo*> deferred;
  for (const TechniqueInfo& technique : techniques())
    if (!technique.forward) deferred.push_back(&technique);
  return deferred;
}

// The combinations include each pair of light and technique, so no loop over lights is untested.
TEST_F(RelightTest, HostShadesTheDevicesGbufferAlike) {
  const std::vector<const TechniqueInfo*> deferred = deferredTechniques();
  std::vector<latelight::test::Combination> chosen =
      latelight::test::pairwise({layouts().size(), normalEncodings().size(), deferred.size(), choices<Shading>().size(),
                                 bench->cases.size(), choices<NormalSpace>().size(), choices<PositionMethod>().size()},
                                [](const auto& c) {
                                  const Layout& layout = layouts()[c[0]];
                                  return layout.hasTargets() && (c[1] == 0 || !layout.fixedNormal);
                                });
  // A run in part uses the first quarter, whose combinations add the most pairs.
  chosen.resize(latelight::test::rounds(chosen.size(), chosen.size() / 4));
  const double maxBeyond = device().isCpu() ? kMaxBeyond : kMaxBeyondFused;
  std::vector<Agreement> totals(bench->cases.size());
  for (const auto& c : chosen) {
    const FrameConfig setup{.layout = &layouts()[c[0]],
                            .normalEncoding = normalEncodings()[c[1]].index,
                            .lighting = deferred[c[2]],
                            .shading = uint32_t(c[3]),
                            .normalSpace = uint32_t(c[5]),
                            .positionMethod = uint32_t(c[6])};
    const auto& [name, settings] = bench->cases[c[4]];
    SCOPED_TRACE(fmt::format("{}, {} in {} space, {}, {}, {} light, position by {}", setup.layout->name,
                             normalEncodings()[c[1]].name, choices<NormalSpace>()[c[5]].name, setup.lighting->name,
                             choices<Shading>()[c[3]].name, name, choices<PositionMethod>()[c[6]].name));
    const ReadGbuffer gbuffer = bench->read(setup, settings);
    const Agreement a = compare(gbuffer, std::span(bench->lights).subspan(settings.firstLight, settings.lightCount),
                                bench->hostStudio, setup.shading, settings);
    EXPECT_GT(a.lit, kRelightSize * kRelightSize / 3u);
    EXPECT_GT(a.brightest, 0.5);
    EXPECT_LE(static_cast<double>(a.beyond), maxBeyond * static_cast<double>(a.lit));
    add(totals[c[4]], a);
  }
  fmt::print("{} combinations\n", chosen.size());
  for (size_t i = 0; i < totals.size(); ++i)
    fmt::print("{} light: {} of {} pixels beyond {} relative + {}; the worst is {:.3f} times that\n",
               bench->cases[i].name, totals[i].beyond, totals[i].lit, kRelative, kAbsolute, totals[i].worst);
}

// The maximum errors of a layout on these spheres. Apart from killzone2, the worst layouts store 8 bits per component
// of the normal and 5 bits of metalness.
struct MaxError {
  double normal = 0.01, diffuse = 0.03;
};
MaxError maxErrorOf(const Layout& layout) {
  // At a sphere's rim, the normal may point away from the view plane by up to 14 degrees in this view and is returned
  // mirrored: 2 sin 14 degrees.
  if (layout.name == "killzone2") return {.normal = 0.55};
  return {};
}

// Every layout and encoding stores the same scene as `exact`, within the precision of its bits. Agreement between host
// and device can therefore not result from both reading wrong data.
TEST_F(RelightTest, EveryGbufferHoldsTheScene) {
  const auto read = [&](const Layout& layout, const NormalEncoding& encoding) {
    return bench->read({.layout = &layout, .normalEncoding = encoding.index, .lighting = &findTechnique("fullscreen")},
                       {});
  };
  const ReadGbuffer exact = read(findLayout("exact"), normalEncodings().front());
  for (const Layout& layout : layouts())
    for (const NormalEncoding& encoding : normalEncodings()) {
      if (!layout.hasTargets() || (layout.fixedNormal && &encoding != &normalEncodings().front())) continue;
      SCOPED_TRACE(layout.name + ", " + encoding.name);
      const ReadGbuffer gbuffer = read(layout, encoding);
      EXPECT_EQ(gbuffer.depth, exact.depth);
      EXPECT_EQ(gbuffer.before, exact.before);
      double position = 0, normal = 0, diffuse = 0;
      for (size_t pixel = 0; pixel < exact.depth.size(); ++pixel) {
        if (exact.depth[pixel] == 0.0f) continue;
        Surface a = exact.surface(pixel);
        const Surface b = gbuffer.surface(pixel);
        position = std::max(position, double{glm::length(a.position - b.position)});
        // An encoding of the near hemisphere loses normals that point away, which perspective causes at the spheres'
        // rims.
        if (!encoding.hemisphere || shared::rotateToView(exact.view, a.normal).y <= 0)
          normal = std::max(normal, double{glm::length(a.normal - b.normal)});
        if (a.flags & shared::kSurfaceUnlit) continue;  // the other layouts store no base color for these
        diffuse = std::max(diffuse, double{shared::maxChannel(glm::abs(shared::diffuseAtNormalIncidence(a) -
                                                                       shared::diffuseAtNormalIncidence(b)))});
      }
      fmt::print("{}, {}: position {:.2g} m, normal {:.2g}, diffuse {:.2g}\n", layout.name, encoding.name, position,
                 normal, diffuse);
      EXPECT_LT(position, 3e-4);  // 15 m away: depth interpolated over steep triangles, 2e-5 relative
      // 8 bits per component, or 12 for two components: the fewest of any layout that follows the encoding. The
      // device's own rounding and rotation are added.
      std::string file = encoding.name;
      std::replace(file.begin(), file.end(), '-', '_');
      const double encoded = 1.01 * shared::normalBound(file, encoding.channels == 2 ? 4095 : 255).radians + 1e-5;
      EXPECT_LT(normal, layout.fixedNormal ? maxErrorOf(layout).normal : encoded);
      EXPECT_LT(diffuse, maxErrorOf(layout).diffuse);
    }
}

}  // namespace
}  // namespace latelight::render::test
