// Materials at pixel centers: texture slots, samplers, coordinates, vertex colors, masks, double-sided and mirrored
// surfaces, and glTF extensions. The squares face the camera, so that the texture coordinate of every pixel is known.
#include <fmt/core.h>

#include <cmath>

#include "render/gbuffer_reader.h"
#include "scene/gltf_builder.h"
#include "scene/textures/texture.h"
#include "shared/color.h"
#include "shared/random.h"
#include "shared/shade.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using output::Aov;
using scene::Sampler;
using shared::Surface;

constexpr uint32_t kMaterialSize = 64;

// Half the linear width of an 8-bit sRGB code at a linear value, times `factor`. The CPU device decodes sRGB with a
// polynomial; Vulkan requires an accuracy of half a code.
float halfCode(float linear, float factor = 1) {
  const float code = shared::srgbFromLinear(linear / factor);
  const float slope = code <= 0.04045f ? 1 / 12.92f : 2.4f / 1.055f * std::pow((code + 0.055f) / 1.055f, 1.4f);
  return 0.5f * factor * slope / 255;
}

dvec2 uvOf(size_t pixel) {
  return {(static_cast<double>(pixel % kMaterialSize) + 0.5) / kMaterialSize,
          (static_cast<double>(pixel / kMaterialSize) + 0.5) / kMaterialSize};
}

std::vector<glm::u8vec4> randomTexels(uint32_t count, uint64_t seed) {
  shared::Random random(seed);
  std::vector<glm::u8vec4> texels(count);
  for (glm::u8vec4& t : texels) {
    const uint64_t bits = random.bits();
    t = {bits & 255, bits >> 8 & 255, bits >> 16 & 255, bits >> 24 & 255};
  }
  return texels;
}

// --- sampling on the host, mip level 0 ------------------------------------------------------------------------------

int wrappedIndex(int i, int size, scene::Wrap wrap) {
  const auto modulo = [](int a, int b) { return (a % b + b) % b; };
  switch (wrap) {
    case scene::Wrap::Repeat:
      return modulo(i, size);
    case scene::Wrap::Mirror:
      return std::min(modulo(i, 2 * size), 2 * size - 1 - modulo(i, 2 * size));
    case scene::Wrap::Clamp:
      return std::clamp(i, 0, size - 1);
  }
  return 0;
}

struct HostTexture {
  uint32_t width, height;
  bool srgb;
  std::vector<glm::u8vec4> texels;

  vec4 texel(int x, int y, const Sampler& sampler) const {
    const int i = wrappedIndex(x, static_cast<int>(width), sampler.wrapU);
    const int j = wrappedIndex(y, static_cast<int>(height), sampler.wrapV);
    vec4 c = vec4(texels[static_cast<size_t>(j) * width + static_cast<size_t>(i)]) / 255.0f;
    return srgb ? vec4(shared::linearFromSrgb(vec3(c)), c.w) : c;
  }
  vec4 nearest(dvec2 uv, const Sampler& sampler = {}) const {
    return texel(static_cast<int>(std::floor(uv.x * width)), static_cast<int>(std::floor(uv.y * height)), sampler);
  }
  vec4 linear(dvec2 uv, const Sampler& sampler = {}) const {
    const dvec2 p = uv * dvec2(width, height) - 0.5, low = glm::floor(p);
    const int x = static_cast<int>(low.x), y = static_cast<int>(low.y);
    const vec2 f(p - low);
    return glm::mix(glm::mix(texel(x, y, sampler), texel(x + 1, y, sampler), f.x),
                    glm::mix(texel(x, y + 1, sampler), texel(x + 1, y + 1, sampler), f.x), f.y);
  }
  // Distance to the nearest border between texels, in texels.
  double fromBorder(dvec2 uv) const {
    const dvec2 p = uv * dvec2(width, height), d = glm::abs(p - glm::round(p));
    return std::min(d.x, d.y);
  }
};

HostTexture hostTexture(uint32_t width, uint32_t height, bool srgb, uint64_t seed) {
  return {width, height, srgb, randomTexels(width * height, seed)};
}

