// The node tree, instances and their ids, cameras and lights.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <set>
#include <unordered_set>

#include "base/hash.h"
#include "base/log.h"
#include "base/memory.h"
#include "gltf_builder.h"
#include "scene/edit.h"
#include "scene/framing.h"
#include "scene/objects.h"
#include "shared/light.h"

namespace latelight::scene::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

vec3 apply(const mat4& m, vec3 p) {
  return vec3(m * vec4(p, 1));
}

TEST(GltfNodes, TransformsByPartsAndByMatrix) {
  GltfBuilder b = triangleFile();
  double h = std::sqrt(0.5);
  b.root["nodes"][0]["translation"] = {1, 2, 3};
  b.root["nodes"][0]["rotation"] = {0, 0, h, h};  // a quarter turn about Z
  b.root["nodes"][0]["scale"] = {2, 1, 1};
  Scene scene = b.load();
  expectNear(apply(scene.nodes[0].local, vec3(1, 0, 0)), vec3(1, 4, 3));
  // Conversion to the renderer's world: the file's Y is up, which is Z here; the file's Z points towards the viewer,
  // which is -Y here.
  expectNear(apply(scene.instances[0].toWorld, vec3(1, 0, 0)), vec3(1, -3, 4));
  b.root["nodes"][0] = {{"mesh", 0}, {"matrix", {0, 2, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1}}};
  expectNear(apply(b.load().instances[0].toWorld, vec3(1, 0, 0)), vec3(1, -3, 4));
}

TEST(GltfNodes, PathsAreUniqueAndIdsComeFromThem) {
  GltfBuilder b = triangleFile();
  b.root["nodes"] = {{{"name", "Car"}, {"children", {1, 2, 3, 4}}},
                     {{"name", "Wheel"}, {"mesh", 0}},
                     {{"name", "Wheel"}, {"mesh", 0}},
                     {{"mesh", 0}},
                     {{"name", "Wheel#2"}, {"mesh", 0}}};
  Scene scene = b.load();
  std::vector<std::string> paths;
  for (const Node& node : scene.nodes) paths.push_back(node.path);
  EXPECT_THAT(paths, ElementsAre("/Car", "/Car/Wheel", "/Car/Wheel#2", "/Car/node3", "/Car/Wheel#2#2"));
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.meshes.size(), 1u);
  for (const Instance& instance : scene.instances) {
    EXPECT_EQ(instance.id, hash32(scene.nodes[instance.node].path));
    EXPECT_EQ(instance.part, instance.id);
  }
  EXPECT_EQ(scene.nodes[1].parent, 0);
  EXPECT_EQ(scene.nodes[0].parent, -1);
}

TEST(GltfNodes, PrimitivesOfANodeArePartsOfIt) {
  GltfBuilder b = triangleFile();
  b.root["nodes"][0]["name"] = "Box";
  json second = b.primitive();
  second["material"] = b.add("materials", {{"name", "second"}});
  b.root["meshes"][0]["primitives"].push_back(second);
  Scene scene = b.load();
  ASSERT_EQ(scene.instances.size(), 2u);
  for (uint32_t i = 0; i < 2; ++i) {
    EXPECT_EQ(scene.instances[i].id, hash32("/Box"));
    EXPECT_EQ(scene.instances[i].part, hash32(fmt::format("/Box/primitive{}", i)));
    EXPECT_EQ(scene.instances[i].primitive, i);
  }
  EXPECT_EQ(scene.meshes.size(), 1u);  // the same geometry in another material
  EXPECT_EQ(scene.materials[scene.instances[0].material].name, "default");
  EXPECT_EQ(scene.materials[scene.instances[1].material].name, "second");
}

TEST(GltfNodes, OnlyTheShownSceneIsLoaded) {
  GltfBuilder b = triangleFile();
  b.add("nodes", {{"mesh", 0}, {"name", "other"}});
  b.root["scenes"].push_back({{"nodes", {1}}});
  b.root["scene"] = 1;
  Scene scene = b.load();
  ASSERT_EQ(scene.nodes.size(), 1u);
  EXPECT_EQ(scene.nodes[0].name, "other");
  b.root.erase("scene");
  EXPECT_EQ(b.load().nodes[0].name, "node0");
  b.root.erase("scenes");
  EXPECT_EQ(b.load().nodes.size(), 2u);
}

