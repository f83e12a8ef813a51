// Worlds that replace device buffers while uploads of the same call to these buffers are pending: an edit or a pose of
// the scene comes first, then more worlds than the buffers hold. The validation layer reports a copy to a destroyed
// buffer.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <cstdlib>
#include <optional>
#include <string>

#include "test_device.h"
#include "worlds/same_frames.h"
#include "worlds/tiny_views.h"

namespace latelight {
namespace {

using test::testDevice;

constexpr const char* kValidation = "LATELIGHT_VALIDATION";
constexpr uint32_t kFirstWorlds = 4, kCalls = 4;

class PendingUploads : public testing::Test {
 protected:
  void SetUp() override {
    if (const char* value = std::getenv(kValidation)) before_ = value;
    setenv(kValidation, "1", 1);
  }
  void TearDown() override { before_ ? setenv(kValidation, before_->c_str(), 1) : unsetenv(kValidation); }

 private:
  std::optional<std::string> before_;
};

Options uploadOptions() {
  return test::tinyOptions({"depth", "albedo"});
}

// A square of half the width `half`.
MeshData squareMeshData(float half) {
  MeshData mesh{.name = "square",
                .positions = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}};
  mesh.normals = std::vector(4, std::array{0.0f, 0.0f, 1.0f});
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

WorldArray floatArray(const std::vector<float>& numbers, uint32_t rows) {
  return {.element = WorldArray::Element::Float32, .rows = rows, .host = numbers.data()};
}

TEST_F(PendingUploads, OfAPoseAreDroppedForTheMeshesOfTheFirstWorlds) {
  Scene scene;
  const std::string root = scene.addNode({.name = "root"}), tip = scene.addNode({.name = "tip", .parent = root});
  MeshData skinned = squareMeshData(1);
  skinned.skin = scene.addSkin({.joints = {root, tip}, .inverseBind = {}});
  skinned.joints = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  skinned.jointWeights = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  scene.addNode({.name = "skinned", .parts = {{scene.addMesh(skinned), scene.addMaterial({.name = "white"})}}});
  scene.addAnimation(
      "moves",
      {{.node = root, .property = AnimatedProperty::Translation, .times = {0, 1}, .values = {0, 0, 0, 1, 0, 0}}});
  Options posed = uploadOptions();
  posed.time = 0.3;
  Worlds worlds{.count = 2, .joints = {root, tip}, .cameras = {test::frontCamera()}};
  std::vector<float> identities(size_t{4} * 16);
  for (size_t matrix = 0; matrix < 4; ++matrix)
    for (size_t i = 0; i < 4; ++i) identities[16 * matrix + 5 * i] = 1;
  worlds.arrays.jointTransforms = floatArray(identities, 4);
  Renderer renderer(scene, testDevice());
  const std::vector<Frame> frames = renderer.render(worlds, posed);
  EXPECT_THAT(renderer.validationMessages(), testing::IsEmpty());
  Scene plain;
  plain.addInstance(plain.addMesh(squareMeshData(1)), plain.addMaterial({.name = "white"}),
                    {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  const Frame expected = Renderer(plain, testDevice()).render(test::frontCamera(), uploadOptions());
  ASSERT_EQ(frames.size(), 2u);
  for (const Frame& frame : frames) test::expectSameFrames(frame, expected);
}

// A square of one material, which edits change before each call with more worlds.
struct EditedSquare {
  Scene scene;
  Handle<Mesh> mesh = scene.addMesh(squareMeshData(1));
  Handle<Material> material = scene.addMaterial({.name = "red", .baseColor = {1, 0, 0, 1}});
  Handle<Instance> instance = scene.addInstance(mesh, material, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  Renderer renderer{scene, testDevice()};

  // Renders twice as many worlds as in the call before, and compares them with those of a new renderer.
  void expectFramesOfNewRenderer(Worlds worlds, const Options& options) {
    worlds.cameras = {test::frontCamera()};
    const std::vector<Frame> frames = renderer.render(worlds, options);
    EXPECT_THAT(renderer.validationMessages(), testing::IsEmpty());
    const std::vector<Frame> expected = Renderer(scene, testDevice()).render(worlds, options);
    ASSERT_EQ(frames.size(), expected.size());
    for (const size_t world : {size_t{0}, frames.size() - 1}) test::expectSameFrames(frames[world], expected[world]);
  }
};

TEST_F(PendingUploads, OfMaterialsAreDroppedForThoseOfMoreWorlds) {
  for (const bool isArray : {true, false}) {
    EditedSquare edited;
    edited.renderer.render(test::frontCamera(), uploadOptions());
    for (uint32_t call = 0; call < kCalls; ++call) {
      SCOPED_TRACE(testing::Message() << (isArray ? "array" : "list") << ", call " << call);
      edited.scene.setMaterial(edited.material, {.name = "green", .baseColor = {0, 0.2f * float(call), 0, 1}});
      Worlds worlds{.count = kFirstWorlds << call, .instances = {edited.instance}};
      const std::vector<float> colors(size_t{4} * worlds.count, 0.5f);
      if (isArray) {
        worlds.arrays.baseColor = floatArray(colors, 4);
      } else {
        worlds.factors.assign(worlds.count, {.baseColor = {0.5f, 0.5f, 0.5f, 1}});
        for (uint32_t world = 0; world < worlds.count; ++world)
          worlds.factors[world].roughness = 1.0f / float(world + 1);
      }
      edited.expectFramesOfNewRenderer(worlds, uploadOptions());
    }
  }
}

TEST_F(PendingUploads, OfMeshesAreDroppedForThoseOfMoreWorlds) {
  EditedSquare edited;
  edited.renderer.render(test::frontCamera(), uploadOptions());
  for (uint32_t call = 0; call < kCalls; ++call) {
    SCOPED_TRACE(testing::Message() << "call " << call);
    edited.scene.setMesh(edited.mesh, squareMeshData(1 - 0.1f * float(call)));
    Worlds worlds{.count = kFirstWorlds << call, .meshes = {edited.mesh}};
    std::vector<float> vertices;
    for (uint32_t world = 0; world < worlds.count; ++world)
      for (const auto& vertex : squareMeshData(0.8f).positions)
        vertices.insert(vertices.end(), vertex.begin(), vertex.end());
    worlds.arrays.vertices = floatArray(vertices, 3);
    edited.expectFramesOfNewRenderer(worlds, uploadOptions());
  }
}

}  // namespace
}  // namespace latelight
