// builtin:boxes, whose images can be computed by hand; see scene/builtin/builtin.h.
#include "scene/builtin/builtin.h"
#include "scene/builtin/make.h"
#include "scene/scene_builder.h"
#include "shared/light.h"

namespace latelight::scene {
namespace {

constexpr BoxesBox kBoxes[] = {
    {.name = "floor", .min = {-12, -1, -6}, .max = {12, 0, 9}, .baseColor = vec3(0.5f)},
    {.name = "wall", .min = {-12, -0.5f, -6}, .max = {12, 9, -5}, .baseColor = {0.25f, 0.375f, 0.5f}},
    {.name = "matte", .min = {-4, 0.25f, -2}, .max = {-2.5f, 1.75f, -0.5f}, .baseColor = {0.75f, 0.125f, 0.0625f}},
    {.name = "plastic",
     .min = {-2, 0.25f, -1},
     .max = {-0.5f, 2.25f, 0.5f},
     .baseColor = {0.0625f, 0.5f, 0.25f},
     .roughness = 0.5f,
     .specular = 1},
    {.name = "metal",
     .min = {0.25f, 0.25f, -1},
     .max = {1.5f, 1.5f, 0.25f},
     .baseColor = {1, 0.75f, 0.25f},
     .metallic = 1,
     .roughness = 0.5f,
     .specular = 1},
    {.name = "glowing",
     .min = {2, 0.25f, -2},
     .max = {3, 2.75f, -1},
     .baseColor = vec3(0.25f),
     .emissive = {0.5f, 0.25f, 0.125f}},
    {.name = "unlit",
     .min = {3.25f, 0.25f, -0.5f},
     .max = {4, 1, 0.25f},
     .baseColor = {0.25f, 0.5f, 0.75f},
     .unlit = true},
    {.name = "mirrored",
     .min = {-1.25f, 2.75f, -3},
     .max = {1.25f, 3.25f, -2.5f},
     .baseColor = {0.5f, 0.25f, 0.75f},
     .mirrored = true},
};

}  // namespace

std::span<const BoxesBox> boxesBoxes() {
  return kBoxes;
}

namespace builtin {
namespace {

// A cube from -1/2 to 1/2 with separate vertices per face; uv (0, 0) is each face's top left corner as seen from
// outside.
Mesh unitCube() {
  Mesh mesh;
  mesh.name = "cube";
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    vec3 normal(0), tangent(0);
    normal[axis] = face % 2 ? -1.0f : 1.0f;
    tangent[axis == 0 ? 2 : 0] = axis == 0 ? -normal.x : axis == 2 ? normal.z : 1.0f;
    const vec3 bitangent = glm::cross(normal, tangent);
    const uint32_t first = static_cast<uint32_t>(mesh.positions.size());
    for (int corner = 0; corner < 4; ++corner) {
      const float u = corner == 1 || corner == 2 ? 1.0f : 0.0f, v = corner >= 2 ? 1.0f : 0.0f;
      mesh.positions.push_back(0.5f * normal + (u - 0.5f) * tangent + (v - 0.5f) * bitangent);
      mesh.attributes.push_back({normal, vec4(tangent, 1), vec2(u, 1 - v)});
    }
    for (uint32_t i : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + i);
  }
  findBounds(mesh);
  return mesh;
}

Material boxMaterial(const BoxesBox& box) {
  Material material = plainMaterial(std::string(box.name), box.baseColor, box.metallic, box.roughness);
  material.data.specular = box.specular;
  material.data.emissive = box.emissive;
  if (box.unlit) material.data.flags |= shared::kMaterialUnlit;
  return material;
}

mat4 boxTransform(const BoxesBox& box) {
  const vec3 size = (box.max - box.min) * vec3(box.mirrored ? -1.0f : 1.0f, 1, 1);
  mat4 local(1);
  for (int axis = 0; axis < 3; ++axis) local[axis][axis] = size[axis];
  local[3] = vec4((box.min + box.max) * 0.5f, 1);
  return local;
}

}  // namespace

Scene makeBoxes() {
  SceneBuilder builder("boxes");
  builder.scene.meshes.push_back(unitCube());
  for (const BoxesBox& box : boxesBoxes()) {
    builder.scene.materials.push_back(boxMaterial(box));
    builder.addInstance(std::string(box.name), SceneBuilder::kRoot, 0,
                        static_cast<uint32_t>(builder.scene.materials.size() - 1), boxTransform(box));
  }
  Light sun;
  sun.name = "sun";
  sun.type = shared::kLightDirectional;
  sun.intensity = kBoxesIlluminance;
  sun.direction = vec3(toWorldFromGltf() * vec4(kBoxesLightDirection, 0));
  builder.scene.lights.push_back(sun);
  builder.addCamera("main", kBoxesEye, kBoxesEye - vec3(0, 0, 1), kBoxesVerticalFov);
  return std::move(builder.scene);
}

}  // namespace builtin
}  // namespace latelight::scene
