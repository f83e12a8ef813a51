#include "edits/workshop.h"
#include "shared/light.h"

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>

namespace latelight::render::test {

namespace {

using glm::vec3;
using scene::plainMaterial;
using scene::SceneBuilder;

enum MeshOf : uint32_t { kSphere, kSquare, kColoredSquare };

// Textures with a checkerboard with holes, with roughness, and with glowing dots.
std::vector<scene::Texture> textures() {
  std::vector<glm::u8vec4> holes, rough, dots;
  for (uint32_t i = 0; i < 64; ++i) {
    const bool odd = ((i + i / 8) & 1u) != 0;
    holes.emplace_back(odd ? 220 : 90, 140, odd ? 60 : 200, odd ? 255 : 40);
    rough.emplace_back(0, 40 + 3 * i, odd ? 255 : 0, 255);
    dots.emplace_back(odd ? 255 : 0, odd ? 120 : 0, 0, 255);
  }
  std::vector<scene::Texture> all;
  all.push_back(textureOf(8, 8, true, holes));
  all.push_back(textureOf(8, 8, false, rough));
  all.push_back(textureOf(8, 8, true, dots));
  return all;
}

std::vector<scene::Material> materials() {
  std::vector<scene::Material> all{plainMaterial("floor", vec3(0.6f), 0, 0.8f),
                                   plainMaterial("metal", vec3(0.9f, 0.7f, 0.3f), 1, 0.3f),
                                   plainMaterial("holes", vec3(1), 0, 0.5f),
                                   plainMaterial("glass", vec3(0.3f, 0.8f, 0.4f), 0, 0.1f),
                                   plainMaterial("both sides", vec3(0.8f, 0.2f, 0.2f), 0, 0.6f),
                                   plainMaterial("glowing", vec3(0.2f), 0, 1),
                                   plainMaterial("unlit", vec3(0.1f, 0.3f, 0.9f), 0, 1)};
  setTexture(all[1], shared::kTextureMetallicRoughness, 1);
  setTexture(all[2], shared::kTextureBaseColor, 0);
  all[2].data.flags = shared::kMaterialMasked | shared::kMaterialDoubleSided;
  all[3].data.flags = shared::kMaterialBlended;
  all[3].data.baseColor.a = 0.4f;
  all[4].data.flags = shared::kMaterialDoubleSided;
  setTexture(all[5], shared::kTextureEmissive, 2);
  all[5].data.emissive = vec3(2);
  all[6].data.flags = shared::kMaterialUnlit;
  return all;
}

std::vector<scene::Light> lights() {
  scene::Light sun{.name = "sun", .type = shared::kLightDirectional, .intensity = 2};
  sun.direction = glm::normalize(vec3(0.4f, 0.5f, -1));
  sun.castShadow = true;
  scene::Light bulb{.name = "bulb", .intensity = 3};
  bulb.position = {1, -1, 2};
  bulb.range = 5;
  scene::Light spot{.name = "spot", .type = shared::kLightSpot, .color = vec3(1, 0.6f, 0.4f), .intensity = 8};
  spot.position = {-2, -1, 3};
  spot.direction = glm::normalize(vec3(0.5f, 0.4f, -1));
  spot.innerCone = 0.2f;
  return {sun, bulb, spot};
}

scene::Texture copyOf(const scene::Texture& texture) {
  scene::Texture copy{texture.name, texture.width, texture.height, texture.levels, texture.srgb, nullptr};
  copy.removed = texture.removed;
  if (texture.removed) return copy;
  copy.pixels = std::make_unique<std::byte[]>(texture.bytes());
  std::memcpy(copy.pixels.get(), texture.pixels.get(), texture.bytes());
  return copy;
}

// Drops removed elements, and returns the new index of every other one.
template <typename T>
std::vector<uint32_t> closeGaps(std::vector<T>& all) {
  std::vector<uint32_t> indices;
  uint32_t next = 0;
  for (const T& element : all) indices.push_back(element.removed ? ~0u : next++);
  std::erase_if(all, [](const T& element) { return element.removed; });
  return indices;
}

}  // namespace

scene::Scene workshop() {
  SceneBuilder builder("workshop");
  scene::Scene& scene = builder.scene;
  scene.name = scene.source = "workshop";
  scene.textures = textures();
  scene.materials = materials();
  scene::identifyMaterials(scene);
  scene.meshes = {sphereMesh(0.5f), squareMesh(), squareMesh(true)};
  for (uint32_t i = 0; i < 4; ++i) scene.meshes[kColoredSquare].extras[i].color = {1, 0.25f * float(i), 0.5f, 1};
  const auto put = [&](const char* name, uint32_t mesh, uint32_t material, vec3 at, vec3 scale, float turn = 0) {
    const glm::mat4 moved = glm::translate(glm::mat4(1), at);
    builder.addInstance(name, SceneBuilder::kRoot, mesh, material,
                        glm::scale(glm::rotate(moved, turn, vec3(0.6f, 0.8f, 0)), scale));
  };
  builder.addInstance("ground", SceneBuilder::kRoot, kSquare, 0,
                      glm::scale(glm::rotate(glm::mat4(1), -1.5707963f, vec3(1, 0, 0)), vec3(4)));
  put("ball", kSphere, 1, {-1, 0.5f, 0}, vec3(1));
  put("mirrored ball", kSphere, 1, {1, 0.5f, -1}, vec3(-1, 1, 1), 0.4f);
  put("fence", kSquare, 2, {0, 0.7f, 0.4f}, vec3(0.7f), 0.5f);
  put("pane", kSquare, 3, {0.4f, 0.6f, 1}, vec3(0.6f), -0.3f);
  put("lens", kSphere, 3, {-0.6f, 0.5f, 1}, vec3(0.8f, 0.8f, -0.8f));
  put("card", kColoredSquare, 4, {1.4f, 0.6f, 0.5f}, vec3(0.5f), 2.6f);
  put("lamp", kSphere, 5, {-1.6f, 1.4f, -0.5f}, vec3(0.5f));
  put("sign", kColoredSquare, 6, {0, 1.5f, -1}, vec3(0.4f, -0.4f, 0.4f));
  scene.lights = lights();
  return std::move(scene);
}

scene::Camera workshopCamera() {
  scene::Camera camera = frontPerspective(0.8f, 5);
  camera.toWorld[3].z = 1;
  return camera;
}

Settings workshopSettings() {
  Settings settings;
  settings.width = 48;
  settings.height = 32;
  settings.shadowAtlas = 1024;
  settings.raster = testRaster();
  using output::Aov;
  settings.aovs = {Aov::Color, Aov::Depth, Aov::Id, Aov::Part, Aov::Material, Aov::Normal, Aov::Motion};
  return settings;
}

scene::Scene withoutGaps(const scene::Scene& scene) {
  scene::Scene copy;
  copy.name = scene.name;
  copy.source = scene.source;
  copy.yUp = scene.yUp;
  for (const scene::Texture& texture : scene.textures) copy.textures.push_back(copyOf(texture));
  copy.materials = scene.materials;
  copy.meshes = scene.meshes;
  copy.nodes = scene.nodes;
  copy.instances = scene.instances;
  copy.lights = scene.lights;
  closeGaps(copy.instances);
  closeGaps(copy.lights);
  const std::vector<uint32_t> textures = closeGaps(copy.textures), materials = closeGaps(copy.materials);
  const std::vector<uint32_t> meshes = closeGaps(copy.meshes);
  for (scene::Material& material : copy.materials)
    for (scene::TextureSlot& slot : material.slots)
      if (slot.texture >= 0) slot.texture = static_cast<int>(textures[static_cast<size_t>(slot.texture)]);
  for (scene::Instance& instance : copy.instances) {
    instance.mesh = meshes[instance.mesh];
    instance.material = materials[instance.material];
  }
  return copy;
}

void expectSame(const output::FrameOutput& actual, const output::FrameOutput& expected) {
  const auto compare = [&](const auto& a, const auto& b, std::string_view what) {
    ASSERT_EQ(a.size(), b.size()) << what;
    if (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0) return;
    size_t first = 0;
    while (std::memcmp(&a[first], &b[first], sizeof(a[0])) == 0) ++first;
    ADD_FAILURE() << what << " differs, first at value " << first << " of " << a.size() << ": " << +a[first]
                  << " is to be " << +b[first];
  };
  compare(actual.display, expected.display, "the picture");
  ASSERT_EQ(actual.aovs.size(), expected.aovs.size());
  for (size_t i = 0; i < actual.aovs.size(); ++i) {
    compare(actual.aovs[i].values, expected.aovs[i].values, output::info(actual.aovs[i].aov).name);
    compare(actual.aovs[i].ids, expected.aovs[i].ids, output::info(actual.aovs[i].aov).name);
  }
}

void expectAsFresh(Renderer& renderer, vk::Device& device, const scene::Scene& scene, const Settings& settings,
                   const scene::Environment* environment, const SceneState& moment) {
  const scene::Camera camera = workshopCamera();
  const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings, moment).front());
  Renderer fresh(device, scene, environment);
  expectSame(frame, fresh.render({&camera, 1}, settings, moment).front());
}

}  // namespace latelight::render::test