TEST(GltfNodes, CyclesAndSecondParents) {
  GltfBuilder b = triangleFile();
  b.root["nodes"] = {{{"children", {1}}}, {{"children", {2}}}, {{"children", {1}}}};
  EXPECT_THAT(errorOf(b), HasSubstr("nodes[1] is the child of both nodes[0] and nodes[2]"));
  b.root["nodes"] = {{{"children", {1}}}, {{"children", {0}}}};
  EXPECT_THAT(errorOf(b), HasSubstr("cycle"));
  b.root["nodes"] = {{{"children", {1, 1}}}, json::object()};
  EXPECT_THAT(errorOf(b), HasSubstr("a node has one parent"));
  b.root["nodes"] = {{{"children", {5}}}};
  EXPECT_THAT(errorOf(b), HasSubstr("nodes[0].children[0] is 5, but there are 1 nodes"));
}

TEST(GltfNodes, DeepTreesDontOverflow) {
  GltfBuilder b = triangleFile();
  for (int i = 0; i < 5000; ++i) b.root["nodes"][size_t(i)] = {{"children", {i + 1}}, {"name", "n"}};
  b.root["nodes"][5000] = {{"mesh", 0}};
  EXPECT_EQ(b.load().nodes.size(), 5001u);
  for (int i = 0; i < 5000; ++i) b.root["nodes"][size_t(i)]["name"] = std::string(100, 'n');
  EXPECT_THAT(errorOf(b), HasSubstr("nested too deep"));
}

TEST(GltfNodes, GpuInstancing) {
  GltfBuilder b = triangleFile();
  b.root["nodes"][0]["name"] = "Tree";
  b.root["nodes"][0]["translation"] = {0, 0, 10};
  int t = b.positions({{1, 0, 0}, {2, 0, 0}});
  std::vector<int16_t> quarter = {0, 0, 0, 32767, 0, 0, 23170, 23170};
  int r = b.accessor(b.view(quarter), kShort, "VEC4", 2);
  int s = b.positions({{1, 1, 1}, {3, 3, 3}});
  b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", t}, {"ROTATION", r}, {"SCALE", s}};
  Scene scene = b.load();
  ASSERT_EQ(scene.instances.size(), 2u);
  expectNear(apply(toGltfFromWorld() * scene.instances[0].toWorld, vec3(1, 0, 0)), vec3(2, 0, 10));
  expectNear(apply(toGltfFromWorld() * scene.instances[1].toWorld, vec3(1, 0, 0)), vec3(2, 3, 10), 1e-4f);
  EXPECT_EQ(scene.instances[1].id, hash32("/Tree/instance1"));
  b.root["accessors"][size_t(s)]["count"] = 1;
  EXPECT_THAT(errorOf(b), HasSubstr("different lengths"));
}

// An object's own frame has the rotation that its node or copy states. The object's coordinates are then the mesh's,
// multiplied by the scale with its signs.
TEST(GltfNodes, ObjectsHaveTheAxesOfTheirScales) {
  for (const dvec3 scale : {dvec3(1, -2, 1), dvec3(-1, -2, 1), dvec3(-3, 1, 1), dvec3(1, 1, -1), dvec3(-1, -1, -1)})
    for (const bool isSkinned : {false, true}) {
      const vec3 point(0.25f, 0.5f, 0.125f);
      const auto expectScaled = [&](const GltfBuilder& file) {
        const Scene scene = file.load();
        const std::vector<RestFrame> frames = restFrames(scene);
        ASSERT_EQ(frames.size(), 1u);
        expectNear(apply(frames[0].objectFromMesh, point), vec3(scale) * point);
      };
      GltfBuilder file = triangleFile();
      json& node = file.root["nodes"][0];
      if (isSkinned) {
        json& attributes = file.primitive()["attributes"];
        attributes["JOINTS_0"] = file.accessor(file.view(std::vector<uint8_t>(12)), kUnsignedByte, "VEC4", 3);
        attributes["WEIGHTS_0"] = file.vectors(std::vector<vec4>(3, vec4(1, 0, 0, 0)));
        file.add("skins", {{"joints", {0}}});
        node["skin"] = 0;
      } else {
        node["scale"] = {scale.x, scale.y, scale.z};
        expectScaled(file);
        node["scale"] = {1, -1, -1};
        node["rotation"] = {1, 0, 0, 0};  // half a turn about X: together, the node does nothing
      }
      node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"SCALE", file.positions({vec3(scale)})}};
      if (isSkinned)
        expectScaled(file);
      else {
        const Scene scene = file.load();
        const uint32_t first = 0;
        EXPECT_EQ(ObjectFrames(scene).scaleSigns({&first, 1}), glm::sign(scale) * dvec3(1, -1, -1));
      }
    }
}

