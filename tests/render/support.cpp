#include "render/support.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "scene/framing.h"
#include "scene/half.h"
#include "scene/load/load.h"
#include "scene/textures/texture.h"
#include "test_device.h"

namespace latelight::render::test {

namespace {

std::unique_ptr<vk::Device> shared, sharedGpuPaths;

vk::DeviceOptions testOptions(bool cpuShaders) {
  return {.selector = latelight::test::testDevice(), .validation = true, .cpuShaders = cpuShaders};
}

// Static destructors run too late for objects that the device's own destructor uses.
class Shutdown : public testing::Environment {
  void TearDown() override {
    shared.reset();
    sharedGpuPaths.reset();
  }
};
[[maybe_unused]] testing::Environment* const shutdown = testing::AddGlobalTestEnvironment(new Shutdown);

}  // namespace

vk::Device& RenderTest::device() {
  if (!shared) shared = std::make_unique<vk::Device>(testOptions(!std::getenv("LATELIGHT_TEST_GPU_SHADERS")));
  return *shared;
}

vk::Device& RenderTest::gpuPaths() {
  if (!sharedGpuPaths) sharedGpuPaths = std::make_unique<vk::Device>(testOptions(false));
  return *sharedGpuPaths;
}

void RenderTest::TearDown() {
  for (vk::Device* used : {shared.get(), sharedGpuPaths.get()})
    for (const std::string& message : used ? used->validationMessages() : std::vector<std::string>{})
      ADD_FAILURE() << message;
}

Raster testRaster() {
  const char* name = std::getenv("LATELIGHT_TEST_RASTER");
  return name && *name ? choiceNamed<Raster>(name).value() : Raster::Hardware;
}

std::vector<const Layout*> layoutsToMeet() {
  if (testRaster() == Raster::Compute)
    return {&findLayout("compact"), &findLayout("killzone2"), &findLayout("visibility")};
  std::vector<const Layout*> drawn;
  for (const Layout& layout : layouts())
    if (layout.hasTargets()) drawn.push_back(&layout);
  return drawn;
}

std::string caseName(const testing::TestParamInfo<std::string>& info) {
  return info.param.substr(0, info.param.find('.'));
}

output::FrameOutput renderOne(vk::Device& device, const scene::Scene& scene, const scene::Camera& camera,
                              const Settings& settings, const scene::Environment* environment) {
  Renderer renderer(device, scene, environment);
  return std::move(renderer.render({&camera, 1}, settings).front());
}

const output::AovImage& imageOf(const output::FrameOutput& frame, output::Aov aov) {
  for (const output::AovImage& image : frame.aovs)
    if (image.aov == aov) return image;
  throw std::logic_error("the test asked for no " + std::string(output::info(aov).name));
}

const scene::Scene& hall() {
  static const scene::Scene scene = scene::load("builtin:hall,triangles=60k,lights=20");
  return scene;
}

scene::Camera cameraOf(const scene::Scene& scene, uint32_t width, uint32_t height) {
  if (!scene.cameras.empty()) return scene.cameras.front();
  return scene::frameScene(scene, static_cast<float>(width) / static_cast<float>(height));
}

scene::Mesh squareMesh(bool extras) {
  scene::Mesh mesh;
  mesh.name = "square";
  for (glm::vec2 uv : {glm::vec2(0, 0), glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0)}) {
    mesh.positions.push_back({2 * uv.x - 1, 1 - 2 * uv.y, 0});
    mesh.attributes.push_back({glm::vec3(0, 0, 1), glm::vec4(1, 0, 0, 1), uv});
    if (extras) mesh.extras.push_back({uv * glm::vec2(2, 3), glm::vec4(1)});
  }
  mesh.indices = {0, 1, 3, 1, 2, 3};
  scene::findBounds(mesh);
  return mesh;
}

scene::Mesh sphereMesh(float radius, uint32_t parallels) {
  const uint32_t meridians = 2 * parallels;
  scene::Mesh mesh;
  mesh.name = "sphere";
  for (uint32_t j = 0; j <= parallels; ++j)
    for (uint32_t i = 0; i <= meridians; ++i) {
      const glm::vec2 uv(static_cast<float>(i) / static_cast<float>(meridians),
                         static_cast<float>(j) / static_cast<float>(parallels));
      const float around = 2 * shared::kPi * uv.x, down = shared::kPi * uv.y;
      const glm::vec3 normal(std::sin(down) * std::cos(around), std::cos(down), -std::sin(down) * std::sin(around));
      mesh.positions.push_back(normal * radius);
      mesh.attributes.push_back({normal, glm::vec4(-std::sin(around), 0, -std::cos(around), 1), uv});
    }
  for (uint32_t j = 0; j < parallels; ++j)
    for (uint32_t i = 0; i < meridians; ++i) {
      const uint32_t a = j * (meridians + 1) + i, b = a + meridians + 1;  // a is above b
      mesh.indices.insert(mesh.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
    }
  scene::findBounds(mesh);
  return mesh;
}

scene::Camera frontCamera(float half, float distance) {
  scene::Camera camera = frontPerspective(1, distance);
  camera.orthographic = true;
  camera.yHalf = half;
  camera.farClip = 2 * distance;
  return camera;
}

scene::Camera frontPerspective(float verticalFov, float distance) {
  scene::Camera camera;
  camera.toWorld[3] = glm::vec4(0, -distance, 0, 1);  // glTF's -Z is the world's +Y, the camera's forward direction
  camera.verticalFov = verticalFov;
  camera.nearClip = 0.125f;
  return camera;
}

scene::Environment constantEnvironment() {
  auto image = [](uint32_t size) {
    scene::FloatImage white(size, size);
    std::ranges::fill(white.pixels, 1.0f);
    return scene::makeRadianceMap(white, false);
  };
  scene::Environment environment;
  environment.name = "constant";
  environment.radiance = image(2);
  environment.diffuse = image(4);
  environment.specular = {image(16), image(8), image(4)};
  return environment;
}

scene::Texture textureOf(uint32_t width, uint32_t height, bool srgb, const std::vector<glm::u8vec4>& colors) {
  scene::Texture texture = scene::makeTexture({width, height}, srgb, "texture");
  std::memcpy(texture.pixels.get(), colors.data(), colors.size() * sizeof(colors[0]));
  scene::buildMips(texture);
  return texture;
}

void setTexture(scene::Material& material, uint32_t slot, int index, scene::Sampler sampler) {
  material.slots[slot] = {index, sampler};
  material.data.textures |= 1u << slot;
}

void addSquareOfFourKinds(scene::Scene& scene) {
  scene.meshes.push_back(squareMesh());
  std::vector<glm::u8vec4> holes;
  for (int i = 0; i < 8 * 8; ++i) holes.emplace_back(200, 100, 50, (i * 37 % 11) < 5 ? 40 : 220);
  scene.textures.push_back(textureOf(8, 8, true, holes));
  for (uint32_t kind = 0; kind < 4; ++kind) {
    scene::Material material = scene::plainMaterial("kind", glm::vec3(0.5f), 0, 1);
    if (kind & 1) material.data.flags |= shared::kMaterialDoubleSided;
    if (kind & 2) {
      material.data.flags |= shared::kMaterialMasked;
      setTexture(material, shared::kTextureBaseColor, 0, kNearest);
    }
    scene.materials.push_back(std::move(material));
  }
}

}  // namespace latelight::render::test
