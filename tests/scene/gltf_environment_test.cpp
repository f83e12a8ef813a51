// EXT_lights_image_based: cube maps with one color per face, and spherical harmonics, compared with their closed forms.
#include <gmock/gmock.h>

#include <cmath>

#include "environment_support.h"
#include "gltf_builder.h"

namespace latelight::scene::test {
namespace {

using testing::HasSubstr;
using Color = std::array<uint8_t, 4>;  // as in an image

// A square TGA image of one color.
std::vector<uint8_t> squareOf(const Color& c, uint8_t side) {
  std::vector<uint8_t> tga = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, side, 0, side, 0, 32, 0x28};
  for (int i = 0; i < side * side; ++i) tga.insert(tga.end(), {c[2], c[1], c[0], c[3]});
  return tga;
}

constexpr Color kFaces[6] = {{255, 0, 0, 255},   {0, 255, 0, 255}, {0, 0, 255, 255}, {255, 255, 0, 255},
                             {0, 255, 255, 255}, {255, 0, 255, 51}};  // the last one: five times as bright
const vec3 kRadiance[6] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {0, 1, 1}, {5, 0, 5}};
const vec3 kAxes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};  // in glTF's frame

GltfBuilder litFile(json light) {
  GltfBuilder b = triangleFile();
  json faces = json::array();
  for (const Color& face : kFaces) faces.push_back(b.add("images", {{"bufferView", b.view(squareOf(face, 8))}}));
  json harmonics = json::array();
  for (int i = 0; i < 9; ++i) harmonics.push_back({i == 3 ? 2.0 : 0.0, i == 0 ? 1.0 : 0.0, i == 6 ? 1.0 : 0.0});
  light["specularImages"] = {faces};
  light["irradianceCoefficients"] = harmonics;
  light["specularImageSize"] = 8;
  b.root["extensions"]["EXT_lights_image_based"]["lights"] = {light};
  b.root["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
  b.use("EXT_lights_image_based");
  return b;
}

vec3 inWorld(const vec3& gltf) {
  return vec3(toWorldFromGltf() * vec4(gltf, 0));
}
vec3 mirrored(const Scene& scene, const vec3& gltf) {
  return lookUp(scene.environment->specular[0], inWorld(gltf));
}
vec3 diffuse(const Scene& scene, const vec3& gltf) {
  return lookUp(scene.environment->diffuse, inWorld(gltf));
}

// Half floats have 11 significant bits.
void expectClose(const vec3& a, const vec3& b) {
  expectNear(a, b, 1e-3f * (glm::length(b) + 1));
}

TEST(ImageBasedLight, ShinesWithTheColorsOfItsFaces) {
  const Scene scene = litFile({{"intensity", 2}}).load();
  ASSERT_TRUE(scene.environment);
  for (size_t i = 0; i < 6; ++i) expectClose(mirrored(scene, kAxes[i]), 2.0f * kRadiance[i]);
}

// The faces are oriented as in OpenGL: rows of a side face run downward, and columns of the face +X towards -Z.
TEST(ImageBasedLight, ItsFacesLieAsOpenGlsDo) {
  GltfBuilder b = litFile({});
  // The upper left texels of +X are white.
  std::vector<uint8_t> corner = squareOf({0, 0, 0, 255}, 8);
  for (size_t y = 0; y < 4; ++y)
    for (size_t x = 0; x < 4; ++x)
      for (size_t c = 0; c < 4; ++c) corner[18 + 4 * (8 * y + x) + c] = 255;
  b.root["images"].push_back({{"bufferView", b.view(corner)}});
  b.root["extensions"]["EXT_lights_image_based"]["lights"][0]["specularImages"][0][0] = 6;
  const Scene scene = b.load();
  expectClose(mirrored(scene, glm::normalize(vec3(1, .5, .5))), vec3(1));
  expectClose(mirrored(scene, glm::normalize(vec3(1, .5, -.5))), vec3(0));
  expectClose(mirrored(scene, glm::normalize(vec3(1, -.5, .5))), vec3(0));
}

// E(n) = the sum of the coefficients times the harmonics; the map stores E / pi.
TEST(ImageBasedLight, ItsDiffuseLightIsThatOfItsHarmonics) {
  const Scene scene = litFile({{"intensity", 3}}).load();
  const auto expected = [](const vec3& n) {
    return vec3(std::max(0.0, 2 * .488603 * n.x), .282095, std::max(0.0, .315392 * (3 * n.z * n.z - 1))) *
           float(3 / M_PI);
  };
  for (const vec3& axis : kAxes) expectClose(diffuse(scene, axis), expected(axis));
  const vec3 between = glm::normalize(vec3(.3, -.5, .8));
  EXPECT_LT(glm::length(diffuse(scene, between) - expected(between)), 5e-3f);
}

// A quarter turn about Y rotates +Z to +X.
TEST(ImageBasedLight, TurnsWithItsRotation) {
  const double half = std::sqrt(.5);
  const Scene scene = litFile({{"rotation", {0, half, 0, half}}}).load();
  expectClose(mirrored(scene, {1, 0, 0}), kRadiance[4]);
  expectClose(mirrored(scene, {0, 0, -1}), kRadiance[0]);
  expectClose(mirrored(scene, {0, 1, 0}), kRadiance[2]);
  expectClose(diffuse(scene, {0, 0, -1}), vec3(2 * .488603 / M_PI, .282095 / M_PI, 0));
}

// The images themselves have a size, so a wrong specularImageSize changes nothing.
TEST(ImageBasedLight, TheSizeOfItsFacesIsThatOfTheImages) {
  GltfBuilder b = litFile({});
  for (const int size : {8, 256}) {
    b.root["extensions"]["EXT_lights_image_based"]["lights"][0]["specularImageSize"] = size;
    testing::internal::CaptureStderr();
    const Scene scene = b.load();
    const std::string warnings = testing::internal::GetCapturedStderr();
    for (size_t i = 0; i < 6; ++i) expectClose(mirrored(scene, kAxes[i]), kRadiance[i]);
    if (size == 8)
      EXPECT_EQ(warnings, "");
    else
      EXPECT_THAT(warnings, HasSubstr("specularImageSize is 256, but its faces have 8x8 pixels"));
  }
}

TEST(ImageBasedLight, RefusesWhatIsNoCube) {
  GltfBuilder b = litFile({});
  b.root["images"][3]["bufferView"] = b.view(squareOf({0, 0, 0, 255}, 4));
  EXPECT_THAT(errorOf(b), HasSubstr("squares of the same size"));
  b.root["images"][3] = {{"uri", "nowhere.png"}};
  EXPECT_THAT(errorOf(b), HasSubstr("nowhere.png"));
  GltfBuilder none = litFile({});
  none.root["scenes"][0].erase("extensions");
  EXPECT_FALSE(none.load().environment);
}

}  // namespace
}  // namespace latelight::scene::test
