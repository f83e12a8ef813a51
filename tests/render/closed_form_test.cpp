// Images in which every pixel is known in closed form: boxes viewed along an axis, punctual lights on a plane, computed
// in double precision from the glTF specification, a furnace test, and unlit surfaces.
#include <fmt/core.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include "base/hash.h"
#include "render/support.h"
#include "scene/builtin/builtin.h"
#include "scene/load/load.h"
#include "shared/brdf_reference.h"
#include "shared/color.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;
using output::Aov;

// The sRGB code of a linear value, 0 to 255, not rounded; computed in double precision by the standard's formula.
double srgbLevel(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

// Loss of precision before an image is rounded to 8 bits, in levels. Until then the image is a half float, which a
// device may truncate: relative 2^-11, at most 2^-11 * 255 * 1.055 / 2.4 = 0.055 levels. The rest is for pow and the
// BRDF in float32.
constexpr double kPrecision = 0.1;

// --- builtin:boxes --------------------------------------------------------------------------------------------------

class BoxesTest : public RenderTest {
 protected:
  static constexpr uint32_t kWidth = 320, kHeight = 180;

  struct Face {
    const scene::BoxesBox* box;
    int axis;
    double side;   // -1 or 1: the face's normal along the axis
    double depth;  // planar, in meters
    bool operator==(const Face& f) const { return box == f.box && axis == f.axis && side == f.side; }
  };

  // Direction of the ray through an image coordinate, 1 m along the view axis, in glTF's frame.
  static dvec3 ray(dvec2 pixel) {
    return {(pixel.x - kWidth / 2.0) / kHeight, (kHeight / 2.0 - pixel.y) / kHeight, -1};
  }

  static std::optional<Face> firstFace(dvec2 pixel) {
    const dvec3 eye(scene::kBoxesEye), d = ray(pixel);
    std::optional<Face> first;
    for (const scene::BoxesBox& box : scene::boxesBoxes()) {
      double enter = 0, leave = std::numeric_limits<double>::infinity();
      int axis = -1;
      for (int i = 0; i < 3; ++i) {
        const double a = ((d[i] > 0 ? box.min : box.max)[i] - eye[i]) / d[i];
        const double b = ((d[i] > 0 ? box.max : box.min)[i] - eye[i]) / d[i];
        if (a > enter) enter = a, axis = i;
        leave = std::min(leave, b);
      }
      if (axis >= 0 && enter < leave && (!first || enter < first->depth))
        first = Face{&box, axis, d[axis] > 0 ? -1.0 : 1.0, enter};
    }
    return first;
  }

  // The face at a pixel's center. `edge` is set if another face is within 1/256 px of the center.
  static std::optional<Face> clearFace(uint32_t x, uint32_t y, bool& edge) {
    const dvec2 center(x + 0.5, y + 0.5);
    const std::optional<Face> face = firstFace(center);
    edge = false;
    for (dvec2 offset : {dvec2(1, 0), dvec2(-1, 0), dvec2(0, 1), dvec2(0, -1)})
      if (firstFace(center + offset / 256.0) != face) edge = true;
    return face;
  }

  template <typename F>
  void forEachFace(F&& check) {
    size_t edges = 0, covered = 0;
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        bool edge;
        const std::optional<Face> face = clearFace(x, y, edge);
        edges += edge;
        if (edge || HasFailure()) continue;
        SCOPED_TRACE(fmt::format("pixel {} {}", x, y));
        covered += face.has_value();
        check(size_t{y} * kWidth + x, face, ray({x + 0.5, y + 0.5}));
      }
    EXPECT_LT(edges, kWidth * kHeight / 500u);
    EXPECT_GT(covered, kWidth * kHeight * 9u / 10u);
  }
};

