// The built-in scenes, named "builtin:NAME[,key=value...]". All are generated in glTF's frame (Y up), and are
// byte-identical on every machine and for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

// A parameter in a built-in scene's name: an integer, optionally with the suffix k (thousands) or M (millions), such as
// "500k" or "1.5M".
struct BuiltinParameter {
  std::string_view key;
  std::string_view description;
  uint64_t least, most, normal;
};

struct Builtin {
  std::string_view name;
  std::string_view description;
  std::span<const BuiltinParameter> parameters;
  // `values`: one per parameter, in order and in range. `textureSlots`: LoadOptions::textureSlots.
  Scene (*make)(std::span<const uint64_t> values, uint32_t textureSlots);
};
std::span<const Builtin> builtins();
// `name`: what follows "builtin:".
Scene makeBuiltin(const std::string& name, uint32_t textureSlots = ~0u);

// Parses "300k", "1.5M" or "42": digits, at most one decimal point, and an optional suffix. Returns nullopt if the
// result is not an integer in range.
std::optional<uint64_t> parseCount(std::string_view text);

// --- builtin:triangles ----------------------------------------------------------------------------------------------

inline constexpr uint32_t kTrianglesPicture = 2048;  // side of the square image that defines triangle sizes, in pixels

// --- builtin:boxes --------------------------------------------------------------------------------------------------
//
// A scene whose images can be computed by hand, in glTF's frame and in meters. It has only axis-aligned boxes over a
// floor, in front of a wall, and one directional light. The figures below exclude shadows.
//
// The camera looks exactly along -Z, so every face towards it has one planar depth: kBoxesEye.z - max.z. With V = 1 /
// tan(fov / 2) = 2, an image w pixels wide and h pixels high shows the point p at the pixel coordinate (y down)
//   x = w / 2 + h * (p.x - eye.x) / depth,   y = h / 2 - h * (p.y - eye.y) / depth,   depth = eye.z - p.z.
//
// The light travels along (-2, -6, -3) / 7 with 7 pi / 6 lux, so a matte face (metallic 0, specular 0) of base color c
// has radiance c * E / pi * cos: 1 c if it faces up, c / 2 if it faces the camera (+Z), c / 3 if it faces +X, and 0
// otherwise. Emission is added; unlit boxes show their base color.
struct BoxesBox {
  std::string_view name;  // the node "/boxes/<name>"; its id is hash32 of that path
  vec3 min, max;
  vec3 baseColor;
  float metallic = 0, roughness = 1;
  float specular = 0;  // KHR_materials_specular's factor: 0 is Lambertian
  vec3 emissive{0};
  bool unlit = false;
  bool mirrored = false;  // by a scale of -1 along X: the same box, but its transform has a negative determinant
};
inline constexpr vec3 kBoxesEye{0, 1.5f, 8};
inline constexpr float kBoxesVerticalFov = 0.927295218f;                      // 2 atan(1/2)
inline constexpr vec3 kBoxesLightDirection{-2.0f / 7, -6.0f / 7, -3.0f / 7};  // from the light
inline constexpr float kBoxesIlluminance = 3.66519143f;                       // 7 pi / 6 lux
std::span<const BoxesBox> boxesBoxes();  // including the floor and the wall, which are thick boxes

// --- builtin:spheres ------------------------------------------------------------------------------------------------
//
// Spheres of one base color in the plane z = 0: metalness increases along columns from 0 to 1 towards +X, roughness
// along rows from 0 to 1 upwards. The scene has no lights; the environment lights it. Normals are analytic.
inline constexpr uint32_t kSpheresColumns = 9, kSpheresRows = 5;
inline constexpr float kSpheresRadius = 0.44f, kSpheresPitch = 1.0f;
inline constexpr vec3 kSpheresBaseColor{0.955f, 0.62f, 0.33f};
vec3 spheresCenter(uint32_t column, uint32_t row);

// --- builtin:hall (builtin/hall) ------------------------------------------------------------------------------------
//
// A colonnaded hall with a coffered barrel vault, aisles and a gallery, lit by warm point lights: see
// scene/builtin/hall/hall.h. Its parameters:
//   triangles  total count over all instances; the result is within kHallTriangleTolerance of it
//   lights     exact count; the exposure of the image stays the same
//   seed       varies the positions of small lights, the stones and marbles, and the arrangement of exhibits
//   glass      1: glass cases around the exhibits, and every other exhibit of colored glass; both alpha blended
inline constexpr double kHallTriangleTolerance = 0.03;

}  // namespace latelight::scene