// An edit that moves all copies of a group alike moves the group's frame, which is that of their node.
TEST(GltfNodes, MovedCopiesMoveTheFrameOfTheirGroup) {
  GltfBuilder b = triangleFile();
  b.root["nodes"][0]["name"] = "Trees";
  b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", b.positions({{1, 0, 0}, {2, 0, 0}})}};
  Scene scene = b.load();
  ASSERT_EQ(scene.instances.size(), 2u);
  for (Instance& instance : scene.instances) instance.id = scene.nodes[0].id;
  const std::vector<uint32_t> both{0, 1};
  const auto frame = [&] { return ObjectFrames(scene).toWorld({}, instanceTransforms(scene, {}), both); };
  const dmat4 move = glm::translate(dmat4(1), dvec3(0, 0, 5));
  setTransform(scene, 0, move * scene.instances[0].toWorld);
  EXPECT_EQ(frame(), scene.nodes[0].toWorld);
  setTransform(scene, 1, move * scene.instances[1].toWorld);
  EXPECT_EQ(frame(), move * scene.nodes[0].toWorld);
}

TEST(GltfNodes, GpuInstancingByAttributesOfApplications) {
  GltfBuilder b = triangleFile();
  b.root["nodes"][0]["translation"] = {0, 0, 10};
  json& attributes = b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes = {{"_ID", b.accessor(b.view(std::vector<float>{0, 1, 2}), kFloat, "SCALAR", 3)}};
  const Scene scene = b.load();
  ASSERT_EQ(scene.instances.size(), 3u);
  for (const Instance& instance : scene.instances)
    expectNear(apply(toGltfFromWorld() * instance.toWorld, vec3(1, 0, 0)), vec3(1, 0, 10));
  attributes["TRANSLATION"] = b.positions({{1, 0, 0}, {2, 0, 0}});
  EXPECT_THAT(errorOf(b), HasSubstr("different lengths"));
}

TEST(GltfNodes, GpuInstancingByOtherTypes) {
  const auto errorWith = [](const char* attribute, Component component, const char* type) {
    GltfBuilder b = triangleFile();
    const int accessor = b.accessor(b.view(std::vector<float>(16)), component, type, 1);
    b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{attribute, accessor}};
    return errorOf(b);
  };
  EXPECT_THAT(errorWith("ROTATION", kFloat, "VEC3"),
              HasSubstr("nodes[0].EXT_mesh_gpu_instancing.ROTATION is VEC3 of FLOAT, in accessors[2]; it must be VEC4 "
                        "of FLOAT, BYTE, SHORT"));
  EXPECT_THAT(errorWith("ROTATION", kUnsignedShort, "VEC4"), HasSubstr("is VEC4 of UNSIGNED_SHORT"));
  EXPECT_THAT(errorWith("TRANSLATION", kFloat, "VEC4"), HasSubstr("must be VEC3 of FLOAT"));
  EXPECT_THAT(errorWith("SCALE", kFloat, "SCALAR"), HasSubstr("must be VEC3 of FLOAT"));
}

TEST(GltfNodes, IdsNeverCollide) {
  // 100000 instances: among the 32-bit hashes of so many names, a collision is likely (p = 0.69).
  GltfBuilder b = triangleFile();
  int t = b.positions(std::vector<vec3>(100000, vec3(0)));
  b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", t}};
  std::set<uint32_t> ids;
  std::set<uint32_t> parts;
  const Scene scene = b.load();
  for (const Instance& instance : scene.instances) ids.insert(instance.id), parts.insert(instance.part);
  EXPECT_EQ(ids.size(), 100000u);
  EXPECT_FALSE(ids.contains(0));
  EXPECT_FALSE(ids.contains(scene.nodes[0].id));
  EXPECT_EQ(parts.size(), 100000u);
  EXPECT_FALSE(parts.contains(0));
}