TEST_F(BoxesTest, EveryDataOutputIsTheFacesOwn) {
  const scene::Scene scene = scene::load("builtin:boxes");
  const output::FrameOutput frame =
      renderOne(device(), scene, scene.cameras.front(),
                settingsOf(kWidth, kHeight,
                           {Aov::Depth, Aov::Distance, Aov::Normal, Aov::GeoNormal, Aov::Position, Aov::Id, Aov::Albedo,
                            Aov::Metallic, Aov::Roughness, Aov::Emissive, Aov::Ao}));
  forEachFace([&](size_t i, const std::optional<Face>& face, dvec3 d) {
    ASSERT_EQ(imageOf(frame, Aov::Id).ids[i], face ? hash32("/boxes/" + std::string(face->box->name)) : 0u);
    if (!face) return;
    const scene::BoxesBox& box = *face->box;
    vec3 normal(0);
    normal[face->axis] = static_cast<float>(face->side);
    const double length = glm::length(d);
    ASSERT_NEAR(imageOf(frame, Aov::Depth).values[i], face->depth, 3e-6 * face->depth);
    ASSERT_NEAR(imageOf(frame, Aov::Distance).values[i], face->depth * length, 3e-6 * face->depth * length);
    ASSERT_LT(
        glm::length(dvec3(vec3At(imageOf(frame, Aov::Position), i)) - (dvec3(scene::kBoxesEye) + face->depth * d)),
        5e-6 * face->depth);
    ASSERT_LT(glm::length(vec3At(imageOf(frame, Aov::Normal), i) - normal), 1e-6f);
    ASSERT_LT(glm::length(vec3At(imageOf(frame, Aov::GeoNormal), i) - normal), 1e-6f);
    // Interpolated white vertex colors may differ by one ULP.
    ASSERT_LT(glm::length(vec3At(imageOf(frame, Aov::Albedo), i) - box.baseColor), 2e-7f);
    ASSERT_EQ(vec3At(imageOf(frame, Aov::Emissive), i), box.emissive);
    ASSERT_EQ(imageOf(frame, Aov::Metallic).values[i], box.metallic);
    ASSERT_EQ(imageOf(frame, Aov::Roughness).values[i], box.roughness);
    ASSERT_EQ(imageOf(frame, Aov::Ao).values[i], 1.0f);
  });
}

// References: for matte faces, the radiance stated in scene/builtin/builtin.h; for glossy faces, appendix B of glTF in
// double precision.
TEST_F(BoxesTest, RadianceIsTheFacesOwn) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Settings settings = settingsOf(kWidth, kHeight, {Aov::Color});
  settings.layout = &findLayout("exact");
  settings.tonemap = Tonemap::None;
  settings.display = true;
  const output::FrameOutput frame = renderOne(device(), scene, scene.cameras.front(), settings);
  const auto& color = imageOf(frame, Aov::Color).values;
  forEachFace([&](size_t i, const std::optional<Face>& face, dvec3 d) {
    ASSERT_EQ(color[4 * i + 3], face ? 1.0f : 0.0f);
    ASSERT_EQ(frame.display[4 * i + 3], face ? 255 : 0);
    if (!face) return;
    const scene::BoxesBox& box = *face->box;
    dvec3 normal(0);
    normal[face->axis] = face->side;
    const double cosine = std::max(0.0, -glm::dot(normal, dvec3(-2, -6, -3)) / 7);
    dvec3 expected = dvec3(box.baseColor) * (7.0 / 6) * cosine + dvec3(box.emissive);
    if (box.unlit) expected = box.baseColor;
    if (box.specular > 0) {
      shared::Surface s = shared::emptySurface();
      s.baseColor = box.baseColor;
      s.metallic = box.metallic;
      s.roughness = box.roughness;
      s.f0 = vec3(0.04f * box.specular);
      s.f90 = box.specular;
      const dvec3 v = -glm::normalize(d);
      const reference::Vec brdf =
          reference::gltfBrdf(s, {normal.x, normal.y, normal.z}, {2.0 / 7, 6.0 / 7, 3.0 / 7}, {v.x, v.y, v.z});
      expected = cosine > 0 ? dvec3(brdf[0], brdf[1], brdf[2]) * (cosine * 7 * M_PI / 6) : dvec3(0);
    }
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(color[4 * i + size_t(c)], expected[c], 1e-3 * expected[c] + 1e-6);
      ASSERT_NEAR(frame.display[4 * i + size_t(c)], srgbLevel(expected[c]), 0.5 + kPrecision);
    }
  });
}

// --- punctual lights on a plane -------------------------------------------------------------------------------------

struct PlaneMaterial {
  const char* name;
  vec3 baseColor;
  float metallic, roughness;
  float ior = 1.5f, specular = 1;
  vec3 specularColor{1};
};

