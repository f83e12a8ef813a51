// Random edits: after any edits between frames, each frame equals that of a new renderer.
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "edits/host_memory.h"
#include "edits/workshop.h"
#include "long_tests.h"
#include "scene/edit.h"
#include "test_device.h"
#include "vk/memory.h"
#include "without_validation.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using scene::Instance;
using scene::Light;
using scene::Material;

constexpr uint32_t kEdits = 10000, kFrames = 60;
constexpr uint32_t kMaxInstances = 24, kMaxLights = 12, kMaxMaterials = 12, kMaxMeshes = 8, kMaxTextures = 8;
constexpr uint32_t kSun = 0;    // is never removed, so that every frame has shadows
constexpr uint32_t kFloor = 0;  // the index of a material
constexpr uint32_t kFirstTextures = 3;

class Editor {
 public:
  Editor(scene::Scene& scene, uint32_t seed) : scene_(scene), dice_(seed) {}

  void edit() {
    switch (dice_.below(15)) {
      case 0:
      case 1:
      case 2:
        return scene::setTransform(scene_, anyInstance(), transform());
      case 3:
        return addInstance();
      case 4:
        return removeInstance();
      case 5:
        return scene::setMaterialOf(scene_, anyInstance(), anyMaterial());
      case 6:
        return scene::setMaterial(scene_, anyMaterial(), material());
      case 7:
        return setLight();
      case 8:
        return addLight();
      case 9:
        return removeLight();
      case 10:
        return scene::setMesh(scene_, any(scene_.meshes), mesh());
      case 11:
        return removeShape();
      case 12:
        return setTexture();
      case 13:
        return dice_.chance(0.5f) ? addTexture() : removeTexture();
      default:
        return addShape();
    }
  }

  // Brings the scene to a similar state, whatever was edited before: the maximum number of all elements, each of one
  // kind.
  void level() {
    fill();
    for (uint32_t i = 0; i < scene_.meshes.size(); ++i) scene::setMesh(scene_, i, squareMesh());
    for (uint32_t i = 0; i < scene_.materials.size(); ++i) scene::setMaterial(scene_, i, plain());
    for (uint32_t i = 0; i < scene_.textures.size(); ++i)
      scene::setTexture(scene_, i, noise(8, scene_.textures[i].srgb));
    for (uint32_t i = 0; i < scene_.instances.size(); ++i) {
      if (scene_.instances[i].removed) continue;
      scene::setMaterialOf(scene_, i, kFloor);
      scene::setTransform(scene_, i, glm::mat4(1));
    }
    Light light = scene_.lights[kSun];
    for (uint32_t i = 0; i < scene_.lights.size(); ++i)
      if (!scene_.lights[i].removed) scene::setLight(scene_, i, light);
  }

 private:
  // Adds elements until every maximum is reached.
  void fill() {
    while (present(scene_.instances) < kMaxInstances) addInstance();
    while (present(scene_.lights) < kMaxLights) addLight();
    while (present(scene_.materials) < kMaxMaterials) addShape();
    while (present(scene_.meshes) < kMaxMeshes) addShape();
    while (present(scene_.textures) < kMaxTextures) addTexture();
  }

  template <typename T>
  static uint32_t count(const std::vector<T>& all) {
    return static_cast<uint32_t>(all.size());
  }
  template <typename T>
  static uint32_t present(const std::vector<T>& all) {
    return static_cast<uint32_t>(std::ranges::count(all, false, &T::removed));
  }
  template <typename T>
  uint32_t any(const std::vector<T>& all, uint32_t first = 0) {
    uint32_t index = 0;
    do index = first + dice_.below(count(all) - first);
    while (all[index].removed);
    return index;
  }
  uint32_t anyInstance() { return any(scene_.instances); }
  uint32_t anyMaterial() { return any(scene_.materials); }
  // Returns an image whose colors are stored in this way. The initial images are never removed.
  int anyTexture(bool srgb) {
    uint32_t index = 0;
    do index = any(scene_.textures);
    while (scene_.textures[index].srgb != srgb);
    return static_cast<int>(index);
  }

  glm::mat4 transform() {
    glm::mat4 m = glm::translate(glm::mat4(1), dice_.inside({-2, -2, 0}, {2, 2, 2}));
    m = glm::rotate(m, dice_.between(-3, 3), glm::normalize(dice_.inside(vec3(0.1f), vec3(1))));
    m = glm::scale(m, dice_.inside(vec3(0.1f), vec3(1.2f)));
    if (dice_.chance(0.3f)) m[dice_.below(3)] *= -1.0f;
    return m;
  }

  void addInstance() {
    if (present(scene_.instances) == kMaxInstances) return removeInstance();
    // Sometimes this is exactly the position of another instance; the one that is drawn last is visible.
    const bool twin = dice_.chance(0.3f);
    const Instance& like = scene_.instances[anyInstance()];
    const uint32_t mesh = twin ? like.mesh : any(scene_.meshes);
    const uint32_t material = twin && dice_.chance(0.5f) ? like.material : anyMaterial();
    const glm::dmat4 where = twin ? like.toWorld : glm::dmat4(transform());
    scene::addInstance(scene_, mesh, material, where, dice_.chance(0.5f) ? "added" : "");
  }