TEST(GltfNodes, PerspectiveCameras) {
  GltfBuilder b;
  b.add("cameras", {{"type", "perspective"}, {"name", "Eye"}, {"perspective", {{"yfov", .7}, {"znear", .1}}}});
  b.add("cameras",
        {{"type", "perspective"}, {"perspective", {{"yfov", .7}, {"znear", .1}, {"zfar", 50}, {"aspectRatio", 1.5}}}});
  b.node({{"camera", 0}, {"translation", {1, 2, 3}}, {"scale", {5, 5, 5}}});
  b.node({{"camera", 1}, {"name", "Second"}});
  Scene scene = b.load();
  ASSERT_EQ(scene.cameras.size(), 2u);
  const Camera& eye = scene.cameras[0];
  EXPECT_EQ(eye.name, "Eye");
  EXPECT_FALSE(eye.orthographic);
  EXPECT_FLOAT_EQ(eye.verticalFov, .7f);
  EXPECT_FALSE(eye.aspect);
  EXPECT_TRUE(std::isinf(eye.farClip));
  // One meter ahead of the camera is -Z in the file; the node's scale does not apply to it.
  expectNear(apply(toGltfFromWorld() * eye.toWorld, vec3(0, 1, 0)), vec3(1, 2, 2));
  expectNear(apply(toGltfFromWorld() * eye.toWorld, vec3(0, 0, 1)), vec3(1, 3, 3));
  EXPECT_EQ(scene.cameras[1].name, "Second");
  EXPECT_EQ(scene.cameras[1].farClip, 50);
  EXPECT_FLOAT_EQ(*scene.cameras[1].aspect, 1.5f);
  b.root["cameras"][1]["perspective"]["zfar"] = .05;
  testing::internal::CaptureStderr();
  EXPECT_TRUE(std::isinf(b.load().cameras.at(1).farClip));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("far plane before its near plane"));
  b.root["cameras"][1]["perspective"].erase("yfov");
  EXPECT_THAT(errorOf(b), HasSubstr("cameras[1].perspective.yfov is missing"));
}

// Depth is linear between the planes of an orthographic camera, so neither may be at infinity.
TEST(GltfNodes, ExchangedPlanesOfOrthographicCamerasAreRepaired) {
  GltfBuilder b;
  b.node({{"camera", b.add("cameras", {{"type", "orthographic"},
                                       {"orthographic", {{"xmag", 2}, {"ymag", 2}, {"znear", 5}, {"zfar", 1}}}})}});
  testing::internal::CaptureStderr();
  const Camera camera = b.load().cameras.at(0);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("far plane before its near plane: they are exchanged"));
  EXPECT_EQ(camera.nearClip, 1);
  EXPECT_EQ(camera.farClip, 5);
  b.root["cameras"][0]["orthographic"]["zfar"] = 5;
  testing::internal::CaptureStderr();
  EXPECT_TRUE(b.load().cameras.empty());
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("no depth"));
}