// Roughness values and colors that the layout `thin` represents as well, so that it rounds only the normal (12 bits per
// channel).
vec3 decoded(int r, int g, int b) {
  const auto channel = [](int code) { return shared::linearFromSrgb(static_cast<float>(code) / 255.0f); };
  return {channel(r), channel(g), channel(b)};
}
const PlaneMaterial kPlaneMaterials[] = {
    {"paint", decoded(200, 120, 60), 0, 128 / 255.0f},
    {"polished", decoded(90, 160, 220), 0, 51 / 255.0f},
    {"gold", decoded(255, 200, 110), 1, 102 / 255.0f},
    {"chalk", decoded(230, 230, 230), 0, 1},
};
const PlaneMaterial kTintedMaterials[] = {
    {"water", decoded(30, 60, 90), 0, 0.3f, 1.33f},
    {"tinted", decoded(120, 110, 60), 0, 0.45f, 1.8f, 0.6f, {0.9f, 0.4f, 1.7f}},
    {"half metal", decoded(180, 90, 70), 0.5f, 0.35f},
};

struct PlaneLight {
  const char* name;
  scene::Light light;  // position and direction in glTF's frame
};

std::vector<PlaneLight> planeLights() {
  std::vector<PlaneLight> lights(3);
  for (PlaneLight& l : lights) l.light.position = {0.4f, 0.3f, 1.1f}, l.light.color = {1, 0.9f, 0.7f};
  lights[0].name = "point";
  lights[0].light.intensity = 3;
  lights[1].name = "point with range";
  lights[1].light.intensity = 4;
  lights[1].light.range = 1.7f;
  lights[2].name = "spot";
  lights[2].light.type = shared::kLightSpot;
  lights[2].light.intensity = 5;
  lights[2].light.direction = glm::normalize(vec3(-0.3f, -0.2f, -1));
  lights[2].light.innerCone = 0.25f;
  lights[2].light.outerCone = 0.6f;
  return lights;
}

scene::Scene planeScene(const PlaneMaterial& m, scene::Light light) {
  scene::SceneBuilder builder("plane");
  builder.scene.meshes.push_back(squareMesh());
  scene::Material material = scene::plainMaterial(m.name, m.baseColor, m.metallic, m.roughness);
  material.data.f0 = (m.ior - 1) * (m.ior - 1) / ((m.ior + 1) * (m.ior + 1));
  material.data.specular = m.specular;
  material.data.specularColor = m.specularColor;
  builder.scene.materials.push_back(std::move(material));
  glm::mat4 local(1);
  local[0] *= 2.0f, local[1] *= 2.0f;
  builder.addInstance("plane", builder.kRoot, 0, 0, local);
  const glm::mat4 toWorld = scene::toWorldFromGltf();
  light.position = toWorld * glm::vec4(light.position, 1);
  light.direction = toWorld * glm::vec4(light.direction, 0);
  builder.scene.lights.push_back(light);
  return std::move(builder.scene);
}

// KHR_lights_punctual in double precision: irradiance at normal incidence for a color of 1.
double attenuation(const scene::Light& light, dvec3 fromLight) {
  const double distance = glm::length(fromLight);
  double result = light.intensity / (distance * distance);
  if (light.range) result *= std::clamp(1 - std::pow(distance / *light.range, 4), 0.0, 1.0);
  if (light.type == shared::kLightSpot) {
    const double outer = std::cos(double{light.outerCone});
    const double scale = 1 / std::max(0.001, std::cos(double{light.innerCone}) - outer);
    const double cone = std::clamp((glm::dot(fromLight / distance, dvec3(light.direction)) - outer) * scale, 0.0, 1.0);
    result *= cone * cone;
  }
  return result;
}

// The radiance that a camera at (0, 0, 3) receives from the point p of the plane z = 0.
dvec3 planeRadiance(const PlaneMaterial& m, const scene::Light& light, dvec3 p) {
  shared::Surface s = shared::emptySurface();
  s.baseColor = m.baseColor;
  s.metallic = m.metallic;
  s.roughness = m.roughness;
  const double f0 = (double{m.ior} - 1) * (m.ior - 1) / ((double{m.ior} + 1) * (m.ior + 1));
  s.f0 = glm::min(vec3(dvec3(m.specularColor) * f0), vec3(1)) * m.specular;
  s.f90 = m.specular;
  const dvec3 toLight = dvec3(light.position) - p, v = glm::normalize(dvec3(0, 0, 3) - p);
  const dvec3 l = glm::normalize(toLight);
  const reference::Vec brdf = reference::gltfBrdf(s, {0, 0, 1}, {l.x, l.y, l.z}, {v.x, v.y, v.z});
  return dvec3(brdf[0], brdf[1], brdf[2]) * dvec3(light.color) * (attenuation(light, -toLight) * l.z);
}