scene::Texture deviceTexture(const HostTexture& t) {
  return textureOf(t.width, t.height, t.srgb, t.texels);
}

// If a scene contains such a texture, textures with power-of-two sides are stored differently (vk::ImageDesc::oddBase).
HostTexture oddTexture() {
  return hostTexture(5, 3, false, 1);
}

// --- one square -----------------------------------------------------------------------------------------------------

struct Square {
  scene::SceneBuilder builder{"materials"};
  scene::Scene& scene = builder.scene;
  scene::Material material = scene::plainMaterial("material", vec3(1), 1, 1);

  explicit Square(bool extras = false) { scene.meshes.push_back(squareMesh(extras)); }
  // Call once, after the material is complete.
  void place(const glm::mat4& local = glm::mat4(1)) {
    scene.materials.push_back(std::move(material));
    builder.addInstance("square", builder.kRoot, 0, static_cast<uint32_t>(scene.materials.size() - 1), local);
  }
  int add(const HostTexture& texture) {
    scene.textures.push_back(deviceTexture(texture));
    return static_cast<int>(scene.textures.size()) - 1;
  }
};

class MaterialTest : public RenderTest {
 protected:
  // Reads the surfaces of all pixels through `exact`, the layout that stores everything.
  static ReadGbuffer read(const scene::Scene& scene, const scene::Camera& camera = frontCamera()) {
    GbufferReader reader(device(), scene, nullptr);
    return reader.read({&findLayout("exact"), 0, &findTechnique("fullscreen"), shared::kShadingGgx}, camera,
                       kMaterialSize, kMaterialSize);
  }
  template <typename F>
  static void forEach(const ReadGbuffer& gbuffer, F&& check) {
    for (size_t i = 0; i < size_t{kMaterialSize} * kMaterialSize && !HasFatalFailure(); ++i) {
      SCOPED_TRACE(fmt::format("pixel {} {}", i % kMaterialSize, i / kMaterialSize));
      ASSERT_NE(gbuffer.depth[i], 0.0f);
      check(gbuffer.surface(i), uvOf(i));
    }
  }
};

void expectColor(vec3 value, vec3 expected, float tolerance) {
  for (int i = 0; i < 3; ++i) ASSERT_NEAR(value[i], expected[i], tolerance) << "channel " << i;
}

// Expects an sRGB-coded texel times a factor.
void expectDecoded(vec3 value, vec3 factor, vec3 texel) {
  for (int i = 0; i < 3; ++i)
    ASSERT_NEAR(value[i], factor[i] * texel[i], halfCode(factor[i] * texel[i], factor[i])) << "channel " << i;
}

TEST_F(MaterialTest, EverySlotAndFactorReachesItsValue) {
  Square square;
  std::vector<HostTexture> textures;
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
    const bool srgb =
        slot == shared::kTextureBaseColor || slot == shared::kTextureEmissive || slot == shared::kTextureSpecularColor;
    textures.push_back(hostTexture(4, 4, srgb, slot + 1));
    if (slot == shared::kTextureNormal) continue;
    setTexture(square.material, slot, square.add(textures.back()), kNearest);
  }
  shared::Material& m = square.material.data;
  m.baseColor = {0.9f, 0.5f, 0.25f, 1};
  m.metallic = 0.75f;
  m.roughness = 0.5f;
  m.occlusionStrength = 0.6f;
  m.emissive = {4, 2, 0.5f};
  m.specular = 0.8f;
  m.specularColor = {1, 0.7f, 1.5f};
  m.f0 = 0.09f;
  const shared::Material expected = m;
  square.place();
  forEach(read(square.scene), [&](const Surface& s, dvec2 uv) {
    const auto texel = [&](uint32_t slot) { return textures[slot].nearest(uv); };
    expectDecoded(s.baseColor, vec3(expected.baseColor), texel(shared::kTextureBaseColor));
    ASSERT_NEAR(s.metallic, 0.75f * texel(shared::kTextureMetallicRoughness).b, 1e-6f);
    ASSERT_NEAR(s.roughness, 0.5f * texel(shared::kTextureMetallicRoughness).g, 1e-6f);
    ASSERT_NEAR(s.ao, 1 + 0.6f * (texel(shared::kTextureOcclusion).r - 1), 1e-6f);
    expectDecoded(s.emissive, expected.emissive, texel(shared::kTextureEmissive));
    const float specular = 0.8f * texel(shared::kTextureSpecular).a;
    expectDecoded(s.f0, 0.09f * specular * expected.specularColor, texel(shared::kTextureSpecularColor));
    ASSERT_NEAR(s.f90, specular, 1e-6f);
    ASSERT_LT(glm::length(vec2(uv) - s.uv), 1e-6f);
  });
}

