// A closed cube that is mirrored by its skin, its node, or an instance's scale: its outside is visible, with normals
// toward the viewer (glTF 2.0, 3.7.4 and 3.7.3.3).
#include "render/support.h"
#include "scene/gltf_builder.h"

namespace latelight::render::test {
namespace {

using glm::vec3;
using glm::vec4;
using nlohmann::json;
using output::Aov;
using scene::test::GltfBuilder;

constexpr uint32_t kCubePixels = 20;  // pixels across 2 m
constexpr float kCubeScale = 10;
constexpr float kCubeCenter = 0.4f;      // along X, before mirroring; the side is 1 m
constexpr double kCubeFrame = 1.0 / 24;  // seconds

// One primitive, which nodes[0] uses.
GltfBuilder cubeFile(bool doubleSided) {
  GltfBuilder b;
  std::vector<vec3> positions, normals;
  std::vector<uint16_t> indices;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-0.5f, 0.5f}) {
      vec3 n(0), u(0);
      n[axis] = 2 * side, u[(axis + 1) % 3] = 0.5f;
      const vec3 v = glm::cross(n, u);
      for (const uint16_t corner : {0, 1, 2, 0, 2, 3})
        indices.push_back(static_cast<uint16_t>(positions.size() + corner));
      for (const vec3& p : {-u - v, u - v, u + v, v - u}) {
        positions.push_back(n * 0.5f + p + vec3(kCubeCenter, 0, 0));
        normals.push_back(n);
      }
    }
  b.add("materials", {{"doubleSided", doubleSided}});
  b.mesh({{"material", 0},
          {"indices", b.accessor(b.view(indices), scene::test::kUnsignedShort, "SCALAR", indices.size())},
          {"attributes", {{"POSITION", b.positions(positions)}, {"NORMAL", b.vectors(normals)}}}});
  return b;
}

// The cube is skinned to joint 1, a child of node 2.
GltfBuilder skinnedCube(bool doubleSided, const json& armature) {
  GltfBuilder b = cubeFile(doubleSided);
  json& attributes = b.primitive()["attributes"];
  attributes["JOINTS_0"] = b.accessor(b.view(std::vector<uint8_t>(4 * 24, 0)), scene::test::kUnsignedByte, "VEC4", 24);
  attributes["WEIGHTS_0"] = b.vectors(std::vector<vec4>(24, {1, 0, 0, 0}));
  b.add("nodes", json::object());
  json node = armature;
  node["children"] = {1};
  b.node(node);
  b.add("skins", {{"joints", {1}}});
  b.root["nodes"][0]["skin"] = 0;
  return b;
}