struct Levels {
  double linear = 0, display = 0;  // largest difference, in 8-bit levels
};

class PlaneTest : public RenderTest {
 protected:
  static constexpr uint32_t kSize = 96;
  static constexpr float kFov = 0.9f;

  Levels compare(const PlaneMaterial& material, const scene::Light& light, const std::string& layout) {
    const scene::Scene scene = planeScene(material, light);
    Settings settings = settingsOf(kSize, kSize, {Aov::Color});
    settings.layout = &findLayout(layout);
    settings.tonemap = Tonemap::None;
    settings.display = true;
    const output::FrameOutput frame = renderOne(device(), scene, frontPerspective(kFov, 3), settings);
    Levels worst;
    double brightest = 0;
    for (size_t i = 0; i < size_t{kSize} * kSize; ++i) {
      const double perPixel = 6 * std::tan(0.5 * kFov) / kSize;  // meters on the plane
      const dvec3 p((static_cast<double>(i % kSize) + 0.5 - kSize / 2.0) * perPixel,
                    (kSize / 2.0 - static_cast<double>(i / kSize) - 0.5) * perPixel, 0);
      const dvec3 expected = planeRadiance(material, light, p);
      for (int c = 0; c < 3; ++c) {
        const double level = srgbLevel(expected[c]);
        brightest = std::max(brightest, level);
        worst.linear =
            std::max(worst.linear, std::abs(srgbLevel(imageOf(frame, Aov::Color).values[4 * i + size_t(c)]) - level));
        worst.display = std::max(worst.display, std::abs(frame.display[4 * i + size_t(c)] - level));
      }
    }
    EXPECT_GT(brightest, 100);
    return worst;
  }
};

TEST_F(PlaneTest, PunctualLightsFollowTheSpecificationToHalfALevel) {
  double linear = 0, display = 0;
  for (const PlaneLight& light : planeLights())
    for (auto materials :
         {std::span<const PlaneMaterial>(kPlaneMaterials), std::span<const PlaneMaterial>(kTintedMaterials)})
      for (const PlaneMaterial& material : materials) {
        SCOPED_TRACE(std::string(light.name) + " on " + material.name);
        const Levels worst = compare(material, light.light, "exact");
        EXPECT_LT(worst.linear, kPrecision);
        EXPECT_LE(worst.display, 0.5 + kPrecision);
        linear = std::max(linear, worst.linear), display = std::max(display, worst.display);
      }
  fmt::print("layout exact: {:.3f} levels before rounding to 8 bits, {:.3f} after\n", linear, display);
}

TEST_F(PlaneTest, SoDoesTheDefaultLayoutToALevel) {
  double linear = 0;
  for (const PlaneLight& light : planeLights())
    for (auto materials :
         {std::span<const PlaneMaterial>(kPlaneMaterials), std::span<const PlaneMaterial>(kTintedMaterials)})
      for (const PlaneMaterial& material : materials) {
        SCOPED_TRACE(std::string(light.name) + " on " + material.name);
        const Levels worst = compare(material, light.light, Settings().layout->name);
        EXPECT_LT(worst.linear, 0.75);
        EXPECT_LE(worst.display, 1.25);
        linear = std::max(linear, worst.linear);
      }
  fmt::print("layout {}: {:.3f} levels before rounding to 8 bits\n", Settings().layout->name, linear);
}

TEST_F(PlaneTest, SoDoesThinIfItRepresentsTheMaterial) {
  double linear = 0;
  for (const PlaneLight& light : planeLights())
    for (const PlaneMaterial& material : kPlaneMaterials) {
      SCOPED_TRACE(std::string(light.name) + " on " + material.name);
      const Levels worst = compare(material, light.light, "thin");
      // 0 lies between two 12-bit codes, so a normal along an axis is off by 2.4e-4. At the edge of the narrowest
      // highlight this is one level.
      EXPECT_LT(worst.linear, material.roughness < 0.25f ? 1.25 : 0.5);
      linear = std::max(linear, worst.linear);
    }
  fmt::print("layout thin: {:.3f} levels before rounding to 8 bits\n", linear);
}

// --- furnace and unlit ----------------------------------------------------------------------------------------------