TEST_F(MaterialTest, WithoutTexturesFactorsAreTheValues) {
  Square square;
  shared::Material& m = square.material.data;
  m.baseColor = {0.125f, 0.25f, 0.5f, 1};
  m.metallic = 0.375f;
  m.roughness = 0.625f;
  m.emissive = {3, 2, 1};
  m.occlusionStrength = 0.5f;  // ignored without a texture
  square.place();
  forEach(read(square.scene), [&](const Surface& s, dvec2) {
    expectColor(s.baseColor, {0.125f, 0.25f, 0.5f}, 1e-7f);
    ASSERT_EQ(s.metallic, 0.375f);
    ASSERT_EQ(s.roughness, 0.625f);
    ASSERT_EQ(s.emissive, vec3(3, 2, 1));
    ASSERT_EQ(s.ao, 1.0f);
    expectColor(s.f0, vec3(0.04f), 1e-8f);
    ASSERT_EQ(s.f90, 1.0f);
  });
}

// --- samplers -------------------------------------------------------------------------------------------------------

TEST_F(MaterialTest, WrapModesAndFiltersAsTheSamplerSays) {
  constexpr scene::Wrap kWraps[] = {scene::Wrap::Repeat, scene::Wrap::Mirror, scene::Wrap::Clamp};
  const HostTexture texture = hostTexture(8, 4, false, 99);
  for (scene::Wrap wrapU : kWraps)
    for (scene::Wrap wrapV : kWraps)
      for (scene::Filter filter : {scene::Filter::Nearest, scene::Filter::Linear}) {
        const bool withOddTexture = wrapU == wrapV;
        SCOPED_TRACE(fmt::format("wrap {} {}, filter {}", int(wrapU), int(wrapV), int(filter)));
        const Sampler sampler{wrapU, wrapV, filter, filter, scene::MipFilter::None};
        Square square;
        setTexture(square.material, shared::kTextureMetallicRoughness, square.add(texture), sampler);
        if (withOddTexture) square.add(oddTexture());
        // Coordinates range from -1.4 to 2.2 and from -1.3 to 1.5, so every wrap mode is visible on both sides.
        shared::TextureTransform& t = square.material.data.transforms[shared::kTextureMetallicRoughness];
        t.row0 = {3.6f, 0, -1.4f};
        t.row1 = {0, 2.8f, -1.3f};
        square.place();
        forEach(read(square.scene), [&](const Surface& s, dvec2 uv) {
          const dvec2 at(3.6 * uv.x - 1.4, 2.8 * uv.y - 1.3);
          if (filter == scene::Filter::Nearest && texture.fromBorder(at) < 1e-3) return;
          const vec4 expected =
              filter == scene::Filter::Nearest ? texture.nearest(at, sampler) : texture.linear(at, sampler);
          // The CPU device filters 8-bit textures with 8-bit weights and results.
          const float tolerance = filter == scene::Filter::Nearest ? 1e-6f : 2.0f / 255;
          ASSERT_NEAR(s.metallic, expected.b, tolerance);
          ASSERT_NEAR(s.roughness, expected.g, tolerance);
        });
      }
}