  void removeInstance() { removeInstance(anyInstance()); }
  void removeInstance(uint32_t instance) {
    if (present(scene_.instances) > 4) scene::removeInstance(scene_, instance);
  }

  static Material plain() { return scene::plainMaterial("", vec3(0.5f), 0, 0.5f); }

  // In the slots that the scene has initially.
  Material material() {
    Material m = scene::plainMaterial("", dice_.inside(vec3(0), vec3(1)), dice_.unit(), dice_.unit());
    if (dice_.chance(0.4f))
      test::setTexture(m, shared::kTextureBaseColor, anyTexture(true),
                       dice_.chance(0.5f) ? kNearest : scene::Sampler());
    if (dice_.chance(0.4f)) test::setTexture(m, shared::kTextureMetallicRoughness, anyTexture(false));
    if (dice_.chance(0.3f)) test::setTexture(m, shared::kTextureEmissive, anyTexture(true));
    if (dice_.chance(0.3f)) m.data.emissive = dice_.inside(vec3(0), vec3(2));
    constexpr uint32_t kAlpha[] = {0, 0, shared::kMaterialMasked, shared::kMaterialBlended};
    m.data.flags = kAlpha[dice_.below(4)];
    if (dice_.chance(0.4f)) m.data.flags |= shared::kMaterialDoubleSided;
    if (dice_.chance(0.1f)) m.data.flags |= shared::kMaterialUnlit;
    m.data.baseColor.a = dice_.unit();
    m.data.alphaCutoff = dice_.unit();
    return m;
  }

  Light light() {
    // The first area light requires pipelines, and these edits must require none; test_area_lights edits them.
    constexpr uint32_t kTypes[] = {shared::kLightDirectional, shared::kLightPoint, shared::kLightSpot};
    Light l{.name = "light", .type = kTypes[dice_.below(3)], .intensity = dice_.between(0, 4)};
    l.color = dice_.inside(vec3(0), vec3(1));
    l.position = dice_.inside({-3, -3, 0.2f}, {3, 3, 3});
    l.direction = glm::normalize(dice_.inside({-1, -1, -2}, {1, 1, -0.5f}));
    if (dice_.chance(0.7f)) l.range = dice_.between(0.5f, 6);
    l.outerCone = dice_.between(0.1f, 1.5f);
    l.innerCone = l.outerCone * dice_.unit();
    l.size = dice_.chance(0.5f) ? 0.1f : 0;
    if (dice_.chance(0.5f)) l.castShadow = dice_.chance(0.5f);
    if (dice_.chance(0.1f)) l.intensity = 0;
    return l;
  }

  void setLight() {
    const uint32_t index = any(scene_.lights);
    Light changed = light();
    if (index == kSun) changed = scene_.lights[kSun], changed.direction = light().direction;
    scene::setLight(scene_, index, changed);
  }

  void addLight() {
    if (present(scene_.lights) == kMaxLights) return removeLight();
    scene::addLight(scene_, light());
  }

  void removeLight() {
    if (present(scene_.lights) > 1) scene::removeLight(scene_, any(scene_.lights, kSun + 1));
  }

  scene::Mesh mesh() {
    switch (dice_.below(4)) {
      case 0:
        return squareMesh();
      case 1:
        return squareMesh(true);
      default:
        return sphereMesh(dice_.between(0.1f, 0.8f));
    }
  }

  void addShape() {
    if (present(scene_.materials) < kMaxMaterials) scene::addMaterial(scene_, material());
    if (present(scene_.meshes) < kMaxMeshes) scene::addMesh(scene_, mesh());
  }

  // Removes a mesh and a material after the instances that use them.
  void removeShape() {
    const uint32_t mesh = any(scene_.meshes), material = any(scene_.materials);
    const auto hasEither = [&](const Instance& i) { return i.mesh == mesh || i.material == material; };
    for (uint32_t i = 0; i < scene_.instances.size(); ++i)
      if (!scene_.instances[i].removed && hasEither(scene_.instances[i])) removeInstance(i);
    const auto isUsed = [&](const Instance& i) { return !i.removed && hasEither(i); };
    if (std::ranges::any_of(scene_.instances, isUsed)) return;
    if (present(scene_.meshes) > 2) scene::removeMesh(scene_, mesh);
    if (material != kFloor) scene::removeMaterial(scene_, material);
  }

  scene::Texture noise(uint32_t side, bool srgb) {
    std::vector<glm::u8vec4> texels(side * side);
    for (glm::u8vec4& texel : texels) texel = glm::u8vec4(dice_.inside(vec3(0), vec3(255)), dice_.below(256));
    return textureOf(side, side, srgb, texels);
  }