// glTF requires an angle below pi, and allows viewers to show files with a larger one.
TEST(GltfNodes, AnglesThatShowNothingAreReplaced) {
  GltfBuilder b;
  b.node({{"camera", b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", .1}}}})}});
  for (const auto& [angle, text] : {std::pair{3.1416, "3.1416"},
                                    {3.3, "3.3"},
                                    {45.0, "45"},
                                    {1e30, "1e+30"},
                                    {1e-30, "1e-30"},
                                    {0.0, "0"},
                                    {-1.0, "-1"}}) {
    b.root["cameras"][0]["perspective"]["yfov"] = angle;
    testing::internal::CaptureStderr();
    EXPECT_EQ(b.load().cameras.at(0).verticalFov, kDefaultVerticalFov);
    const std::string warnings = testing::internal::GetCapturedStderr();
    EXPECT_THAT(warnings, HasSubstr(fmt::format("yfov of {} radians is not possible: 0.7 is used instead", text)));
    EXPECT_EQ(std::ranges::count(warnings, '\n'), 1) << warnings;
  }
  b.root["cameras"][0]["perspective"]["yfov"] = 3.1;
  EXPECT_FLOAT_EQ(b.load().cameras.at(0).verticalFov, 3.1f);
  b.root["cameras"][0]["perspective"]["yfov"] = "wide";
  EXPECT_THAT(errorOf(b), HasSubstr("yfov"));
}

// A matrix's last row is that of an affine transform, whatever the file states; otherwise a camera has no inverse.
TEST(GltfNodes, MatricesAreTransforms) {
  for (const std::vector<double>& last : {std::vector<double>{.3, .2, .1, 1}, {0, 0, 0, 2}, {0, 0, 0, 0}}) {
    GltfBuilder b = triangleFile();
    b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", .1}}}});
    std::vector<double> matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1};
    for (size_t i = 0; i < 4; ++i) matrix[4 * i + 3] = last[i];
    b.node({{"camera", 0}, {"matrix", matrix}});
    b.root["nodes"][0]["matrix"] = matrix;
    const Scene scene = b.load();
    expectNear(vec3(toGltfFromWorld() * scene.cameras.at(0).toWorld[3]), vec3(4, 5, 6));
    for (const dmat4& m : {scene.cameras[0].toWorld, scene.instances.at(0).toWorld, scene.nodes[0].local})
      EXPECT_EQ(glm::row(m, 3), glm::dvec4(0, 0, 0, 1));
  }
}

TEST(GltfNodes, OrthographicCameras) {
  GltfBuilder b;
  b.add("cameras", {{"type", "orthographic"}, {"orthographic", {{"xmag", 4}, {"ymag", 3}, {"znear", 0}, {"zfar", 9}}}});
  b.node({{"camera", 0}});
  Camera camera = b.load().cameras.at(0);
  EXPECT_TRUE(camera.orthographic);
  EXPECT_FLOAT_EQ(*camera.aspect * camera.yHalf, 4);
  EXPECT_EQ(camera.yHalf, 3);
  EXPECT_EQ(camera.nearClip, 0);
  EXPECT_EQ(camera.farClip, 9);
  // An unusable camera is skipped, and the next one becomes the first.
  b.add("cameras", {{"type", "orthographic"}, {"orthographic", {{"xmag", 0}, {"ymag", 3}, {"znear", 0}, {"zfar", 9}}}});
  b.root["nodes"] = json::array();
  b.root["scenes"] = json::array({{{"nodes", json::array()}}});
  b.node({{"camera", 1}, {"name", "flat"}});
  b.node({{"camera", 0}, {"name", "good"}});
  testing::internal::CaptureStderr();
  const Scene scene = b.load();
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("the camera at /flat has no width"));
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_EQ(scene.cameras[0].name, "good");
}

TEST(GltfNodes, NegativeMagnificationsDoNotMirror) {
  for (const auto& [xmag, ymag, warning] :
       {std::tuple{-4, 3, "xmag of -4 is read as 4"}, {4, -3, "ymag of -3 is read as 3"}, {4, 3, ""}}) {
    GltfBuilder b;
    b.add("cameras",
          {{"type", "orthographic"}, {"orthographic", {{"xmag", xmag}, {"ymag", ymag}, {"znear", 0}, {"zfar", 9}}}});
    b.node({{"camera", 0}});
    testing::internal::CaptureStderr();
    const Camera camera = b.load().cameras.at(0);
    const std::string warnings = testing::internal::GetCapturedStderr();
    EXPECT_FLOAT_EQ(*camera.aspect * camera.yHalf, 4);
    EXPECT_EQ(camera.yHalf, 3);
    EXPECT_THAT(warnings, HasSubstr(warning));
    EXPECT_EQ(std::ranges::count(warnings, '\n'), *warning ? 1 : 0) << warnings;
  }
}

TEST(GltfNodes, PlanesAtZeroClipNothing) {
  GltfBuilder b;
  b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0}, {"zfar", 0}}}});
  b.node({{"camera", 0}});
  const Camera camera = b.load().cameras.at(0);
  EXPECT_EQ(camera.nearClip, kNearClip);
  EXPECT_TRUE(std::isinf(camera.farClip));
}