// Returns the mip level that is sampled at `texelsPerPixel`, read from a texture whose levels differ by a constant.
float sampledLevel(vk::Device& device, float texelsPerPixel, Sampler sampler, bool withOddTexture = false) {
  constexpr uint32_t kTexels = 256;
  Square square;
  scene::Texture texture = scene::makeTexture({kTexels, kTexels}, false, "levels");
  size_t offset = 0;
  for (uint32_t level = 0; level < texture.levels; ++level) {
    const size_t bytes = 4 * size_t{kTexels >> level} * (kTexels >> level);
    std::fill_n(texture.pixels.get() + offset, bytes, static_cast<std::byte>(20 * level));
    offset += bytes;
  }
  square.scene.textures.push_back(std::move(texture));
  if (withOddTexture) square.add(oddTexture());
  setTexture(square.material, shared::kTextureMetallicRoughness, 0, sampler);
  const float scale = texelsPerPixel * kMaterialSize / kTexels;
  shared::TextureTransform& t = square.material.data.transforms[shared::kTextureMetallicRoughness];
  t.row0 = {scale, 0, 0};
  t.row1 = {0, scale, 0};
  square.place();
  GbufferReader reader(device, square.scene, nullptr);
  const ReadGbuffer gbuffer = reader.read({&findLayout("exact"), 0, &findTechnique("fullscreen"), 0}, frontCamera(),
                                          kMaterialSize, kMaterialSize);
  const float first = gbuffer.surface(0).metallic;
  for (size_t i = 0; i < size_t{kMaterialSize} * kMaterialSize; ++i)
    EXPECT_NEAR(gbuffer.surface(i).metallic, first, 1e-2f);
  return first * 255 / 20;
}

TEST_F(MaterialTest, MipLevelsFollowTheFootprint) {
  const Sampler none{.mip = scene::MipFilter::None}, nearest{.mip = scene::MipFilter::Nearest},
      linear{.mip = scene::MipFilter::Linear};
  for (int level = 0; level <= 5; ++level) {
    SCOPED_TRACE(level);
    const float texels = std::exp2(static_cast<float>(level));
    EXPECT_NEAR(sampledLevel(device(), texels, nearest), level, 0.01f);
    EXPECT_NEAR(sampledLevel(device(), texels, linear), level, 0.1f);
    EXPECT_NEAR(sampledLevel(device(), texels, none), 0, 0.01f);
    EXPECT_NEAR(sampledLevel(device(), texels, linear, true), level, 0.1f);
  }
  EXPECT_NEAR(sampledLevel(device(), std::exp2(2.5f), linear), 2.5f, 0.1f);  // between two levels
  EXPECT_NEAR(sampledLevel(device(), 0.25f, linear), 0, 0.01f);              // magnified
}

// --- coordinates and colors -----------------------------------------------------------------------------------------

TEST_F(MaterialTest, EachSlotHasItsOwnTransformAndUvSet) {
  const HostTexture base = hostTexture(8, 8, true, 5), occlusion = hostTexture(8, 8, false, 6);
  Square square(true);
  setTexture(square.material, shared::kTextureBaseColor, square.add(base), kNearest);
  setTexture(square.material, shared::kTextureOcclusion, square.add(occlusion), kNearest);
  const float c = std::cos(0.5f), s = std::sin(0.5f);
  auto& transforms = square.material.data.transforms;
  transforms[shared::kTextureBaseColor] = {vec3(1.5f * c, s, 0.3f), vec3(-1.5f * s, c, -0.2f), 0};
  transforms[shared::kTextureOcclusion] = {vec3(0.5f, 0.1f, 0.7f), vec3(0, 0.7f, 0.4f), 1};
  square.place();
  forEach(read(square.scene), [&](const Surface& surface, dvec2 uv) {
    const dvec2 a(1.5 * c * uv.x + s * uv.y + 0.3f, -1.5 * s * uv.x + c * uv.y - 0.2f);
    const dvec2 second = uv * dvec2(2, 3);  // the second UV set of squareMesh()
    const dvec2 b(0.5 * second.x + 0.1f * second.y + 0.7f, 0.7f * second.y + 0.4f);
    if (base.fromBorder(a) > 1e-3) expectDecoded(surface.baseColor, vec3(1), base.nearest(a));
    if (occlusion.fromBorder(b) > 1e-3) {
      ASSERT_NEAR(surface.ao, occlusion.nearest(b).r, 1e-6f);
    }
    ASSERT_LT(glm::length(vec2(uv) - surface.uv), 1e-6f);  // the output `uv` is UV set 0, as in the file
  });
}

