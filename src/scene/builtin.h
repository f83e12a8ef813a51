// The built-in scenes: "builtin:NAME[,key=value...]". All are made in glTF's frame (Y up), and are byte-identical on
// every machine and for any number of threads.
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

// A parameter in a built-in scene's name: a whole number, with k or M for thousands or millions ("500k", "1.5M").
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

// "300k", "1.5M", "42": digits, at most one point, and a suffix. Nothing if it's not a whole number that fits.
std::optional<uint64_t> parseCount(std::string_view text);

// --- builtin:triangles ----------------------------------------------------------------------------------------------

inline constexpr uint32_t kTrianglesPicture = 2048;  // pixels, of the picture for which their size is given

// --- builtin:boxes --------------------------------------------------------------------------------------------------
//
// A scene whose pictures can be computed by hand. Frame: glTF's, metres. Only axis-aligned boxes over a floor, in front
// of a wall, and one directional light; the figures given here are without shadows.
//
// The camera looks exactly along -Z, so every face towards it has one planar depth: kBoxesEye.z - max.z. With
// V = 1 / tan(fov / 2) = 2, a picture h pixels high and w wide sees the point p at the pixel coordinate (y down)
//   x = w / 2 + h * (p.x - eye.x) / depth,   y = h / 2 - h * (p.y - eye.y) / depth,   depth = eye.z - p.z.
//
// The light travels along (-2, -6, -3) / 7 with 7 pi / 6 lux, so a matte face (metallic 0, specular 0) of base colour c
// has radiance c * E / pi * cos: 1 c where it faces up, c / 2 where it faces the camera (+Z), c / 3 where it faces +X,
// and 0 elsewhere. Emission is added; unlit boxes show their base colour.
struct BoxesBox {
  std::string_view name;  // the node "/boxes/<name>"; its id is hash32 of that path
  vec3 min, max;
  vec3 baseColor;
  float metallic = 0, roughness = 1;
  float specular = 0;  // KHR_materials_specular's weight: 0 is Lambertian
  vec3 emissive{0};
  bool unlit = false;
  bool mirrored = false;  // by a scale of -1 along X: same box, but its transform has a negative determinant
};
inline constexpr vec3 kBoxesEye{0, 1.5f, 8};
inline constexpr float kBoxesVerticalFov = 0.927295218f;                      // 2 atan(1/2)
inline constexpr vec3 kBoxesLightDirection{-2.0f / 7, -6.0f / 7, -3.0f / 7};  // from the light
inline constexpr float kBoxesIlluminance = 3.66519143f;                       // 7 pi / 6 lux
std::span<const BoxesBox> boxesBoxes();  // the floor and the wall are thick boxes too

// --- builtin:spheres ------------------------------------------------------------------------------------------------
//
// Spheres of one base colour in the plane z = 0: metalness grows along columns from 0 to 1 towards +X, roughness along
// rows from 0 to 1 upwards. No light of its own: the environment lights it. Normals are analytic.
inline constexpr uint32_t kSpheresColumns = 9, kSpheresRows = 5;
inline constexpr float kSpheresRadius = 0.44f, kSpheresPitch = 1.0f;
inline constexpr vec3 kSpheresBaseColor{0.955f, 0.62f, 0.33f};
vec3 spheresCentre(uint32_t column, uint32_t row);

// --- builtin:hall: builtin/hall
// ---------------------------------------------------------------------------------------
//
// A colonnaded hall with a coffered barrel vault, aisles and a gallery, lit by warm point lights: see
// scene/builtin/hall/hall.h. Its parameters:
//   triangles  of all instances together; what is built is within kHallTriangleTolerance of it
//   lights     exactly so many; the exposure of the picture stays the same
//   seed       where the small lights hang, how the stones and marbles vary, which objects stand where
//   glass      1: glass cases around the exhibits, and every other exhibit of coloured glass; both alpha-blended
inline constexpr double kHallTriangleTolerance = 0.03;

}  // namespace latelight::scene
