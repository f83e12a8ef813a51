#include "layers/scenes.h"

#include "shared/light.h"

namespace latelight::render::test {

namespace {

scene::Material plain(const char* name, vec3 color, float metallic, float roughness) {
  return scene::plainMaterial(name, color, metallic, roughness);
}

void addLights(scene::Scene& scene) {
  const auto light = [&](uint32_t type, vec3 position, float intensity) -> scene::Light& {
    scene::Light& l = scene.lights.emplace_back();
    l.type = type;
    l.position = position;
    l.intensity = intensity;
    l.direction = glm::normalize(vec3(0.3f, 1, -0.4f));
    return l;
  };
  light(shared::kLightDirectional, vec3(0), 1.5f);
  light(shared::kLightPoint, {2, -3, 2}, 20);
  light(shared::kLightPoint, {-3, 1.5f, 1}, 15).range = 6.0f;  // behind the balls
  scene::Light& spot = light(shared::kLightSpot, {-2, -4, 1}, 40);
  spot.direction = glm::normalize(vec3(0.4f, 1, -0.2f));
  spot.outerCone = 0.5f;
  spot.range = 9.0f;
}

}  // namespace

scene::Material layeredMaterial(LayeredKind kind) {
  scene::Material m = plain("layered", {0.6f, 0.3f, 0.1f}, 0, 0.5f);
  shared::MaterialLayers& l = m.data.layers;
  const bool all = kind == LayeredKind::All;
  if (kind == LayeredKind::Clearcoat || kind == LayeredKind::Masked || all)
    l.clearcoat = 0.8f, l.clearcoatRoughness = 0.1f;
  if (kind == LayeredKind::Sheen || all) l.sheenColor = {0.2f, 0.4f, 0.7f}, l.sheenRoughness = 0.4f;
  if (kind == LayeredKind::Anisotropy || all) l.anisotropy = 0.7f, l.anisotropyRotation = 0.6f, m.data.metallic = 0.8f;
  if (kind == LayeredKind::Iridescence || all) l.iridescence = 0.9f, l.iridescenceThickest = 350;
  if (kind == LayeredKind::DiffuseTransmission || all)
    l.diffuseTransmission = 0.6f, l.diffuseTransmissionColor = {1, 0.8f, 0.2f};
  if (all) m.data.emissive = {0.05f, 0, 0.1f};
  if (kind == LayeredKind::Masked) {
    m.data.flags |= shared::kMaterialMasked | shared::kMaterialDoubleSided;
    setTexture(m, shared::kTextureBaseColor, 0, kNearest);
  }
  return m;
}

scene::Scene layeredRoom() {
  scene::SceneBuilder builder("layers");
  scene::Scene& scene = builder.scene;
  scene.meshes = {squareMesh(), sphereMesh(0.8f)};
  std::vector<glm::u8vec4> holes;
  for (int i = 0; i < 16 * 16; ++i) holes.emplace_back(255, 255, 255, (i / 16 / 4 + i % 16 / 4) % 2 ? 255 : 0);
  scene.textures.push_back(textureOf(16, 16, true, holes));
  const auto place = [&](scene::Material material, uint32_t mesh, vec3 at, vec3 size) {
    scene.materials.push_back(std::move(material));
    builder.addInstance("thing", builder.kRoot, mesh, static_cast<uint32_t>(scene.materials.size()) - 1,
                        glm::scale(glm::translate(glm::mat4(1), at), size));
  };
  place(plain("wall", {0.7f, 0.7f, 0.6f}, 0, 0.8f), 0, {0, 0, -1.5f}, {5, 3, 1});
  place(plain("ball", {0.6f, 0.3f, 0.1f}, 0, 0.5f), 1, {-2.7f, 1, 0}, vec3(1));
  for (uint32_t i = 0; i < static_cast<uint32_t>(LayeredKind::Count); ++i) {
    const uint32_t at = i + 1;
    place(layeredMaterial(static_cast<LayeredKind>(i)), 1,
          {-2.7f + 1.8f * static_cast<float>(at % 4), at < 4 ? 1.0f : -1.0f, 0}, vec3(1));
  }
  addLights(scene);
  return std::move(scene);
}

scene::Camera roomCamera() {
  return frontPerspective(0.6f, 7);
}

scene::Material clearPlate(float thickness) {
  scene::Material m = plain("plate", vec3(1), 0, 0);
  m.data.specular = 0;  // no reflection at any angle
  m.data.layers.transmission = 1;
  m.data.layers.thickness = thickness;
  return m;
}

scene::Scene stripesBehind(const scene::Material& plate, float stripe, float away) {
  scene::SceneBuilder builder("stripes");
  scene::Scene& scene = builder.scene;
  scene.meshes = {squareMesh()};
  scene.materials = {plain("dark", vec3(0), 0, 1), plain("bright", vec3(0), 0, 1), plate};
  scene.materials[0].data.specular = scene.materials[1].data.specular = 0;
  scene.materials[1].data.emissive = vec3(1);
  constexpr int kStripes = 64;
  for (int i = -kStripes / 2; i < kStripes / 2; ++i) {
    const vec3 at((static_cast<float>(i) + 0.5f) * stripe, 0, -away);
    builder.addInstance("stripe", builder.kRoot, 0, i % 2 == 0 ? 1 : 0,
                        glm::scale(glm::translate(glm::mat4(1), at), vec3(stripe / 2, 20, 1)));
  }
  builder.addInstance("plate", builder.kRoot, 0, 2, glm::mat4(1));
  return std::move(scene);
}

}  // namespace latelight::render::test