void animateCube(GltfBuilder& b, int node, const char* path, int output, const char* interpolation = "LINEAR") {
  const int times = b.accessor(b.view(std::vector<float>{0, 1}), scene::test::kFloat, "SCALAR", 2);
  b.add("animations", {{"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}},
                       {"samplers", {{{"input", times}, {"output", output}, {"interpolation", interpolation}}}}});
}

class Mirrored : public RenderTest {
 protected:
  static output::FrameOutput render(const GltfBuilder& file, std::optional<double> seconds, Raster raster) {
    const scene::Scene scene = file.load();
    SceneState moment;
    if (seconds) {
      const scene::Playback playback = scene::choosePlayback(scene, "", false);
      moment.poses = {scene::poseAt(scene, playback, *seconds - kCubeFrame), scene::poseAt(scene, playback, *seconds),
                      scene::poseAt(scene, playback, *seconds + kCubeFrame)};
    }
    Settings settings = settingsOf(kCubePixels, kCubePixels, {Aov::Depth, Aov::Normal, Aov::GeoNormal, Aov::Motion});
    settings.raster = raster;
    Renderer renderer(device(), scene, nullptr);
    const scene::Camera camera = frontCamera(1, 4);
    return std::move(renderer.render({&camera, 1}, settings, moment).front());
  }

  // Expects the cube's near face, 3.5 m away, around x = -kCubeCenter: 10 x 10 pixels.
  static void expectNearFace(const GltfBuilder& file, std::optional<double> seconds, float forward = 0) {
    for (const Raster raster : {Raster::Hardware, Raster::Compute, Raster::Rays}) {
      SCOPED_TRACE(nameOf(raster));
      const output::FrameOutput frame = render(file, seconds, raster);
      for (uint32_t i = 0; i < kCubePixels * kCubePixels; ++i) {
        const float x = (float(i % kCubePixels) + 0.5f) / kCubeScale - 1,
                    y = 1 - (float(i / kCubePixels) + 0.5f) / kCubeScale;
        const float depth = imageOf(frame, Aov::Depth).values[i];
        if (std::abs(x + kCubeCenter) > 0.5f || std::abs(y) > 0.5f) {
          ASSERT_TRUE(std::isinf(depth)) << i;
          continue;
        }
        ASSERT_NEAR(depth, 3.5f, 1e-4f) << i;
        for (const Aov aov : {Aov::Normal, Aov::GeoNormal})
          ASSERT_LE(glm::length(vec3At(imageOf(frame, aov), i) - vec3(0, 0, 1)), 1e-4f) << i;
        const float* motion = &imageOf(frame, Aov::Motion).values[4 * i];
        ASSERT_NEAR(motion[0], -forward, 1e-3f);
        ASSERT_NEAR(motion[2], forward, 1e-3f);
      }
    }
  }
};

TEST_F(Mirrored, BySkins) {
  for (const bool doubleSided : {false, true}) {
    SCOPED_TRACE(doubleSided ? "double-sided" : "single-sided");
    expectNearFace(skinnedCube(doubleSided, {{"scale", {-1, 1, 1}}}), std::nullopt);
    GltfBuilder bindPose = skinnedCube(doubleSided, json::object());  // the mirror is the inverse bind matrix
    glm::mat4 mirror(1);
    mirror[0][0] = -1;
    bindPose.root["skins"][0]["inverseBindMatrices"] =
        bindPose.accessor(bindPose.view(std::vector{mirror}), scene::test::kFloat, "MAT4", 1);
    expectNearFace(bindPose, std::nullopt);
    // Without normals in the file.
    GltfBuilder flat = skinnedCube(doubleSided, {{"scale", {-1, 1, 1}}});
    flat.primitive()["attributes"].erase("NORMAL");
    expectNearFace(flat, std::nullopt);
  }
}

// Mirrored or not at rest, and mirrored by the pose.
TEST_F(Mirrored, BySkinsThatMove) {
  for (const bool doubleSided : {false, true})
    for (const float atRest : {1.0f, -1.0f}) {
      SCOPED_TRACE(atRest);
      GltfBuilder b = skinnedCube(doubleSided, {{"scale", {atRest, 1, 1}}});
      animateCube(b, 2, "scale", b.vectors(std::vector<vec3>{{1, 1, 1}, {-1, 1, 1}}), "STEP");
      expectNearFace(b, 2.0);
      if (atRest < 0) expectNearFace(b, std::nullopt);
      b.primitive()["attributes"].erase("NORMAL");
      expectNearFace(b, 2.0);
    }
  // The joint moves along X at 0.4 m/s below its mirrored armature, so the cube moves in the opposite direction.
  GltfBuilder b = skinnedCube(false, {{"scale", {-1, 1, 1}}});
  animateCube(b, 1, "translation", b.vectors(std::vector<vec3>{{-0.2f, 0, 0}, {0.2f, 0, 0}}));
  expectNearFace(b, 0.5, float(-0.4 * kCubeFrame * kCubeScale));
}

TEST_F(Mirrored, ByNodesWithMorphTargets) {
  GltfBuilder b = cubeFile(false);
  b.root["nodes"][0]["scale"] = {-1, 1, 1};
  // Half the weight shifts the vertices by 0.4 m along X, which the node's translation cancels.
  b.primitive()["targets"] = {{{"POSITION", b.vectors(std::vector<vec3>(24, {0.8f, 0, 0}))}}};
  b.root["nodes"][0]["translation"] = {0.4, 0, 0};
  animateCube(b, 0, "weights", b.accessor(b.view(std::vector<float>{0, 1}), scene::test::kFloat, "SCALAR", 2));
  expectNearFace(b, 0.5, float(-0.8 * kCubeFrame * kCubeScale));
}

TEST_F(Mirrored, ByInstances) {
  GltfBuilder b = cubeFile(false);
  const int scales = b.vectors(std::vector<vec3>{{-1, 1, 1}});
  b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = scales;
  b.use("EXT_mesh_gpu_instancing");
  expectNearFace(b, std::nullopt);
}

}  // namespace
}  // namespace latelight::render::test