TEST(GltfNodes, PunctualLights) {
  GltfBuilder b;
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "directional"}, {"intensity", 3}},
      {{"type", "point"}, {"color", {1, .5, .25}}, {"intensity", 20}, {"range", 7}, {"name", "Bulb"}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", .2}, {"outerConeAngle", .4}}}}};
  double h = std::sqrt(0.5);
  for (int i = 0; i < 3; ++i)
    b.node({{"translation", {1, 2, 3}},
            {"rotation", {h, 0, 0, h}},
            {"scale", {4, 4, 4}},
            {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  Scene scene = b.load();
  ASSERT_EQ(scene.lights.size(), 3u);
  const Light &sun = scene.lights[0], &bulb = scene.lights[1], &spot = scene.lights[2];
  EXPECT_EQ(sun.type, shared::kLightDirectional);
  EXPECT_EQ(sun.intensity, 3);
  EXPECT_EQ(sun.color, vec3(1));
  expectNear(sun.direction, vec3(0, 0, 1));  // a quarter turn about X takes the file's -Z to its +Y: up
  EXPECT_EQ(bulb.type, shared::kLightPoint);
  EXPECT_EQ(bulb.name, "Bulb");
  EXPECT_EQ(bulb.color, vec3(1, .5f, .25f));
  EXPECT_EQ(bulb.range, 7);
  expectNear(bulb.position, vec3(1, -3, 2));
  EXPECT_EQ(spot.type, shared::kLightSpot);
  EXPECT_FLOAT_EQ(spot.innerCone, .2f);
  EXPECT_FLOAT_EQ(spot.outerCone, .4f);
  EXPECT_EQ(spot.intensity, 1);
  EXPECT_FALSE(spot.range);
  b.root["extensions"]["KHR_lights_punctual"]["lights"][1]["type"] = "laser";
  testing::internal::CaptureStderr();
  scene = b.load();
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("has the unknown type \"laser\", and is left out"));
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.lights[1].type, shared::kLightSpot);
}

// The ranges are those of KHR_lights_punctual: colors up to 1, ranges above 0, and inner cones within the outer ones.
TEST(GltfNodes, LightsOutOfRangeAreRepaired) {
  GltfBuilder b;
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"color", {2, -1, .5}}, {"range", 0}},
      {{"type", "point"}, {"range", -2}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", .75}, {"outerConeAngle", .5}}}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", .5}, {"outerConeAngle", .5}}}}};
  for (int i = 0; i < 4; ++i) b.node({{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  std::vector<std::string> warnings;
  const WarningCapture capture(warnings);
  const Scene scene = b.load();
  EXPECT_EQ(scene.lights.at(0).color, vec3(1, 0, .5f));
  EXPECT_FALSE(scene.lights.at(0).range);
  EXPECT_FALSE(scene.lights.at(1).range);
  EXPECT_EQ(scene.lights.at(2).innerCone, .5f);
  EXPECT_EQ(scene.lights.at(2).outerCone, .5f);
  const std::string lights = "extensions.KHR_lights_punctual.lights";
  EXPECT_THAT(warnings,
              testing::ElementsAre(
                  lights + "[0].color[0] is 2, which is out of range: it is read as 1",
                  lights + "[0].color[1] is -1, which is out of range: it is read as 0",
                  lights + "[0].range is 0, and is left out: it has to be above 0",
                  lights + "[1].range is -2, and is left out: it has to be above 0",
                  lights + "[2].spot.innerConeAngle is 0.75, above the outerConeAngle of 0.5: it is read as 0.5"));
}

// A node's extras override those of the light; invalid values are ignored.
TEST(GltfNodes, ExtrasSayWhatLightsCastShadows) {
  GltfBuilder b;
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"extras", {{"castShadow", true}, {"radius", .25}}}},
      {{"type", "directional"}, {"extras", {{"angle", 90}, {"radius", 7}}}},
      {{"type", "spot"}, {"spot", {{"outerConeAngle", .4}}}, {"extras", {{"castShadow", "maybe"}, {"radius", -1}}}}};
  for (int i = 0; i < 3; ++i) b.node({{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  b.node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"extras", {{"castShadow", false}}}});
  const Scene scene = b.load();
  ASSERT_EQ(scene.lights.size(), 4u);
  EXPECT_EQ(scene.lights[0].castShadow, true);
  EXPECT_EQ(scene.lights[0].size, .25f);
  EXPECT_FALSE(scene.lights[1].castShadow);
  EXPECT_FLOAT_EQ(scene.lights[1].size, 1.5707963f);
  EXPECT_FALSE(scene.lights[2].castShadow);
  EXPECT_EQ(scene.lights[2].size, 0);
  EXPECT_EQ(scene.lights[3].castShadow, false);
  EXPECT_EQ(scene.lights[3].size, .25f);
}