TEST_F(MaterialTest, VertexColorsMultiplyTheBaseColor) {
  Square square(true);
  scene::Mesh& mesh = square.scene.meshes[0];
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const vec2 uv = mesh.attributes[i].uv0;
    mesh.extras[i].color = vec4(uv.x, uv.y, 0.5f * (uv.x + uv.y), 1);  // affine: equal over both triangles
  }
  square.material.data.baseColor = {0.5f, 1, 0.8f, 1};
  square.place();
  forEach(read(square.scene), [&](const Surface& s, dvec2 uv) {
    expectColor(s.baseColor, {0.5 * uv.x, uv.y, 0.4 * (uv.x + uv.y)}, 2e-6f);
  });
}

// --- alpha masks ----------------------------------------------------------------------------------------------------

// A masked red square in front of a blue square, or at the same position. Its alpha is 0 to 255 over 16 texels; the
// cutoff is the alpha of one texel, which remains visible (glTF 2.0, section 3.9.4).
void expectMasked(vk::Device& device, float distance) {
  SCOPED_TRACE(fmt::format("{} m before the square behind", distance));
  Square square;
  square.material.data.baseColor = {0, 0, 1, 1};
  square.place();
  HostTexture texture{4, 4, true, {}};
  for (int i = 0; i < 16; ++i) texture.texels.emplace_back(255, 0, 0, 17 * i);
  square.material = scene::plainMaterial("masked", vec3(1), 0, 1);
  square.material.data.flags |= shared::kMaterialMasked;
  square.material.data.alphaCutoff = 17 * 6 / 255.0f;
  setTexture(square.material, shared::kTextureBaseColor, square.add(texture), kNearest);
  glm::mat4 local(1);
  local[3].z = distance;
  square.place(local);
  const output::FrameOutput frame =
      renderOne(device, square.scene, frontCamera(),
                settingsOf(kMaterialSize, kMaterialSize, {Aov::Id, Aov::Albedo, Aov::Depth}));
  for (size_t i = 0; i < size_t{kMaterialSize} * kMaterialSize; ++i) {
    const dvec2 uv = uvOf(i);
    const int texel = static_cast<int>(uv.y * 4) * 4 + static_cast<int>(uv.x * 4);
    const bool there = texel >= 6;
    ASSERT_EQ(imageOf(frame, Aov::Id).ids[i], square.scene.instances[there].id) << "texel " << texel;
    ASSERT_LT(glm::length(vec3At(imageOf(frame, Aov::Albedo), i) - (there ? vec3(1, 0, 0) : vec3(0, 0, 1))), 1e-3f);
    ASSERT_NEAR(imageOf(frame, Aov::Depth).values[i], there ? 4 - distance : 4.0f, 1e-5f);
  }
}

TEST_F(MaterialTest, MasksCutBelowTheCutoff) {
  expectMasked(device(), 0.5f);
}
TEST_F(MaterialTest, MaskedOutTexelsRevealACoplanarSurface) {
  expectMasked(device(), 0);
}

TEST_F(MaterialTest, MasksUseFactorAndVertexAlpha) {
  Square square(true);
  for (vec4* color : {&square.scene.meshes[0].extras[2].color, &square.scene.meshes[0].extras[3].color}) color->a = 0;
  square.material.data.flags |= shared::kMaterialMasked;
  square.material.data.baseColor.a = 0.8f;
  square.material.data.alphaCutoff = 0.5f;  // alpha is 0.8 (1 - u)
  square.place();
  const ReadGbuffer gbuffer = read(square.scene);
  for (size_t i = 0; i < size_t{kMaterialSize} * kMaterialSize; ++i)
    ASSERT_EQ(gbuffer.depth[i] != 0, 0.8 * (1 - uvOf(i).x) >= 0.5) << "pixel " << i % kMaterialSize;
}

TEST_F(MaterialTest, AlphaOfOpaqueMaterialsIsIgnored) {
  Square square;
  square.material.data.baseColor.a = 0.1f;
  square.place();
  forEach(read(square.scene), [](const Surface& s, dvec2) { expectColor(s.baseColor, vec3(1), 1e-6f); });
}