  // Sizes are powers of two, because lavapipe compiles shaders again for other sizes.
  uint32_t anySide() { return 4u << dice_.below(3); }

  void setTexture() {
    const uint32_t index = any(scene_.textures);
    scene::setTexture(scene_, index, noise(anySide(), scene_.textures[index].srgb));
  }

  void addTexture() {
    if (present(scene_.textures) == kMaxTextures) return removeTexture();
    scene::addTexture(scene_, noise(anySide(), dice_.chance(0.5f)));
  }

  // Materials that sample it are assigned another texture first.
  void removeTexture() {
    if (count(scene_.textures) <= kFirstTextures) return;
    const uint32_t index = kFirstTextures + dice_.below(count(scene_.textures) - kFirstTextures);
    if (scene_.textures[index].removed) return;
    const auto samples = [&](const scene::TextureSlot& slot) { return slot.texture == static_cast<int>(index); };
    for (uint32_t i = 0; i < scene_.materials.size(); ++i)
      while (std::ranges::any_of(scene_.materials[i].slots, samples)) scene::setMaterial(scene_, i, material());
    scene::removeTexture(scene_, index);
  }

  scene::Scene& scene_;
  Dice dice_;
};

class EditsTest : public RenderTest {
 protected:
  scene::Scene scene_ = workshop();
  const scene::Environment sky_ = constantEnvironment();
  const Settings settings_ = workshopSettings();
  const scene::Camera camera_ = workshopCamera();

  output::FrameOutput render(Renderer& renderer) const {
    return std::move(renderer.render({&camera_, 1}, settings_).front());
  }
  output::FrameOutput fresh(const scene::Scene& scene) { return renderOne(device(), scene, camera_, settings_, &sky_); }
};

// Returns a material without the traits for which shaders of CPU devices are specialized (GpuMaterials::traits).
scene::Material materialWithoutTraits() {
  scene::Material material = scene::plainMaterial("without traits", vec3(1), 0, 1);
  test::setTexture(material, shared::kTextureOcclusion, 0);
  material.data.transforms[shared::kTextureOcclusion].row0 = {2, 0, 0};
  material.data.specular = 0.5f;
  return material;
}

TEST_F(EditsTest, TenThousandEditsAsIfEachFrameWereTheFirst) {
  // The first material without them would be another reason to create pipelines.
  scene::addMaterial(scene_, materialWithoutTraits());
  // Objects that are created on it are created for edits.
  vk::Device own({.selector = latelight::test::testDevice(), .validation = true});
  Renderer renderer(own, scene_, &sky_);
  expectSame(render(renderer), fresh(scene_));
  const uint64_t pipelines = own.pipelinesMade();
  Editor editor(scene_, 9);
  const uint32_t edits = latelight::test::rounds(kEdits, kEdits / 5);
  for (uint32_t i = 0; i < edits && !HasFailure(); ++i) {
    editor.edit();
    if ((i + 1) % (kEdits / kFrames) != 0) continue;
    SCOPED_TRACE("after edit " + std::to_string(i));
    const output::FrameOutput frame = render(renderer);
    expectSame(frame, fresh(scene_));
    expectSame(frame, fresh(withoutGaps(scene_)));
  }
  // On CPU devices, composing has another pipeline while no surface is blended (frame/covered_tiles.h), and there are
  // two ways to evaluate materials (visibility/resolve.h).
  constexpr uint64_t kOfComposing = 1, kOfMaterials = 5;
  EXPECT_LE(own.pipelinesMade(), pipelines + kOfComposing + kOfMaterials);
  for (const std::string& message : own.validationMessages()) ADD_FAILURE() << message;
}

// Returns the memory of the renderer and its device after the same frame, repeatedly.
TEST_F(EditsTest, TenThousandEditsTakeNoMemory) {
  constexpr uint32_t kRounds = 10, kEditsARound = kEdits / kRounds;
  const latelight::test::WithoutValidation withoutValidation;
  vk::Device own({.selector = latelight::test::testDevice()});
  Renderer renderer(own, scene_, &sky_);
  Editor editor(scene_, 5);
  std::vector<vk::Allocator::Statistics> onDevice;
  std::vector<size_t> onHost;
  for (uint32_t i = 0; i < kEdits; ++i) {
    editor.edit();
    if ((i + 1) % (kEdits / kFrames) == 0) render(renderer);
    if ((i + 1) % kEditsARound != 0) continue;
    editor.level();
    for (int again = 0; again < 8; ++again) render(renderer);  // until no resource of earlier frames is cached
    onDevice.push_back(own.memory().statistics());
    onHost.push_back(leastHostBytes([&] { render(renderer); }));
  }
  EXPECT_LE(onDevice.back().allocations, onDevice[kRounds / 2 - 1].allocations);
  EXPECT_LE(onDevice.back().usedBytes, onDevice[kRounds / 2 - 1].usedBytes);
  EXPECT_LE(steadyGrowth(onHost) / kEditsARound, 13) << "bytes an edit";
}

}  // namespace
}  // namespace latelight::render::test
