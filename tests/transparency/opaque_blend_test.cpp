// Blended materials without any translucency are drawn as opaque ones, also in data outputs, until an edit, an
// animation or another mesh makes them translucent.
#include <gmock/gmock.h>

#include <cmath>

#include "render/support.h"
#include "scene/edit.h"
#include "scene/gltf_builder.h"
#include "transparency/scenes.h"

namespace latelight::render::test {
namespace {

using output::Aov;

class OpaqueBlend : public RenderTest {
 protected:
  // Returns true if the square in front of the camera is in the data outputs.
  static bool isInData(Renderer& renderer, const SceneState& moment = {}) {
    const scene::Camera camera = frontCamera();
    const Settings settings = settingsOf(5, 5, {Aov::Depth, Aov::Id});
    const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings, moment).front());
    const bool hasDepth = std::isfinite(imageOf(frame, Aov::Depth).values[12]);
    EXPECT_EQ(imageOf(frame, Aov::Id).ids[12] != 0, hasDepth);
    return hasDepth;
  }
  static bool isInData(const scene::Scene& scene) {
    Renderer renderer(device(), scene, nullptr);
    return isInData(renderer);
  }
  static scene::Scene squareOf(const std::vector<glm::u8vec4>& texels) {
    Stack stack;
    const uint32_t material = stack.glass({1, 1, 1, 1});
    stack.scene.textures.push_back(textureOf(2, 2, true, texels));
    setTexture(stack.scene.materials[material], shared::kTextureBaseColor, 0);
    stack.square(material, {0, 0, 0}, {1, 1});
    return std::move(stack.scene);
  }
};

TEST_F(OpaqueBlend, FollowsTheFactorThroughEdits) {
  Stack stack;
  const uint32_t material = stack.glass({1, 0, 0, 1});
  stack.square(material, {0, 0, 0}, {1, 1});
  Renderer renderer(device(), stack.scene, nullptr);
  EXPECT_TRUE(isInData(renderer));
  scene::Material edited = stack.scene.materials[material];
  for (const float alpha : {0.5f, 1.0f, 0.996f}) {
    edited.data.baseColor.a = alpha;
    scene::setMaterial(stack.scene, material, edited);
    EXPECT_EQ(isInData(renderer), alpha == 1) << alpha;
  }
}

TEST_F(OpaqueBlend, FollowsItsTexture) {
  const glm::u8vec4 solid(10, 20, 30, 255), almost(10, 20, 30, 254);
  EXPECT_TRUE(isInData(squareOf({solid, solid, solid, solid})));
  EXPECT_FALSE(isInData(squareOf({solid, solid, solid, almost})));
}

TEST_F(OpaqueBlend, FollowsTexturesThatAreReplaced) {
  const std::vector<glm::u8vec4> opaque(4, {10, 20, 30, 255}), translucent(4, {10, 20, 30, 128});
  scene::Scene scene = squareOf(opaque);
  Renderer renderer(device(), scene, nullptr);
  EXPECT_TRUE(isInData(renderer));
  for (const bool isOpaque : {false, true, false}) {
    scene::setTexture(scene, 0, textureOf(2, 2, true, isOpaque ? opaque : translucent));
    EXPECT_EQ(isInData(renderer), isOpaque);
  }
  // A new texture in the slot of a removed one.
  scene::Material material = scene.materials[0];
  const scene::Material textured = material;
  material.slots[shared::kTextureBaseColor].texture = -1;
  material.data.textures = 0;
  scene::setMaterial(scene, 0, material);
  scene::removeTexture(scene, 0);
  EXPECT_EQ(scene::addTexture(scene, textureOf(2, 2, true, opaque)), 0u);
  scene::setMaterial(scene, 0, textured);
  EXPECT_TRUE(isInData(renderer));
}

// Vertex colors count for the materials with which they are drawn, also if an edit gives a mesh another one.
TEST_F(OpaqueBlend, FollowsVertexColors) {
  Stack stack;
  scene::Scene& scene = stack.scene;
  const uint32_t first = stack.glass({1, 1, 1, 1}), second = stack.glass({1, 1, 1, 1});
  scene::Mesh colored = squareMesh(true);
  scene.meshes.push_back(colored);
  stack.square(first, {0, 0, 0}, {1, 1});
  scene.instances[0].mesh = 1;
  Renderer renderer(device(), scene, nullptr);
  EXPECT_TRUE(isInData(renderer));
  colored.extras[2].color.a = 0.75f;
  scene::setMesh(scene, 1, colored);
  EXPECT_FALSE(isInData(renderer));
  scene::setMaterialOf(scene, 0, second);
  EXPECT_FALSE(isInData(renderer));
  colored.extras[2].color.a = 1;
  scene::setMesh(scene, 1, colored);
  EXPECT_TRUE(isInData(renderer));
  // An added instance of another mesh makes its material blended for all instances.
  colored.extras[0].color.a = 0;
  const uint32_t other = scene::addMesh(scene, colored);
  const uint32_t added = scene::addInstance(scene, other, second, glm::translate(glm::mat4(1), vec3(9, 0, 0)));
  EXPECT_FALSE(isInData(renderer));
  scene::removeInstance(scene, added);
  EXPECT_TRUE(isInData(renderer));
}

// KHR_animation_pointer changes alpha from 1 to 0 in two seconds.
TEST_F(OpaqueBlend, FollowsAnimations) {
  scene::test::GltfBuilder b = scene::test::triangleFile();
  b.add("materials", {{"alphaMode", "BLEND"}});
  b.primitive()["material"] = 0;
  b.root["nodes"][0]["translation"] = {-0.3, -0.3, 0};  // around the center of the picture
  b.use("KHR_animation_pointer");
  const int times = b.accessor(b.view(std::vector<float>{0, 2}), scene::test::kFloat, "SCALAR", 2);
  const int factors = b.vectors(std::vector<vec4>{{1, 1, 1, 1}, {1, 1, 1, 0}});
  const nlohmann::json pointer = {{"pointer", "/materials/0/pbrMetallicRoughness/baseColorFactor"}};
  b.add("animations",
        {{"channels",
          {{{"sampler", 0}, {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", pointer}}}}}}}},
         {"samplers", {{{"input", times}, {"output", factors}}}}});
  const scene::Scene scene = b.load();
  Renderer renderer(device(), scene, nullptr);
  EXPECT_TRUE(isInData(renderer));
  const scene::Playback playback = scene::choosePlayback(scene, "", false);
  for (const double seconds : {0.0, 0.5, 0.0}) {
    const scene::Pose pose = scene::poseAt(scene, playback, seconds);
    EXPECT_EQ(isInData(renderer, {.poses = {pose, pose, pose}}), seconds == 0) << seconds;
  }
  EXPECT_TRUE(isInData(renderer));
}

// There is no message if nothing is omitted. (The test `program` checks the message, which is printed once per
// process.)
TEST_F(OpaqueBlend, NothingIsSaidOfWhatIsThere) {
  Stack stack;
  stack.square(stack.glass({1, 0, 0, 0.5f}), {0, 0, 0}, {1, 1});
  const scene::Camera camera = frontCamera();
  testing::internal::CaptureStderr();
  Renderer renderer(device(), stack.scene, nullptr);
  Settings settings = settingsOf(5, 5, {Aov::Color});
  renderer.render({&camera, 1}, settings);
  settings.aovs = {Aov::Depth};
  settings.dataSurfaces = DataSurfaces::Any;
  renderer.render({&camera, 1}, settings);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace latelight::render::test