// --- sides, mirrors, normal maps ------------------------------------------------------------------------------------

constexpr glm::u8vec4 kBump(200, 90, 230, 255);

vec3 mapped(vec3 t, vec3 b, vec3 n, float scale = 1) {
  const vec3 map = vec3(kBump) / 127.5f - 1.0f;
  return glm::normalize(t * (map.x * scale) + b * (map.y * scale) + n * map.z);
}

// The axes of the square's tangent frame in the renderer's world space: glTF's X, Y and Z.
constexpr vec3 kX(1, 0, 0), kY(0, 0, 1), kZ(0, -1, 0);

glm::mat4 turnedAround() {  // by 180 degrees about the vertical axis
  glm::mat4 local(1);
  local[0].x = local[2].z = -1;
  return local;
}

scene::Scene bumpySquare(const glm::mat4& local, bool doubleSided, float normalScale = 1, float handedness = 1) {
  Square square;
  for (auto& vertex : square.scene.meshes[0].attributes) vertex.tangent.w = handedness;
  square.scene.textures.push_back(textureOf(1, 1, false, {kBump}));
  setTexture(square.material, shared::kTextureNormal, 0, kNearest);
  square.material.data.normalScale = normalScale;
  if (doubleSided) square.material.data.flags |= shared::kMaterialDoubleSided;
  square.place(local);
  return std::move(square.scene);
}

void expectNormals(const Surface& s, vec3 normal, vec3 geonormal) {
  ASSERT_LT(glm::length(s.normal - normal), 2e-6f);
  ASSERT_LT(glm::length(s.geonormal - geonormal), 1e-6f);
}

TEST_F(MaterialTest, NormalMapsTurnTheTangentFrame) {
  forEach(read(bumpySquare(glm::mat4(1), false)),
          [](const Surface& s, dvec2) { expectNormals(s, mapped(kX, kY, kZ), kZ); });
  forEach(read(bumpySquare(glm::mat4(1), false, 0.4f)),
          [](const Surface& s, dvec2) { expectNormals(s, mapped(kX, kY, kZ, 0.4f), kZ); });
  forEach(read(bumpySquare(glm::mat4(1), false, 1, -1)),
          [](const Surface& s, dvec2) { expectNormals(s, mapped(kX, -kY, kZ), kZ); });
}

TEST_F(MaterialTest, SingleSidedBacksAreNotDrawn) {
  const ReadGbuffer gbuffer = read(bumpySquare(turnedAround(), false));
  for (float depth : gbuffer.depth) ASSERT_EQ(depth, 0.0f);
}

// The whole perturbed normal of a back face is reversed (glTF 2.0, section 3.9.1).
TEST_F(MaterialTest, BacksOfDoubleSidedSquaresFaceTheViewer) {
  forEach(read(bumpySquare(turnedAround(), true)),
          [](const Surface& s, dvec2) { expectNormals(s, -mapped(-kX, kY, -kZ), kZ); });
}

// A mirrored square keeps its front side, and its bumps are mirrored with it.
TEST_F(MaterialTest, MirroredInstancesMirrorTheirNormals) {
  glm::mat4 mirror(1);
  mirror[0].x = -1;
  forEach(read(bumpySquare(mirror, false)), [](const Surface& s, dvec2) { expectNormals(s, mapped(-kX, kY, kZ), kZ); });
  // Viewed from behind, a mirrored square is culled like any other.
  const ReadGbuffer behind = read(bumpySquare(turnedAround() * mirror, false));
  for (float depth : behind.depth) ASSERT_EQ(depth, 0.0f);
  forEach(read(bumpySquare(turnedAround() * mirror, true)),
          [](const Surface& s, dvec2) { expectNormals(s, -mapped(kX, kY, -kZ), kZ); });
}

