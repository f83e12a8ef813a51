#include "combinations/scene.h"

#include <glm/gtc/matrix_transform.hpp>

#include "render/support.h"
#include "shared/light.h"

namespace latelight::render::test {

namespace {

using glm::mat4;
using glm::vec3;

struct Maker {
  scene::SceneBuilder builder{"every kind"};
  scene::Scene& scene = builder.scene;

  shared::Material& material(vec3 color, float metallic, float roughness) {
    scene.materials.push_back(scene::plainMaterial("m", color, metallic, roughness));
    return scene.materials.back().data;
  }
  // Applies to the material that was added last.
  void place(uint32_t mesh, vec3 at, vec3 size, vec3 turn = vec3(0)) {
    mat4 local = glm::translate(mat4(1), at);
    for (int axis = 0; axis < 3; ++axis) {
      vec3 about(0);
      about[axis] = 1;
      local = glm::rotate(local, turn[axis], about);
    }
    const auto last = static_cast<uint32_t>(scene.materials.size()) - 1;
    builder.addInstance("thing", builder.kRoot, mesh, last, glm::scale(local, size));
  }
  scene::Light& light(uint32_t type, vec3 position, vec3 target, vec3 color, float intensity) {
    scene::Light& light = scene.lights.emplace_back();
    light.type = type;
    light.position = position;
    light.direction = glm::normalize(target - position);
    light.color = color;
    light.intensity = intensity;
    return light;
  }
};

// In glTF's frame: a floor and a wall, and in front of them one object of each kind.
void addThings(Maker& m) {
  constexpr uint32_t kSquare = 0, kSphere = 1;
  m.scene.meshes = {squareMesh(), sphereMesh(0.5f)};
  m.scene.textures.push_back(
      textureOf(2, 2, false, {{90, 128, 230, 255}, {160, 100, 230, 255}, {128, 160, 240, 255}, {128, 128, 255, 255}}));
  m.scene.textures.push_back(
      textureOf(2, 2, true, {{200, 90, 30, 255}, {30, 90, 200, 0}, {90, 200, 30, 0}, {200, 30, 200, 255}}));
  m.scene.textures.push_back(
      textureOf(2, 2, false, {{255, 0, 0, 255}, {90, 0, 0, 255}, {160, 0, 0, 255}, {30, 0, 0, 255}}));
  const auto texture = [&](uint32_t slot, int index) { setTexture(m.scene.materials.back(), slot, index, kNearest); };
  m.material({0.8f, 0.7f, 0.6f}, 0, 0.6f);
  m.place(kSquare, {0, 0, -2}, {4, 3, 1});
  m.material({0.5f, 0.6f, 0.8f}, 0.2f, 0.5f);
  texture(shared::kTextureNormal, 0);
  texture(shared::kTextureOcclusion, 2);
  m.place(kSquare, {0, -1.5f, 0}, vec3(4), {-1.5707963f, 0, 0});
  m.place(kSphere, {1.7f, 0.7f, -1}, {-1, 1.2f, 1});  // mirrored
  m.material({0.9f, 0.8f, 0.3f}, 1, 0.35f);
  m.place(kSphere, {-1.6f, -0.9f, -0.6f}, vec3(1.2f));
  m.material({0.2f, 0.6f, 0.3f}, 0, 1).flags |= shared::kMaterialUnlit;
  m.place(kSphere, {1.5f, -0.9f, -1}, vec3(1));
  m.material({0.1f, 0.1f, 0.1f}, 0, 0.4f).emissive = {0.5f, 0.2f, 0.05f};
  m.place(kSphere, {0, -1, 0.2f}, vec3(1));
  shared::Material& tinted = m.material({0.6f, 0.2f, 0.5f}, 0, 0.2f);
  tinted.specularColor = {0.9f, 0.3f, 2.0f}, tinted.specular = 0.7f;
  m.place(kSphere, {0.2f, 0.9f, -0.8f}, vec3(0.9f));
  m.material({0.7f, 0.2f, 0.2f}, 0, 0.5f).flags |= shared::kMaterialDoubleSided;
  m.place(kSquare, {-0.6f, 0.1f, -1}, vec3(0.5f), {0, 3.5f, 0});
  shared::Material& masked = m.material({1, 1, 1}, 0, 0.7f);
  masked.flags |= shared::kMaterialMasked | shared::kMaterialDoubleSided;
  masked.alphaCutoff = 0.5f;
  texture(shared::kTextureBaseColor, 1);
  m.place(kSquare, {-1.7f, 0.9f, -1}, vec3(0.6f));
}

// In world space, in which the wall is the plane y = 2.
void addLights(Maker& m) {
  m.light(shared::kLightDirectional, {-3, -10, 8}, {0, 0, 0}, {1, 0.95f, 0.9f}, 0.6f);
  for (int i = 0; i < 11; ++i) {  // more lights than a subgroup of the CPU device has lanes
    const auto f = static_cast<float>(i);
    m.light(shared::kLightPoint, {-2.5f + 0.5f * f, 0.2f * f - 1, f < 5 ? 1 : -1}, {0, 9, 0},
            {1, 0.2f + 0.07f * f, 0.5f}, 0.8f)
        .range = 1.2f + 0.2f * f;
  }
  // behind the camera, with unlimited range
  m.light(shared::kLightPoint, {0.5f, -5, 2}, {0, 0, 0}, {0.4f, 0.6f, 1}, 6);
  scene::Light& wide = m.light(shared::kLightSpot, {-1, -2, 2}, {-1, 0.5f, -1}, {0.6f, 0.9f, 1}, 12);
  wide.range = 6.0f, wide.innerCone = 0.3f, wide.outerCone = 0.8f;
  scene::Light& narrow = m.light(shared::kLightSpot, {1.5f, -3.8f, -0.5f}, {0.5f, 2, 0.5f}, {1, 1, 0.4f}, 40);
  narrow.range = 9.0f, narrow.innerCone = 0.02f, narrow.outerCone = 0.15f;
}

}  // namespace

std::vector<std::string> layoutNames() {
  std::vector<std::string> names;
  for (const Layout& layout : layouts()) names.push_back(layout.name);
  return names;
}

size_t turnOf(const std::string& layout) {
  return static_cast<size_t>(&findLayout(layout) - layouts().data());
}

scene::Scene everyKind() {
  Maker m;
  addThings(m);
  addLights(m);
  m.scene.cameras.push_back(frontPerspective(1.0f, 4));
  return std::move(m.scene);
}

}  // namespace latelight::render::test