// The memory limit is checked before memory is allocated, for every kind of data in a file.
class GltfMemory : public testing::Test {
 protected:
  ~GltfMemory() override { setMemoryLimit(0); }
  // Scenes that other tests keep count, too.
  static void setRemaining(uint64_t bytes) { setMemoryLimit(claimedMemory() + bytes); }
  static std::string refusal(const GltfBuilder& b, uint64_t remaining) {
    setRemaining(remaining);
    return errorOf(b, ExitCode::OutOfMemory);
  }
};

TEST_F(GltfMemory, BoundsTextures) {
  // Only the header of a PNG; it is never decoded.
  const std::vector<uint8_t> header = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0,    0,    0,
                                       13,   'I', 'H', 'D', 'R',  0,    0,    0x20, 0,    0,    0,
                                       0x20, 0,   8,   6,   0,    0,    0,    0x72, 0xaa, 0xca, 0x59};
  GltfBuilder b = triangleFile();
  b.add("images", {{"bufferView", b.view(header)}});
  b.add("textures", {{"source", 0}});
  b.primitive()["material"] = b.add("materials", {{"normalTexture", {{"index", 0}}}});
  EXPECT_THAT(refusal(b, 256 << 20), testing::HasSubstr("its textures: 342 MiB are needed"));
}

TEST_F(GltfMemory, BoundsAccessorsNodesAndJson) {
  GltfBuilder zeros = triangleFile();
  zeros.primitive()["attributes"]["POSITION"] =
      zeros.add("accessors", {{"componentType", kFloat}, {"type", "VEC3"}, {"count", 30 << 20}});
  zeros.primitive()["attributes"].erase("TEXCOORD_0");
  EXPECT_THAT(refusal(zeros, 256 << 20), testing::HasSubstr("no memory for accessors[2]: 360 MiB"));
  GltfBuilder nodes = triangleFile();
  for (int i = 0; i < 20000; ++i) nodes.add("nodes", json::object());
  EXPECT_THAT(refusal(nodes, 8 << 20), testing::HasSubstr("its nodes"));
  EXPECT_THAT(refusal(nodes, 1 << 20), testing::HasSubstr("its JSON"));
  // A rejected allocation releases everything.
  setRemaining(64 << 20);
  EXPECT_EQ(nodes.load().meshes.size(), 1u);
}

TEST_F(GltfMemory, BoundsInstances) {
  GltfBuilder b = triangleFile();
  const int count = 1 << 20;
  const int zeros = b.add("accessors", {{"componentType", kFloat}, {"type", "VEC3"}, {"count", count}});
  b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", zeros}};
  EXPECT_THAT(refusal(b, 64 << 20), testing::HasSubstr("no memory for"));
  setRemaining(uint64_t{2} << 30);
  const Scene scene = b.load();
  EXPECT_EQ(scene.instances.size(), size_t(count));
  // It counts during its lifetime.
  EXPECT_THROW(MemoryClaim((uint64_t{2} << 30) - (64 << 20), "more"), Error);
}

// Two of a hundred thousand names may have the same hash.
TEST(GltfNodes, ManyInstancesHaveIdsOfTheirOwn) {
  GltfBuilder b = triangleFile();
  const size_t count = 200000;
  std::vector<vec3> places(count);
  for (size_t i = 0; i < count; ++i) places[i] = vec3(float(i), 2, 3);
  b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", b.vectors(places)}};
  const Scene scene = b.load();
  ASSERT_EQ(scene.instances.size(), count);
  std::unordered_set<uint32_t> ids;
  for (size_t i = 0; i < count; ++i) {
    ids.insert(scene.instances[i].id);
    EXPECT_EQ(vec3(toGltfFromWorld() * scene.instances[i].toWorld[3]), places[i]);
  }
  EXPECT_EQ(ids.size(), count);
  EXPECT_FALSE(ids.contains(0));
  EXPECT_EQ(scene.instances[7].id, hash32(scene.nodes[0].path + "/instance7"));
}

}  // namespace
}  // namespace latelight::scene::test