// A squashed and sheared sphere: the normal stays perpendicular to the surface, like the gradient of the ellipsoid.
TEST_F(MaterialTest, NormalsArePerpendicularToScaledAndShearedSurfaces) {
  for (float mirror : {1.0f, -1.0f}) {
    Square square;
    square.scene.meshes[0] = sphereMesh(1);
    glm::mat4 local(1);
    local[0] = glm::vec4(1.3f * mirror, 0.2f, 0, 0);
    local[1] = glm::vec4(0.3f, 0.5f, 0.1f, 0);
    local[2] = glm::vec4(0, 0, 0.8f, 0);
    square.place(local);
    const glm::mat4 world = square.scene.instances[0].toWorld;
    const glm::dmat3 inverse = glm::inverse(glm::dmat3(world));
    const ReadGbuffer gbuffer = read(square.scene, frontCamera(1.5f));
    size_t covered = 0;
    for (size_t i = 0; i < gbuffer.depth.size(); ++i) {
      if (gbuffer.depth[i] == 0) continue;
      ++covered;
      const Surface s = gbuffer.surface(i);
      const glm::dvec3 gradient = glm::normalize(glm::transpose(inverse) * (inverse * glm::dvec3(s.position)));
      ASSERT_LT(glm::length(glm::dvec3(s.normal) - gradient), 0.05) << "pixel " << i;  // 32 x 16 facets
      ASSERT_GT(glm::dot(s.normal, s.geonormal), 0.95f) << "pixel " << i;
      ASSERT_LT(s.geonormal.y, 1e-6f);  // toward the viewer
    }
    EXPECT_GT(covered, 800u);
  }
}

// --- from files -----------------------------------------------------------------------------------------------------

TEST_F(MaterialTest, ExtensionsOfAFileReachTheSurface) {
  scene::test::GltfBuilder file = scene::test::triangleFile();
  for (const char* extension : {"KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_specular"})
    file.use(extension);
  file.add("materials",
           {{"emissiveFactor", {0.5, 1, 0.25}},
            {"pbrMetallicRoughness",
             {{"baseColorFactor", {0.5, 0.25, 0.75, 1}}, {"metallicFactor", 0.25}, {"roughnessFactor", 0.625}}},
            {"extensions",
             {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}},
              {"KHR_materials_ior", {{"ior", 1.33}}},
              {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {2, 0.5, 60}}}}}}});
  file.primitive()["material"] = 0;
  const ReadGbuffer gbuffer = read(file.load());
  size_t covered = 0;
  for (size_t i = 0; i < gbuffer.depth.size(); ++i) {
    if (gbuffer.depth[i] == 0) continue;
    ++covered;
    const Surface s = gbuffer.surface(i);
    expectColor(s.emissive, {2, 4, 1}, 1e-6f);
    expectColor(s.baseColor, {0.5f, 0.25f, 0.75f}, 1e-6f);
    ASSERT_EQ(s.metallic, 0.25f);
    ASSERT_EQ(s.roughness, 0.625f);
    const float f0 = 0.33f * 0.33f / (2.33f * 2.33f);
    expectColor(s.f0, {f0, 0.25f * f0, 0.5f}, 1e-6f);  // the color is capped at 1 before the weight
    ASSERT_EQ(s.f90, 0.5f);
    expectNormals(s, kZ, kZ);
  }
  EXPECT_NEAR(static_cast<double>(covered), kMaterialSize * kMaterialSize / 8.0,
              kMaterialSize);  // half of a quarter of the image
}

TEST_F(MaterialTest, UnlitFilesKeepTheirBaseColor) {
  scene::test::GltfBuilder file = scene::test::triangleFile();
  file.use("KHR_materials_unlit");
  file.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 0.75, 1}}}},
                         {"extensions", {{"KHR_materials_unlit", scene::test::json::object()}}}});
  file.primitive()["material"] = 0;
  const ReadGbuffer gbuffer = read(file.load());
  for (size_t i = 0; i < gbuffer.depth.size(); ++i) {
    if (gbuffer.depth[i] == 0) continue;
    ASSERT_EQ(gbuffer.surface(i).flags, shared::kSurfaceUnlit);
    expectColor(vec3(gbuffer.after[i]), {0.5f, 0.25f, 0.75f}, 1e-3f);
  }
}

}  // namespace
}  // namespace latelight::render::test