// White spheres from smooth to rough: Lambertian, dielectric and metallic.
scene::Scene whiteSpheres() {
  scene::SceneBuilder builder("furnace");
  builder.scene.meshes.push_back(sphereMesh(0.45f));
  for (uint32_t kind = 0; kind < 3; ++kind)
    for (uint32_t i = 0; i < 3; ++i) {
      scene::Material material =
          scene::plainMaterial("white", vec3(1), kind == 2 ? 1.0f : 0.0f, 0.1f + 0.45f * static_cast<float>(i));
      material.data.specular = kind == 0 ? 0.0f : 1.0f;
      builder.scene.materials.push_back(std::move(material));
      glm::mat4 local(1);
      local[3] = glm::vec4(static_cast<float>(i) - 1, static_cast<float>(kind) - 1, 0, 1);
      builder.addInstance("sphere", builder.kRoot, 0, kind * 3 + i, local);
    }
  return std::move(builder.scene);
}

class FurnaceTest : public RenderTest {
 protected:
  // The largest deviation from radiance 1 on the spheres.
  static double deviation(const scene::Environment& environment) {
    const scene::Scene scene = whiteSpheres();
    Settings settings = settingsOf(120, 120, {Aov::Color});
    settings.layout = &findLayout("exact");
    const output::FrameOutput frame = renderOne(device(), scene, frontCamera(1.6f), settings, &environment);
    const auto& color = imageOf(frame, Aov::Color).values;
    double worst = 0;
    size_t covered = 0;
    for (size_t i = 0; i < color.size(); i += 4) {
      if (color[i + 3] == 0) continue;
      ++covered;
      for (size_t c = 0; c < 3; ++c) worst = std::max(worst, std::abs(color[i + c] - 1.0));
    }
    EXPECT_GT(covered, 5000u);
    return worst;
  }
};

// Energy is conserved by construction, including diffuse and multiple scattering, so only the half float rounds.
TEST_F(FurnaceTest, WhiteReflectsAllOfAConstantEnvironment) {
  EXPECT_LT(deviation(constantEnvironment()), 1e-3);
}

TEST_F(FurnaceTest, AConstantImageIsAConstantEnvironment) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / fmt::format("latelight-furnace-{}.hdr", getpid());
  {
    std::ofstream out(file, std::ios::binary);
    out << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n";
    for (int i = 0; i < 16 * 32; ++i) out.write("\x80\x80\x80\x81", 4);  // RGBE of 1
  }
  const scene::Environment environment = scene::loadEnvironment(file);
  std::filesystem::remove(file);
  EXPECT_LT(deviation(environment), 2e-3);  // the maps are half floats as well
}

TEST_F(FurnaceTest, UnlitSurfacesShowTheirBaseColorExactly) {
  for (const char* layout : {"exact", "compact", "thin", "optimized"}) {
    SCOPED_TRACE(layout);
    scene::SceneBuilder builder("unlit");
    builder.scene.meshes.push_back(squareMesh());
    const glm::ivec3 codes[] = {{255, 128, 1}, {0, 77, 200}, {13, 254, 90}};
    for (int i = 0; i < 3; ++i) {
      scene::Material material = scene::plainMaterial("unlit", decoded(codes[i].x, codes[i].y, codes[i].z), 0.5f, 0.3f);
      material.data.flags |= shared::kMaterialUnlit;
      material.data.emissive = vec3(1);  // must be ignored: KHR_materials_unlit outputs only the base color
      builder.scene.materials.push_back(std::move(material));
      glm::mat4 local(1);
      local[1][1] = 1.0f / 3;
      local[3].y = static_cast<float>(1 - i) * 2 / 3;
      builder.addInstance("row", builder.kRoot, 0, uint32_t(i), local);
    }
    scene::Light light;
    light.position = {0, -2, 0};
    light.intensity = 100;
    builder.scene.lights.push_back(light);
    Settings settings = settingsOf(9, 9);
    settings.layout = &findLayout(layout);
    settings.tonemap = Tonemap::None;
    settings.display = true;
    const scene::Environment environment = constantEnvironment();
    const output::FrameOutput frame = renderOne(device(), builder.scene, frontCamera(), settings, &environment);
    for (size_t i = 0; i < 81; ++i)
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(frame.display[4 * i + size_t(c)], codes[i / 27][c]) << "pixel " << i << ", channel " << c;
  }
}

}  // namespace
}  // namespace latelight::render::test
