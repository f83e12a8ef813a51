// Exported files, loaded again: the same ids, geometry, materials, lights, cameras, animations and variants.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>

#include "app/folder.h"
#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "base/log.h"
#include "export/export.h"
#include "export/formats.h"
#include "models/models.h"
#include "output/png.h"
#include "scene/bake.h"
#include "scene/edit.h"
#include "scene/gltf_builder.h"
#include "scene/load/load.h"
#include "scene/objects.h"
#include "scene/textures/texture.h"

namespace latelight::scene::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Scene exported(const Scene& scene, const char* name = "out.glb", const LoadOptions& options = {}) {
  const app::Folder folder;
  exports::exportScene(scene, folder.at(name));
  return load(folder.at(name), options);
}

// The instance with that part id; parts are unique.
const Instance* partOf(const Scene& scene, uint32_t part) {
  for (const Instance& instance : scene.instances)
    if (!instance.removed && instance.part == part) return &instance;
  return nullptr;
}

void expectNear(const dmat4& a, const dmat4& b) {
  for (int i = 0; i < 4; ++i) EXPECT_LT(glm::length(a[i] - b[i]), 1e-9 * (1 + glm::length(b[i])));
}

void expectSameMesh(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.indices, b.indices);
  ASSERT_EQ(a.positions.size(), b.positions.size());
  EXPECT_EQ(a.positions, b.positions);
  float normal = 0, tangent = 0, uv = 0;
  for (size_t i = 0; i < a.positions.size(); ++i) {
    normal = std::max(normal, glm::length(a.attributes[i].normal - b.attributes[i].normal));
    tangent = std::max(tangent, glm::length(a.attributes[i].tangent - b.attributes[i].tangent));
    uv = std::max(uv, glm::length(a.attributes[i].uv0 - b.attributes[i].uv0));
  }
  EXPECT_LT(normal, 1e-6f) << a.name;
  EXPECT_EQ(uv, 0) << a.name;
  // If a mesh does not use its tangents, loading may compute different ones or none.
  if (!a.attributes.empty() && a.attributes[0].tangent != vec4(0)) {
    EXPECT_LT(tangent, 1e-5f) << a.name;
  }
}

void expectSameMaterial(const Material& a, const Material& b) {
  EXPECT_EQ(a.name, b.name);
  const shared::Material &x = a.data, &y = b.data;
  EXPECT_EQ(x.baseColor, y.baseColor);
  EXPECT_EQ(x.emissive, y.emissive);
  EXPECT_EQ(x.metallic, y.metallic);
  EXPECT_EQ(x.roughness, y.roughness);
  EXPECT_EQ(x.specularColor, y.specularColor);
  EXPECT_EQ(x.specular, y.specular);
  EXPECT_NEAR(x.f0, y.f0, 1e-6);
  EXPECT_EQ(x.flags, y.flags);
  EXPECT_EQ(x.textures, y.textures);
  EXPECT_EQ(x.id, y.id);
  EXPECT_EQ(std::memcmp(&x.layers, &y.layers, sizeof x.layers), 0) << a.name;
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
    EXPECT_EQ(a.slots[slot].texture < 0, b.slots[slot].texture < 0);
    if (a.slots[slot].texture < 0) continue;
    EXPECT_EQ(a.slots[slot].sampler, b.slots[slot].sampler);
    EXPECT_LT(glm::length(x.transforms[slot].row0 - y.transforms[slot].row0), 1e-6f);
    EXPECT_LT(glm::length(x.transforms[slot].row1 - y.transforms[slot].row1), 1e-6f);
    EXPECT_EQ(x.transforms[slot].uvSet, y.transforms[slot].uvSet);
  }
}

void expectSameTexture(const Texture& a, const Texture& b) {
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  EXPECT_EQ(a.srgb, b.srgb);
  EXPECT_EQ(std::memcmp(a.pixels.get(), b.pixels.get(), size_t{4} * a.width * a.height), 0);
}

void expectSame(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.triangleCount(), b.triangleCount());
  for (const Instance& instance : b.instances) {
    if (instance.removed) continue;
    const Instance* same = partOf(a, instance.part);
    ASSERT_TRUE(same) << b.nodes[instance.node].path;
    const std::string copy = instance.copy < 0 ? "" : fmt::format("/instance{}", instance.copy);  // copies become nodes
    EXPECT_EQ(a.nodes[same->node].path, b.nodes[instance.node].path + copy);
    EXPECT_EQ(same->id, instance.id);
    EXPECT_EQ(same->hidden, instance.hidden);
    expectNear(same->toWorld, instance.toWorld);
    expectSameMesh(a.meshes[same->mesh], b.meshes[instance.mesh]);
    const Material &x = a.materials[same->material], &y = b.materials[instance.material];
    expectSameMaterial(x, y);
    for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot)
      if (y.slots[slot].texture >= 0)
        expectSameTexture(a.textures[size_t(x.slots[slot].texture)], b.textures[size_t(y.slots[slot].texture)]);
  }
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (size_t i = 0; i < a.lights.size(); ++i) {
    const Light &x = a.lights[i], &y = b.lights[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.type, y.type);
    EXPECT_EQ(x.color, y.color);
    EXPECT_EQ(x.intensity, y.intensity);
    EXPECT_EQ(x.range, y.range);
    EXPECT_EQ(x.innerCone, y.innerCone);
    EXPECT_EQ(x.outerCone, y.outerCone);
    EXPECT_EQ(x.castShadow, y.castShadow);
    EXPECT_NEAR(x.size, y.size, 1e-6);
    EXPECT_LT(glm::length(x.position - y.position), 1e-9);
    EXPECT_LT(glm::length(x.direction - y.direction), 1e-6f);
  }
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    EXPECT_EQ(a.cameras[i].name, b.cameras[i].name);
    EXPECT_EQ(a.cameras[i].verticalFov, b.cameras[i].verticalFov);
    EXPECT_EQ(a.cameras[i].aspect, b.cameras[i].aspect);
    EXPECT_EQ(a.cameras[i].nearClip, b.cameras[i].nearClip);
    EXPECT_EQ(a.cameras[i].farClip, b.cameras[i].farClip);
    for (int c = 0; c < 4; ++c) EXPECT_LT(glm::length(a.cameras[i].toWorld[c] - b.cameras[i].toWorld[c]), 1e-6);
  }
}

class ExportedModel : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Models, ExportedModel,
                         testing::Values("punctual.glb", "textured.glb", "intricate.glb", "skinned.glb",
                                         "static_skin.glb", "morphed.glb", "blended.glb", "many_materials.glb"),
                         [](const auto& info) { return info.param.substr(0, info.param.find('.')); });

TEST_P(ExportedModel, IsTheSameScene) {
  const Scene scene = load(models::modelPath(GetParam()).string());
  expectSame(exported(scene), scene);
}

TEST(Export, BuiltInScenesAreTheSame) {
  for (const char* name : {"builtin:hall,triangles=50k,lights=12", "builtin:spheres", "builtin:boxes"}) {
    const Scene scene = load(name);
    const app::Folder folder;
    exports::exportScene(scene, folder.at("out.glb"));
    expectSame(load(folder.at("out.glb")), scene);
  }
}

// Copies become nodes, and the parts of a copy are still those of its primitives.
TEST(Export, CopiesOfSeveralPrimitivesKeepTheirIds) {
  test::GltfBuilder file = test::triangleFile();
  file.root["meshes"][0]["primitives"].push_back(json(file.primitive()));
  file.root["nodes"][0]["name"] = "tree";
  file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", file.positions({{1, 0, 0}, {2, 0, 0}})}};
  const Scene scene = file.load();
  ASSERT_EQ(scene.instances.size(), 4u);
  expectSame(exported(scene), scene);
}

TEST(Export, AnimationsHaveTheSamePoses) {
  for (const char* model : {"skinned.glb", "static_skin.glb", "morphed.glb"}) {
    const Scene scene = load(models::modelPath(model).string()), again = exported(scene);
    ASSERT_EQ(again.rig.animations.size(), scene.rig.animations.size());
    for (uint32_t i = 0; i < scene.rig.animations.size(); ++i) {
      EXPECT_EQ(again.rig.animations[i].name, scene.rig.animations[i].name);
      const Playback playback{.animations = {i}};
      const Pose a = poseAt(scene, playback, 0.3), b = poseAt(again, playback, 0.3);
      ASSERT_EQ(a.world.size(), b.world.size());
      for (size_t n = 0; n < a.world.size(); ++n) expectNear(a.world[n], b.world[n]);
      EXPECT_EQ(a.weights, b.weights);
    }
    for (size_t i = 0; i < scene.meshes.size(); ++i) {
      const auto &a = scene.meshes[i].deformation, &b = again.meshes[i].deformation;
      ASSERT_EQ(a == nullptr, b == nullptr);
      if (!a) continue;
      EXPECT_EQ(a->positions, b->positions);
      EXPECT_EQ(a->jointWeights, b->jointWeights);
      EXPECT_EQ(a->targets.size(), b->targets.size());
    }
  }
}

TEST(Export, VariantsAreKept) {
  const std::string model = models::modelPath("intricate.glb").string();
  const app::Folder folder;
  exports::exportScene(load(model), folder.at("out.glb"));
  for (const char* variant : {"red", "blue"}) {
    const LoadOptions options{.variant = variant};
    expectSame(load(folder.at("out.glb"), options), load(model, options));
  }
}

// The variant's normal map has the second texture coordinates, which are turned by 90 degrees. A morph target whose
// weight nothing animates moves the triangle.
TEST(Export, TangentsFollowTheNormalMapOfAVariant) {
  test::GltfBuilder file = test::triangleFile();
  json& primitive = file.primitive();
  primitive["attributes"]["NORMAL"] = file.vectors(std::vector<vec3>(3, {0, 0, 1}));
  primitive["attributes"]["TEXCOORD_1"] = file.vectors(std::vector<vec2>{{0, 0}, {0, 1}, {1, 0}});
  file.add("images", {{"uri", "normal.png"}});
  file.add("textures", {{"source", 0}});
  primitive["material"] = file.add("materials", {{"name", "a"}, {"normalTexture", {{"index", 0}}}});
  file.add("materials", {{"name", "b"}, {"normalTexture", {{"index", 0}, {"texCoord", 1}}}});
  primitive["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 0}, {"variants", {0}}},
                                                                   {{"material", 1}, {"variants", {1}}}};
  file.use("KHR_materials_variants");
  file.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "A"}}, {{"name", "B"}}};
  const app::Folder folder;
  writeFile(folder.at("normal.png"), output::encodePng(output::Picture{1, 1, {128, 128, 255, 255}}));
  writeFile(folder.at("in.glb"), file.glb());
  exports::exportScene(load(folder.at("in.glb")), folder.at("out.glb"));
  primitive["targets"] = {{{"POSITION", file.positions(std::vector<vec3>(3, {0, 0, 1}))}}};
  file.root["meshes"][0]["weights"] = {1};
  writeFile(folder.at("morphed.glb"), file.glb());
  exports::exportScene(load(folder.at("morphed.glb"), {.morphTargets = true}), folder.at("morphed_out.glb"));
  for (const char* name : {"in.glb", "out.glb", "morphed.glb", "morphed_out.glb"})
    for (const auto& [variant, tangent] : {std::pair("A", vec4(1, 0, 0, 1)), {"B", vec4(0, 1, 0, 1)}}) {
      const Scene scene = load(folder.at(name), {.variant = variant});
      for (const auto& attributes : scene.meshes[scene.instances[0].mesh].attributes)
        EXPECT_LT(glm::length(attributes.tangent - tangent), 1e-6f) << name << ", variant " << variant;
    }
}

TEST(Export, VariantsOfRemovedMaterialsAndReusedInstancesAreLeftOut) {
  const std::string model = models::modelPath("intricate.glb").string();
  const app::Folder folder;
  Scene scene = load(model);
  ASSERT_FALSE(scene.variantMaterials.empty());
  const VariantMaterial first = scene.variantMaterials[0];
  const size_t all = scene.variantMaterials.size();
  removeInstance(scene, first.instance);
  EXPECT_EQ(scene.variantMaterials.size(), all) << "the instance may be restored";
  EXPECT_EQ(addInstance(scene, 0, 0, dmat4(1)), first.instance);
  for (const VariantMaterial& v : scene.variantMaterials) EXPECT_NE(v.instance, first.instance);

  scene = load(model);
  for (uint32_t i = 0; i < scene.instances.size(); ++i) setMaterialOf(scene, i, first.material == 0 ? 1 : 0);
  removeMaterial(scene, first.material);
  exports::exportScene(scene, folder.at("out.glb"));
  load(folder.at("out.glb"));
  for (const VariantMaterial& v : scene.variantMaterials) EXPECT_NE(v.material, first.material);
}

TEST(Export, EditsAreIncluded) {
  Scene scene = load("builtin:boxes");
  const size_t before = scene.instances.size();
  const Instance first = scene.instances[0];
  dmat4 moved = first.toWorld;
  moved[3] += glm::dvec4(1, 2, 3, 0);
  setTransform(scene, 0, moved);
  removeInstance(scene, 1);
  const Scene again = exported(scene);
  EXPECT_EQ(again.instances.size(), before - 1);
  const Instance* same = partOf(again, first.part);
  ASSERT_TRUE(same);
  expectNear(same->toWorld, moved);
}

// The vertices of an instance in the world, at a time of the first animation.
std::vector<dvec3> verticesAt(const Scene& scene, const Instance& instance, double seconds) {
  const Pose pose = scene.rig.isAnimated() ? poseAt(scene, {.animations = {0}}, seconds) : restPose(scene);
  const dmat4 toWorld = instanceTransforms(scene, pose)[size_t(&instance - scene.instances.data())];
  const Mesh& mesh = scene.meshes[instance.mesh];
  std::vector<vec3> positions = mesh.positions;
  if (const auto& d = mesh.deformation) {
    std::vector<mat4> joints;
    if (d->skin >= 0) joints = jointMatrices(scene.rig.skins[size_t(d->skin)], pose);
    std::vector<float> weights;
    if (d->weightsNode >= 0) weights = pose.weights[size_t(d->weightsNode)];
    positions = deform(*d, joints, weights).positions;
  }
  std::vector<dvec3> vertices;
  for (const vec3& p : positions) vertices.emplace_back(toWorld * glm::dvec4(p, 1));
  return vertices;
}

void expectSameMotion(const Scene& again, const Scene& scene) {
  size_t instances = 0;
  for (const Instance& instance : scene.instances) {
    const Instance* same = partOf(again, instance.part);
    ASSERT_TRUE(same) << scene.nodes[instance.node].path;
    for (const double seconds : {0.0, 0.3, 0.6}) {
      const auto a = verticesAt(again, *same, seconds), b = verticesAt(scene, instance, seconds);
      ASSERT_EQ(a.size(), b.size());
      double off = 0;
      for (size_t v = 0; v < a.size(); ++v) off = std::max(off, glm::length(a[v] - b[v]));
      EXPECT_LT(off, 1e-5) << scene.nodes[instance.node].path << " at " << seconds;
    }
    ++instances;
  }
  EXPECT_EQ(again.instances.size(), instances);
}

dmat4 placement() {
  return glm::rotate(glm::translate(dmat4(1), dvec3(3, -2, 1)), 0.7, dvec3(0, 0, 1)) *
         glm::scale(dmat4(1), dvec3(1, 2, 0.5));
}

TEST(Export, PlacedCopiesOfDeformedMeshesMoveAsTheOriginals) {
  for (const char* model : {"skinned.glb", "static_skin.glb", "morphed.glb"}) {
    Scene scene = load(models::modelPath(model).string());
    const auto deformed = std::ranges::find_if(
        scene.instances, [&](const Instance& i) { return scene.meshes[i.mesh].deformation != nullptr; });
    ASSERT_NE(deformed, scene.instances.end());
    const uint32_t mesh = deformed->mesh, material = deformed->material;
    addInstance(scene, mesh, material, placement(), "copy");
    addInstance(scene, mesh, material, glm::translate(dmat4(1), dvec3(0, 5, 0)), "other");
    EXPECT_GT(
        glm::length(verticesAt(scene, scene.instances.back(), 0)[0] - verticesAt(scene, scene.instances[0], 0)[0]), 1);
    const Scene again = exported(scene);
    expectSameMotion(again, scene);
    expectSameMotion(exported(again), scene);
  }
}

// Copies of a skinned mesh are placed in the file's frame (glTF 2.0, 3.7.3.3): their animated node does not move them.
// The primitive without joints follows it.
TEST(Export, CopiesOfSkinnedMeshesStayInTheirPlaces) {
  test::GltfBuilder file = test::triangleFile();
  const json rigid = file.primitive();
  json& skinned = file.primitive()["attributes"];
  skinned["JOINTS_0"] = file.accessor(file.view(std::vector<uint8_t>(12)), test::kUnsignedByte, "VEC4", 3);
  skinned["WEIGHTS_0"] = file.vectors(std::vector<vec4>(3, vec4(1, 0, 0, 0)));
  file.root["meshes"][0]["primitives"].push_back(rigid);
  const int copies = file.positions({{10, 0, 0}, {20, 0, 0}});
  file.root["nodes"][0] = {{"name", "n"}, {"mesh", 0}, {"skin", 0}, {"translation", {0, 100, 0}}};
  file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", copies}};
  file.add("skins", {{"joints", {file.node({{"name", "joint"}, {"translation", {0, 0, 1000}}})}}});
  const int times = file.accessor(file.view(std::vector<float>{0, 1}), test::kFloat, "SCALAR", 2);
  const int moves = file.positions({{0, 0, 0}, {0, 0, 500}});
  const auto channel = [](int node) -> json {
    return {{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}};
  };
  file.add("animations",
           {{"samplers", {{{"input", times}, {"output", moves}}}}, {"channels", {channel(0), channel(1)}}});
  const Scene scene = file.load();
  ASSERT_EQ(scene.instances.size(), 4u);
  const Scene again = exported(scene);
  expectSameMotion(again, scene);
  for (const Scene* shown : {&scene, &again})
    for (const auto& [name, place] : {std::pair("/n/instance0/primitive0", dvec3(10, 0, 150)),
                                      {"/n/instance1/primitive0", dvec3(20, 0, 150)},
                                      {"/n/instance1/primitive1", dvec3(20, 0, 150)}}) {
      const Instance* instance = partOf(*shown, hash32(name));
      ASSERT_TRUE(instance) << name;
      const dvec3 vertex(toGltfFromWorld() * glm::dvec4(verticesAt(*shown, *instance, 0.3)[0], 1));
      EXPECT_LT(glm::length(vertex - place), 1e-4) << name << ' ' << vertex.x << ' ' << vertex.y << ' ' << vertex.z;
    }
}

// A skin requires a rig. The copies are rigid or have the skin, and an edit moves one of them.
TEST(Export, MovedCopiesOfStillNodesKeepTheirIds) {
  for (const bool isSkinned : {false, true}) {
    GltfBuilder file = triangleFile();
    file.root["nodes"][0]["name"] = "n";
    file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", file.positions({{10, 0, 0}, {20, 0, 0}})}};
    file.add("skins", {{"joints", {file.node({{"name", "joint"}, {"translation", {0, 0, 1}}})}}});
    if (isSkinned) {
      json& attributes = file.primitive()["attributes"];
      attributes["JOINTS_0"] = file.accessor(file.view(std::vector<uint8_t>(12)), test::kUnsignedByte, "VEC4", 3);
      attributes["WEIGHTS_0"] = file.vectors(std::vector<vec4>(3, vec4(1, 0, 0, 0)));
      file.root["nodes"][0]["skin"] = 0;
    }
    Scene scene = file.load();
    ASSERT_EQ(scene.instances.size(), 2u);
    setTransform(scene, 1, placement());
    const Scene again = exported(scene);
    for (const Instance& instance : scene.instances) {
      const std::string path = fmt::format("/n/instance{}", instance.copy);
      const Instance* same = partOf(again, hash32(path));
      ASSERT_TRUE(same) << path;
      EXPECT_EQ(again.nodes[same->node].path, path);
      EXPECT_EQ(same->id, instance.id);
    }
    expectSameMotion(again, scene);
  }
}

TEST(Export, SkinsThatWereMovedStayThere) {
  Scene scene = load(models::modelPath("skinned.glb").string());
  for (uint32_t i = 0; i < scene.instances.size(); ++i) setTransform(scene, i, placement());
  expectSameMotion(exported(scene), scene);
}

TEST(Export, MovedInstancesOfAnimatedScenesKeepTheirPaths) {
  Scene scene = load(models::modelPath("morphed.glb").string());
  ASSERT_TRUE(scene.rig.isAnimated());
  for (uint32_t i = 0; i < scene.instances.size(); ++i) setTransform(scene, i, placement());
  const Scene again = exported(scene);
  EXPECT_EQ(again.nodes.size(), scene.nodes.size());
  expectSameMotion(again, scene);
}

// glTF's colors of lights are at most 1; brighter ones have the same product with the intensity.
TEST(Export, ColorsOfLightsAreInRange) {
  Scene scene = load("builtin:boxes");
  addLight(scene, {.color = {1.5f, 0.25f, 3}, .intensity = 7});
  const Light light = exported(scene).lights.back();
  EXPECT_LE(light.color.z, 1);
  EXPECT_EQ(light.color * light.intensity, vec3(10.5f, 1.75f, 21));
}

// A triangle that moves has a child with the same mesh, which stays where it is.
TEST(Export, MovedNodesWithChildrenKeepTheirPaths) {
  const app::Folder folder;
  test::GltfBuilder file = test::triangleFile();
  const int mesh = file.root["nodes"][0]["mesh"];
  file.root["nodes"][0]["name"] = "parent";
  file.root["nodes"][0]["children"] = {
      file.add("nodes", {{"name", "child"}, {"mesh", mesh}, {"translation", {0, 2, 0}}})};
  writeFile(folder.at("family.glb"), file.glb());
  Scene scene = load(folder.at("family.glb"));
  ASSERT_EQ(scene.instances.size(), 2u);
  setTransform(scene, 0, placement());
  expectSame(exported(scene), scene);
}

// A node without an inverse can have no child elsewhere, so what an edit has moved out of it becomes a root: a child,
// or a primitive of the node's own mesh.
TEST(Export, WhatLeavesFlatNodesStaysInItsPlace) {
  const app::Folder folder;
  for (const bool child : {true, false}) {
    test::GltfBuilder file = test::triangleFile();
    json& node = file.root["nodes"][0];
    const int mesh = node["mesh"];
    node["scale"] = {1, 0, 1};
    if (child) {
      node.erase("mesh");
      node["children"] = {1};
      file.add("nodes", {{"name", "child"}, {"mesh", mesh}});
    } else {
      json& primitives = file.root["meshes"][mesh]["primitives"];
      primitives.push_back(json(primitives[0]));
    }
    writeFile(folder.at("flat.glb"), file.glb());
    Scene scene = load(folder.at("flat.glb"));
    setTransform(scene, static_cast<uint32_t>(scene.instances.size() - 1), placement());
    const Scene again = exported(scene);
    ASSERT_EQ(again.instances.size(), scene.instances.size());
    const auto isMoved = [&](const Instance& i) { return glm::determinant(i.toWorld) != 0; };
    const auto moved = std::ranges::find_if(again.instances, isMoved);
    ASSERT_NE(moved, again.instances.end());
    expectNear(moved->toWorld, placement());
    EXPECT_EQ(std::ranges::count_if(again.instances, isMoved), 1);
  }
}

// Parts of an object in several places are nodes below the object's, also in a scene with skins, so that they are one
// group of ids.
TEST(Export, ScatteredPartsAreBelowTheirObject) {
  const Mesh plain = load("builtin:boxes").meshes[0];
  for (const char* model : {"textured.glb", "skinned.glb"}) {
    Scene scene = load(models::modelPath(model).string());
    const uint32_t mesh = addMesh(scene, plain);
    const std::vector<ObjectPart> parts{{mesh, 0, placement()}, {mesh, 0, glm::translate(dmat4(1), dvec3(0, 5, 0))}};
    const uint32_t added = addObject(scene, parts, "toy").front();
    const Scene again = exported(scene, "out.glb", {.ids = {.nodes = {"/toy"}}});
    std::vector<std::string> paths;
    for (const Instance& instance : again.instances) {
      if (instance.id != scene.instances[added].id) continue;
      paths.push_back(again.nodes[instance.node].path);
      expectNear(instance.toWorld, parts[paths.size() - 1].toWorld);
    }
    ASSERT_EQ(paths.size(), 2u) << model;
    EXPECT_EQ(paths[0], "/toy");
    EXPECT_THAT(paths[1], testing::StartsWith("/toy/"));
  }
}

// A baked pose is the rest pose, without animations.
TEST(Export, PosesAreBaked) {
  for (const char* model : {"skinned.glb", "morphed.glb"}) {
    Scene scene = load(models::modelPath(model).string());
    const Pose pose = poseAt(scene, {.animations = {0}}, 0.3);
    std::map<uint32_t, std::vector<dvec3>> expected;  // by part
    double moved = 0;
    for (const Instance& instance : scene.instances) {
      expected[instance.part] = verticesAt(scene, instance, 0.3);
      const std::vector<dvec3> atRest = verticesAt(scene, instance, 0);
      for (size_t v = 0; v < atRest.size(); ++v)
        moved = std::max(moved, glm::length(atRest[v] - expected[instance.part][v]));
    }
    EXPECT_GT(moved, 0.05) << model;
    bakePose(scene, pose);
    for (const char* name : {"out.glb", "out.ply"}) {
      const Scene again = exported(scene, name);
      EXPECT_FALSE(again.rig.isAnimated());
      if (name == std::string("out.ply")) {
        Bounds bounds, wanted = worldBounds(again);
        for (const auto& [part, vertices] : expected)
          for (const dvec3& v : vertices) bounds.min = glm::min(bounds.min, v), bounds.max = glm::max(bounds.max, v);
        EXPECT_LT(glm::length(bounds.min - wanted.min) + glm::length(bounds.max - wanted.max), 1e-5) << model;
        continue;
      }
      for (const auto& [part, vertices] : expected) {
        const Instance* same = partOf(again, part);
        ASSERT_TRUE(same);
        const Mesh& mesh = again.meshes[same->mesh];
        ASSERT_EQ(mesh.positions.size(), vertices.size());
        double off = 0;  // of the vertices at rest
        for (size_t v = 0; v < vertices.size(); ++v)
          off = std::max(off, glm::length(dvec3(same->toWorld * glm::dvec4(mesh.positions[v], 1)) - vertices[v]));
        EXPECT_LT(off, 1e-5) << model;
      }
    }
  }
}

// A channel of an animation of one second, linear from one value to the other.
void animate(test::GltfBuilder& file, const test::json& target, std::vector<float> from, const std::vector<float>& to) {
  const char* type = from.size() == 1 ? "SCALAR" : "VEC3";
  from.insert(from.end(), to.begin(), to.end());
  const int input = file.accessor(file.view(std::vector<float>{0, 1}), test::kFloat, "SCALAR", 2);
  const int output = file.accessor(file.view(from), test::kFloat, type, 2);
  if (!file.root.contains("animations"))
    file.add("animations", {{"channels", test::json::array()}, {"samplers", test::json::array()}});
  test::json& animation = file.root["animations"][0];
  animation["channels"].push_back({{"sampler", animation["samplers"].size()}, {"target", target}});
  animation["samplers"].push_back({{"input", input}, {"output", output}});
}

test::json pointer(const std::string& path) {
  return {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", path}}}}}};
}

// The nodes of a .glb file by their names. Its first chunk is JSON (glTF 2.0, 4.4).
std::map<std::string, json> exportedNodes(const Scene& scene) {
  const app::Folder folder;
  exports::exportScene(scene, folder.at("out.glb"));
  const std::vector<std::byte> bytes = readFile(folder.at("out.glb"));
  uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  const auto* text = reinterpret_cast<const char*>(bytes.data()) + 20;
  const json document = json::parse(text, text + length);
  std::map<std::string, json> nodes;
  for (const json& node : document["nodes"]) nodes[node["name"]] = node;
  return nodes;
}

dvec3 vectorOf(const json& values) {
  return {values[0], values[1], values[2]};
}

// The signs of the scale that an object's own frame does not contain, by node or copy.
std::map<std::string, dvec3> scaleSigns(const Scene& scene) {
  std::map<std::string, dvec3> signs;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const std::string copy = instance.copy < 0 ? "" : fmt::format("/instance{}", instance.copy);
    signs[scene.nodes[instance.node].path + copy] = ObjectFrames(scene).scaleSigns({&i, 1});
  }
  return signs;
}

// Nodes `flat`, `mirrored` and `turned` with a matrix, and copies of `copied`, whose scales a matrix cannot state: glTF
// has no matrices that scale an axis to 0 (3.5.3), and a matrix does not state which axes it mirrors.
GltfBuilder scaledFile() {
  GltfBuilder file = triangleFile();
  const double h = std::sqrt(0.5);
  file.root["nodes"][0] = {{"name", "flat"}, {"mesh", 0}, {"rotation", {h, 0, 0, h}}, {"scale", {1, 0, 2}}};
  file.node({{"name", "mirrored"}, {"mesh", 0}, {"translation", {1, 2, 3}}, {"scale", {1, -1, 1}}});
  file.node({{"name", "turned"}, {"mesh", 0}, {"matrix", {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1}}});
  const int copied = file.node({{"name", "copied"}, {"mesh", 0}, {"scale", {2, 2, 2}}});
  const float f = std::sqrt(0.5f);
  file.root["nodes"][size_t(copied)]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", file.positions({{10, 0, 0}, {20, 0, 0}, {30, 0, 0}})},
      {"ROTATION", file.vectors(std::vector<vec4>{{0, 0, f, f}, {0, 0, f, f}, {0, 0, 0, 1}})},
      {"SCALE", file.positions({{1, -1, -3}, {1, 0, 1}, {0, 0, 0}})}};
  return file;
}

void expectScales(const std::map<std::string, json>& nodes) {
  for (const auto& [name, scale] : {std::pair("flat", dvec3(1, 0, 2)),
                                    {"mirrored", dvec3(1, -1, 1)},
                                    {"instance0", dvec3(1, -1, -3)},
                                    {"instance1", dvec3(1, 0, 1)},
                                    {"instance2", dvec3(0, 0, 0)}}) {
    const json& node = nodes.at(name);
    EXPECT_FALSE(node.contains("matrix")) << name;
    ASSERT_TRUE(node.contains("scale")) << name;
    EXPECT_LT(glm::length(vectorOf(node["scale"]) - scale), 1e-12) << name;
  }
}

TEST(Export, NodesAndCopiesKeepTheirScales) {
  for (const bool isAnimated : {false, true}) {
    GltfBuilder file = scaledFile();
    if (isAnimated) animate(file, {{"node", 3}, {"path", "translation"}}, {0, 0, 0}, {4, 0, 0});
    const Scene scene = file.load();
    const std::map<std::string, json> nodes = exportedNodes(scene);
    expectScales(nodes);
    EXPECT_TRUE(nodes.at("turned").contains("matrix"));
    const Scene again = exported(scene);
    EXPECT_EQ(scaleSigns(again), scaleSigns(scene));
    ASSERT_EQ(again.instances.size(), scene.instances.size());
    for (size_t i = 0; i < again.instances.size(); ++i)
      expectNear(again.instances[i].toWorld, scene.instances[i].toWorld);
  }
}

// An edit moves the node `mirrored` and a copy, and makes the node `turned` flat.
TEST(Export, MovedNodesKeepTheirScales) {
  for (const bool isAnimated : {false, true}) {
    GltfBuilder file = scaledFile();
    if (isAnimated) animate(file, {{"node", 0}, {"path", "translation"}}, {0, 0, 0}, {4, 0, 0});
    Scene scene = file.load();
    const auto instanceAt = [&](const char* path) {
      return static_cast<uint32_t>(partOf(scene, hash32(path)) - scene.instances.data());
    };
    const dmat4 moved = glm::rotate(dmat4(1), 0.7, dvec3(0, 0, 1));
    for (const char* path : {"/mirrored", "/copied/instance0"})
      setTransform(scene, instanceAt(path), moved * scene.instances[instanceAt(path)].toWorld);
    setTransform(scene, instanceAt("/turned"), glm::scale(moved, dvec3(3, 0, 3)));
    const std::map<std::string, json> nodes = exportedNodes(scene);
    expectScales(nodes);
    for (const auto& [name, node] : nodes) EXPECT_FALSE(node.contains("mesh") && node.contains("matrix")) << name;
    const Scene again = exported(scene);
    EXPECT_EQ(scaleSigns(again)["/mirrored"], dvec3(1, -1, 1));
    EXPECT_EQ(scaleSigns(again)["/copied/instance0"], dvec3(1, -1, -1));
    for (const char* path : {"/mirrored", "/copied/instance0"})
      expectNear(partOf(again, hash32(path))->toWorld, scene.instances[instanceAt(path)].toWorld);
    const auto isFlattened = [&](const Instance& i) {
      const dmat4 error = i.toWorld - scene.instances[instanceAt("/turned")].toWorld;
      return std::ranges::all_of(std::array{0, 1, 2, 3}, [&](int c) { return glm::length(error[c]) < 1e-12; });
    };
    EXPECT_EQ(std::ranges::count_if(again.instances, isFlattened), 1);
  }
}

// Copies of a flat node are not moved, so they stay below it.
TEST(Export, CopiesStayBelowFlatNodes) {
  GltfBuilder file = scaledFile();
  file.root["nodes"][3]["scale"] = {1, 0, 1};
  const Scene scene = file.load(), again = exported(scene);
  for (const char* path : {"/copied/instance0", "/copied/instance1", "/copied/instance2"}) {
    const Instance *before = partOf(scene, hash32(path)), *after = partOf(again, hash32(path));
    ASSERT_TRUE(before && after) << path;
    EXPECT_EQ(again.nodes[after->node].path, path);
    expectNear(after->toWorld, before->toWorld);
  }
  expectScales(exportedNodes(scene));
}

// At a quarter of a second: nodes, a material, a light, and a node that is not visible.
TEST(Export, BakedValuesAreThoseOfTheTime) {
  const app::Folder folder;
  test::GltfBuilder file = test::triangleFile();
  const int mesh = file.root["nodes"][0]["mesh"];
  file.root["nodes"][0]["name"] = "parent";
  file.primitive()["material"] = file.add("materials", {{"name", "paint"}});
  const int child = file.add("nodes", {{"name", "child"}, {"mesh", mesh}, {"translation", {0, 2, 0}}});
  file.root["nodes"][0]["children"] = {child};
  file.use("KHR_node_visibility");
  const int hidden =
      file.node({{"name", "hidden"}, {"mesh", mesh}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  file.use("KHR_lights_punctual");
  file.use("KHR_animation_pointer");
  file.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 1}}};
  file.node({{"name", "lamp"}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  animate(file, {{"node", 0}, {"path", "translation"}}, {0, 0, 0}, {4, 0, 0});
  animate(file, {{"node", child}, {"path", "translation"}}, {0, 2, 0}, {0, 2, 8});
  animate(file, pointer("/materials/0/pbrMetallicRoughness/roughnessFactor"), {0.2f}, {0.6f});
  animate(file, pointer("/extensions/KHR_lights_punctual/lights/0/intensity"), {1}, {5});
  writeFile(folder.at("moving.glb"), file.glb());
  Scene scene = load(folder.at("moving.glb"));
  const uint32_t hiddenId = scene.nodes[size_t(hidden)].id;
  bakePose(scene, poseAt(scene, {.animations = {0}}, 0.25));
  const Scene again = exported(scene);
  EXPECT_TRUE(again.rig.empty());
  ASSERT_EQ(again.instances.size(), 2u);
  for (const Instance& instance : again.instances) {
    EXPECT_NE(instance.id, hiddenId);
    const bool isChild = again.nodes[instance.node].path == "/parent/child";
    EXPECT_EQ(again.nodes[instance.node].path, isChild ? "/parent/child" : "/parent");
    const dvec3 place(toGltfFromWorld() * instance.toWorld[3]);
    EXPECT_LT(glm::length(place - (isChild ? dvec3(1, 2, 2) : dvec3(1, 0, 0))), 1e-6);
  }
  EXPECT_FLOAT_EQ(again.materials[again.instances[0].material].data.roughness, 0.3f);
  ASSERT_EQ(again.lights.size(), 1u);
  EXPECT_FLOAT_EQ(again.lights[0].intensity, 2);
}

json hiddenNode(json node) {
  node["extensions"]["KHR_node_visibility"]["visible"] = false;
  return node;
}

const Instance* findInstance(const Scene& scene, const std::string& path) {
  for (const Instance& instance : scene.instances)
    if (!instance.removed && scene.nodes[instance.node].path == path) return &instance;
  return nullptr;
}

TEST(Export, BakedNodesKeepTheirScales) {
  GltfBuilder file = scaledFile();
  for (const int node : {0, 1, 3}) animate(file, {{"node", node}, {"path", "translation"}}, {0, 0, 0}, {4, 0, 8});
  Scene scene = file.load();
  const std::map<std::string, dvec3> signs = scaleSigns(scene);
  const Pose pose = poseAt(scene, {.animations = {0}}, 0.25);
  const std::vector<dmat4> places = instanceTransforms(scene, pose);
  bakePose(scene, pose);
  const std::map<std::string, json> nodes = exportedNodes(scene);
  expectScales(nodes);
  EXPECT_EQ(vectorOf(nodes.at("mirrored")["translation"]), dvec3(1, 0, 2));
  const Scene again = exported(scene);
  EXPECT_EQ(scaleSigns(again), signs);
  ASSERT_EQ(again.instances.size(), places.size());
  for (size_t i = 0; i < places.size(); ++i) expectNear(again.instances[i].toWorld, places[i]);
}

// A hidden triangle whose child has a mesh or none, below a visible node, and a hidden node without a mesh that has a
// child with one.
TEST(Export, HiddenNodesWithChildrenStayHidden) {
  for (const bool hasMesh : {false, true}) {
    GltfBuilder file = triangleFile();
    file.use("KHR_node_visibility");
    const int child = file.add("nodes", {{"name", "child"}});
    if (hasMesh) file.root["nodes"][size_t(child)]["mesh"] = 0;
    const int hidden = file.add("nodes", hiddenNode({{"name", "hidden"}, {"mesh", 0}, {"children", {child}}}));
    file.node({{"name", "parent"}, {"children", {hidden}}});
    const int below = file.add("nodes", {{"name", "below"}, {"mesh", 0}});
    file.node(hiddenNode({{"name", "group"}, {"children", {below}}}));
    const Scene scene = file.load();
    const Scene again = exported(scene);
    expectSame(again, scene);
    EXPECT_EQ(again.nodes.size(), scene.nodes.size());
    for (const char* path : {"/parent/hidden", "/group/below"}) {
      ASSERT_TRUE(findInstance(again, path)) << path;
      EXPECT_TRUE(findInstance(again, path)->hidden) << path;
    }
    // The extension is at the nodes of the file that have it, so that nodes that are added later are visible.
    for (size_t i = 0; i < again.fileNodes.size(); ++i)
      EXPECT_EQ(again.fileNodes[i].visible, again.nodes[i].name != "hidden" && again.nodes[i].name != "group");
  }
}

// An edit moves one of two primitives of a hidden node; the other one stays at the node. An animation requires a rig.
TEST(Export, HiddenInstancesThatWereMovedStayHidden) {
  for (const bool isAnimated : {false, true}) {
    GltfBuilder file = triangleFile();
    file.use("KHR_node_visibility");
    file.root["meshes"][0]["primitives"].push_back(json(file.primitive()));
    const int child = file.add("nodes", {{"name", "child"}, {"mesh", 0}});
    file.node(hiddenNode({{"name", "hidden"}, {"mesh", 0}, {"children", {child}}}));
    if (isAnimated) animate(file, {{"node", 0}, {"path", "translation"}}, {0, 0, 0}, {4, 0, 0});
    Scene scene = file.load();
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
      if (scene.nodes[scene.instances[i].node].path == "/hidden" && scene.instances[i].primitive == 1)
        setTransform(scene, i, placement());
    const Scene again = exported(scene);
    EXPECT_TRUE(findInstance(again, "/hidden"));
    EXPECT_EQ(again.instances.size(), 6u);
    EXPECT_EQ(std::ranges::count(again.instances, true, &Instance::hidden), 4) << isAnimated;
  }
}

// Lights of a node that is hidden at rest, which an animation shows or does not show.
TEST(Export, HiddenLightsStayAtTheirNodes) {
  for (const bool isAnimated : {false, true}) {
    GltfBuilder file = triangleFile();
    for (const char* extension : {"KHR_node_visibility", "KHR_lights_punctual", "KHR_animation_pointer"})
      file.use(extension);
    file.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 3}}};
    const int lamp = file.add("nodes", {{"name", "lamp"},
                                        {"translation", {0, 2, 0}},
                                        {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
                                        {"extras", {{"areaLight", {{"type", "rect"}, {"intensity", 5}}}}}});
    const int parent = file.node(hiddenNode({{"name", "parent"}, {"children", {lamp}}}));
    if (isAnimated) {
      animate(file, {{"node", parent}, {"path", "translation"}}, {0, 0, 0}, {4, 0, 0});
      const int steps = file.accessor(file.view(std::vector<uint8_t>{0, 1}), test::kUnsignedByte, "SCALAR", 2);
      json& animation = file.root["animations"][0];
      animation["samplers"].push_back(
          {{"input", animation["samplers"][0]["input"]}, {"output", steps}, {"interpolation", "STEP"}});
      animation["channels"].push_back(
          {{"sampler", 1},
           {"target", pointer(fmt::format("/nodes/{}/extensions/KHR_node_visibility/visible", parent))}});
    }
    const Scene scene = file.load();
    ASSERT_EQ(scene.lights.size(), 2u);
    const Scene again = exported(scene);
    expectSame(again, scene);
    for (const Light& light : again.lights) {
      EXPECT_EQ(again.nodes.at(size_t(light.node)).path, "/parent/lamp");
      EXPECT_TRUE(light.hidden);
    }
    if (!isAnimated) continue;
    for (const double seconds : {0.5, 1.0})
      for (const Light& light : posedLights(again, poseAt(again, {.animations = {0}, .loop = false}, seconds))) {
        EXPECT_EQ(light.removed, seconds < 1);
        EXPECT_LT(glm::length(dvec3(toGltfFromWorld() * glm::dvec4(light.position, 1)) - dvec3(4 * seconds, 2, 0)),
                  1e-6);
      }
  }
}

// The JSON of an exported .glb file.
json exportedJson(const Scene& scene) {
  const std::vector<std::byte> bytes = exports::encodeGlb(scene);
  uint32_t length = 0;
  std::memcpy(&length, &bytes[12], sizeof length);
  const auto* text = reinterpret_cast<const char*>(&bytes[20]);
  return json::parse(text, text + length);
}

// One animation has a channel that is not supported, and one animates only a light that an edit removes. The third one
// moves the triangle by 2 m within a second, and keeps its index.
TEST(Export, AnimationsKeepTheirIndices) {
  GltfBuilder file = triangleFile();
  file.use("KHR_lights_punctual");
  file.use("KHR_animation_pointer");
  file.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  file.node({{"name", "lamp"}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  std::vector<json> animations;
  const auto add = [&](const char* name, const json& target, const std::vector<float>& from,
                       const std::vector<float>& to) {
    file.root.erase("animations");
    animate(file, target, from, to);
    animations.push_back(file.root["animations"][0]);
    animations.back()["name"] = name;
  };
  add("unsupported", pointer("/materials/0/extras/unknown"), {0}, {1});
  add("removed", pointer("/extensions/KHR_lights_punctual/lights/0/intensity"), {0}, {1});
  add("moves", {{"node", 0}, {"path", "translation"}}, {0, 0, 0}, {2, 0, 0});
  file.add("materials", {{"name", "paint"}});
  file.root["animations"] = animations;
  Scene scene = file.load();
  removeLight(scene, 0);
  for (const json& animation : exportedJson(scene)["animations"]) EXPECT_FALSE(animation["channels"].empty());
  const Scene again = exported(scene);
  ASSERT_EQ(again.rig.animations.size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(again.rig.animations[i].name, scene.rig.animations[i].name);
  for (uint32_t i = 0; i < 3; ++i) {
    const Pose pose = poseAt(again, {.animations = {i}, .loop = false}, 0.5);
    EXPECT_EQ(pose.world[0][3].x, i == 2 ? 1 : 0) << i;
  }
}

std::vector<std::string> pathsOf(const Scene& scene) {
  std::vector<std::string> paths;
  for (const Node& node : scene.nodes) paths.push_back(node.path);
  return paths;
}

// The loaded scene is the file's second one. The node of the first one is unnamed in the exported file, where its
// default name would be that of the loaded node.
TEST(Export, NodesOfOtherScenesAreNotInTheScene) {
  GltfBuilder file = triangleFile();
  file.root["nodes"][0]["name"] = "other";
  const int loaded = file.add("nodes", {{"name", "node0"}, {"mesh", 0}, {"translation", {0, 2, 0}}});
  file.root["scenes"].push_back({{"nodes", {loaded}}});
  file.root["scene"] = 1;
  animate(file, {{"node", loaded}, {"path", "translation"}}, {0, 2, 0}, {4, 2, 0});
  const Scene scene = file.load(), again = exported(scene);
  EXPECT_THAT(pathsOf(again), testing::ElementsAre("/node0"));
  expectSame(again, scene);
  expectSameMotion(again, scene);
  file.root["scenes"][1].erase("nodes");
  EXPECT_FALSE(exportedJson(file.load())["scenes"][0].contains("nodes"));
}

// glTF requires joints in the scene of their mesh. This file's joint is in none, is unnamed, and comes first.
TEST(Export, JointsOutsideTheSceneChangeNoPaths) {
  GltfBuilder file = triangleFile();
  json& nodes = file.root["nodes"];
  nodes[0]["name"] = "node0";
  nodes[0]["skin"] = file.add("skins", {{"joints", {0}}});
  nodes.insert(nodes.begin(), json{{"translation", {0, 0, 1}}});
  file.root["scenes"][0]["nodes"] = {1};
  const std::vector<uint8_t> joints(12);
  file.primitive()["attributes"]["JOINTS_0"] = file.accessor(file.view(joints), test::kUnsignedByte, "VEC4", 3);
  file.primitive()["attributes"]["WEIGHTS_0"] = file.vectors(std::vector<vec4>(3, {1, 0, 0, 0}));
  const Scene scene = file.load(), again = exported(scene);
  EXPECT_THAT(pathsOf(again), testing::ElementsAre("/node0", "/node0#2"));
  expectSame(again, scene);
}

// A rotation by r of coordinates that are scaled by (0, 0.5): u' = 0.5 sin(r) v, and v' = 0.5 cos(r) v.
TEST(Export, TextureTransformsMayBeFlat) {
  for (const float angle : {1.2f, -2.5f}) {
    GltfBuilder file = triangleFile();
    const app::Folder folder;
    writeFile(folder.at("a.png"), output::encodePng(output::Picture{1, 1, {128, 128, 255, 255}}));
    file.add("images", {{"uri", "a.png"}});
    file.add("textures", {{"source", 0}});
    json texture{{"index", 0}};
    texture["extensions"]["KHR_texture_transform"] = {{"scale", {0, 0.5}}, {"rotation", angle}, {"offset", {0.25, 1}}};
    file.primitive()["material"] = file.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", texture}}}});
    writeFile(folder.at("in.glb"), file.glb());
    const Scene again = exported(load(folder.at("in.glb")));
    const auto& transform = again.materials[again.instances[0].material].data.transforms[shared::kTextureBaseColor];
    EXPECT_LT(glm::length(transform.row0 - vec3(0, 0.5f * std::sin(angle), 0.25f)), 1e-6f) << angle;
    EXPECT_LT(glm::length(transform.row1 - vec3(0, 0.5f * std::cos(angle), 1)), 1e-6f) << angle;
  }
}

// KHR_lights_punctual: the outer angle is above 0 and at most pi / 2, and the inner angle is below the outer one.
TEST(Export, ConesOfSpotLightsAreInRange) {
  const std::vector<std::pair<double, double>> cones{{0.5, 0.5}, {0.7, 0.5}, {0.1, 0.5}, {1.5708, 1.5708}, {0, 0}};
  GltfBuilder file = triangleFile();
  file.use("KHR_lights_punctual");
  json& lights = file.root["extensions"]["KHR_lights_punctual"]["lights"];
  for (const auto& [inner, outer] : cones) {
    lights.push_back({{"type", "spot"}, {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}});
    file.node({{"extensions", {{"KHR_lights_punctual", {{"light", lights.size() - 1}}}}}});
  }
  const Scene scene = file.load(), again = exported(scene);
  const json written = exportedJson(scene);
  for (size_t i = 0; i < cones.size(); ++i) {
    const json& spot = written["extensions"]["KHR_lights_punctual"]["lights"][i]["spot"];
    EXPECT_GE(spot["innerConeAngle"], 0);
    EXPECT_LT(spot["innerConeAngle"], spot["outerConeAngle"]);
    EXPECT_LE(spot["outerConeAngle"], std::acos(0.0));
    const auto& [inner, outer] = cones[i];
    EXPECT_NEAR(again.lights[i].innerCone, std::min(inner, outer), 4e-6);
    EXPECT_NEAR(again.lights[i].outerCone, outer, 4e-6);
  }
  EXPECT_EQ(again.lights[2].innerCone, scene.lights[2].innerCone);
  EXPECT_EQ(again.lights[2].outerCone, scene.lights[2].outerCone);
}

// A skin far from the origin has vertices relative to a point near it.
TEST(Export, PlacedSkinsMayBeFarAway) {
  const app::Folder folder;
  const models::Bytes bytes = models::skinnedModel(dvec3(2e7, 0, 0));
  writeFile(folder.at("far.glb"), bytes);
  Scene scene = load(folder.at("far.glb"));
  addInstance(scene, scene.instances[0].mesh, scene.instances[0].material, placement(), "copy");
  const Scene again = exported(scene);
  const auto a = verticesAt(again, *partOf(again, scene.instances.back().part), 0.3);
  const auto b = verticesAt(scene, scene.instances.back(), 0.3);
  for (size_t v = 0; v < a.size(); ++v) EXPECT_LT(glm::length(a[v] - b[v]), 1e-4);
}

TEST(Export, GeometryIsWrittenToObjAndPly) {
  const Scene scene = load(models::modelPath("textured.glb").string());
  const Bounds bounds = worldBounds(scene);
  for (const char* name : {"out.obj", "out.ply"}) {
    const Scene again = exported(scene, name);
    EXPECT_EQ(again.triangleCount(), scene.triangleCount()) << name;
    EXPECT_LT(glm::length(worldBounds(again).min - bounds.min), 1e-5) << name;
    EXPECT_LT(glm::length(worldBounds(again).max - bounds.max), 1e-5) << name;
  }
}

// MTL has -clamp on for both directions, and repeats a texture otherwise.
TEST(Export, ObjFilesWarnOfTexturesThatRepeatInstead) {
  Scene scene = load(models::modelPath("textured.glb").string());
  const auto floor = std::ranges::find_if(scene.materials, [](const Material& material) {
    return material.slots[shared::kTextureBaseColor].texture >= 0 &&
           material.data.transforms[shared::kTextureBaseColor].row0.y == 0;
  });
  ASSERT_NE(floor, scene.materials.end());
  const auto exportedWith = [&](Wrap wrapU, Wrap wrapV) {
    for (Material& material : scene.materials)
      for (TextureSlot& slot : material.slots) slot.sampler.wrapU = slot.sampler.wrapV = Wrap::Repeat;
    Sampler& sampler = floor->slots[shared::kTextureBaseColor].sampler;
    sampler.wrapU = wrapU, sampler.wrapV = wrapV;
    std::vector<std::string> warnings;
    const WarningCapture capture(warnings);
    const std::string library = exports::encodeMtl(scene, "out").text;
    return std::pair(fmt::format("{}", fmt::join(warnings, "\n")), library.find("-clamp on") != library.npos);
  };
  EXPECT_THAT(exportedWith(Wrap::Repeat, Wrap::Repeat).first, Not(HasSubstr("repeats")));
  EXPECT_FALSE(exportedWith(Wrap::Repeat, Wrap::Repeat).second);
  EXPECT_THAT(exportedWith(Wrap::Clamp, Wrap::Clamp).first, Not(HasSubstr("repeats")));
  EXPECT_TRUE(exportedWith(Wrap::Clamp, Wrap::Clamp).second);
  for (const auto& [u, v] : {std::pair(Wrap::Mirror, Wrap::Mirror), std::pair(Wrap::Clamp, Wrap::Mirror),
                             std::pair(Wrap::Clamp, Wrap::Repeat), std::pair(Wrap::Repeat, Wrap::Clamp)}) {
    const auto [warnings, isClamped] = exportedWith(u, v);
    EXPECT_THAT(warnings, AllOf(HasSubstr(floor->name), HasSubstr("repeats in the OBJ file")));
    EXPECT_FALSE(isClamped);
  }
}

// The materials of an OBJ file are those that it can have: of a tiled floor with a normal map, a sphere with roughness
// and metalness, a masked card, and a card with an emissive image.
TEST(Export, ObjFilesHaveTexturesNextToThem) {
  const Scene scene = load(models::modelPath("textured.glb").string()), again = exported(scene, "out.obj");
  size_t textures = 0;
  for (const Material& material : scene.materials) {
    const auto same = std::ranges::find(again.materials, material.name, &Material::name);
    ASSERT_NE(same, again.materials.end()) << material.name;
    const auto &x = same->data, &y = material.data;
    EXPECT_EQ(vec3(x.baseColor), vec3(y.baseColor));
    EXPECT_EQ(x.emissive, y.emissive);
    for (const uint32_t slot : {shared::kTextureBaseColor, shared::kTextureMetallicRoughness, shared::kTextureNormal,
                                shared::kTextureEmissive}) {
      const bool isHeld = material.slots[slot].texture >= 0 && y.transforms[slot].row0.y == 0;  // MTL has no rotation
      ASSERT_EQ(same->slots[slot].texture >= 0, isHeld) << material.name << " " << slot;
      if (!isHeld) continue;
      ++textures;
      EXPECT_LT(glm::length(x.transforms[slot].row0 - y.transforms[slot].row0), 1e-6f);
      EXPECT_LT(glm::length(x.transforms[slot].row1 - y.transforms[slot].row1), 1e-6f);
      const Texture& a = again.textures[size_t(same->slots[slot].texture)];
      const Texture& b = scene.textures[size_t(material.slots[slot].texture)];
      ASSERT_EQ(a.width, b.width);
      ASSERT_EQ(a.height, b.height);
      EXPECT_EQ(a.srgb, b.srgb);
      const bool isMetal = slot == shared::kTextureMetallicRoughness;  // whose red channel has no meaning
      const bool hasAlpha = (y.flags & (shared::kMaterialBlended | shared::kMaterialMasked)) != 0;
      for (size_t i = 0; i < size_t{4} * a.width * a.height; ++i)
        if ((i % 4 < 3 || hasAlpha) && !(isMetal && i % 4 == 0)) {
          ASSERT_EQ(a.pixels.get()[i], b.pixels.get()[i]) << material.name << " " << slot << " at " << i;
        }
    }
  }
  EXPECT_GE(textures, 4u);
}

// A triangle at x = 0, at x = 3 and so on, with these names of materials and nodes, and the material's roughness 0.125,
// 0.25 and so on.
Scene triangles(const std::vector<std::string>& materials, const std::vector<std::string>& nodes) {
  Scene scene = triangleFile().load();
  removeInstance(scene, 0);
  for (uint32_t i = 0; i < materials.size(); ++i) {
    Material material{.name = materials[i]};
    material.data.roughness = 0.125f * float(i + 1);
    addInstance(scene, 0, addMaterial(scene, material), glm::translate(dmat4(1), dvec3(3 * i, 0, 0)), nodes[i]);
  }
  return scene;
}

TEST(Export, ObjKeepsMaterialsAndNodesOfAnyNamesApart) {
  const std::vector<std::vector<std::string>> names = {
      {"m", "m", "m#2"}, {"a\nb", "a b", "a b "}, {"m\\", "m_", "m"}, {"", "", " "}, {"m\nKd 1 1 1", "#", "-"}};
  for (const auto& materials : names)
    for (const std::vector<std::string>& nodes :
         {std::vector<std::string>{"a\nv 9 9 9", "b", "c"}, {"a\\", "b\r\nf 1 2 3", "c"}}) {
      const Scene scene = triangles(materials, nodes), again = exported(scene, "out.obj");
      ASSERT_EQ(again.triangleCount(), 3u);
      ASSERT_EQ(again.instances.size(), 3u);
      for (const Instance& instance : again.instances) {
        Bounds bounds;
        addBounds(again, instance, instance.toWorld, bounds);
        const double index = std::round(bounds.min.x / 3);
        EXPECT_EQ(again.materials[instance.material].data.roughness, 0.125 * (index + 1)) << materials[0];
      }
      EXPECT_EQ(worldBounds(again).max.x, worldBounds(scene).max.x);
    }
}

TEST(Export, ObjFindsItsMaterialsInFilesOfAnyName) {
  Scene scene = triangles({"red"}, {"a"});
  for (const char* name : {"a\nb.obj", "a\\.obj", "a\\b.obj", " a.obj"}) {
    const Scene again = exported(scene, name);
    ASSERT_EQ(again.materials.size(), 1u) << name;
    EXPECT_EQ(again.materials[0].data.roughness, 0.125f) << name;
  }
}

TEST(Export, PathsAndIdsStayIfEqualNamesWereRemoved) {
  Scene scene = triangles({"m", "m", "m", "m#2", "", ""}, {"x", "x", "x#2", "x", "y", "y"});
  for (const uint32_t i : {0u, 4u}) {  // the first "x" and the first "y"
    const uint32_t material = scene.instances[i].material;
    removeInstance(scene, i);
    removeMaterial(scene, material);
  }
  Scene again = exported(scene);
  for (int round = 0; round < 2; ++round, again = exported(again)) {
    std::vector<std::pair<std::string, uint32_t>> nodes, before;
    for (const Node& node : scene.nodes)
      if (!node.path.empty()) before.emplace_back(node.path, node.id);
    for (const Node& node : again.nodes) nodes.emplace_back(node.path, node.id);
    EXPECT_THAT(nodes, testing::UnorderedElementsAreArray(before));
    for (const Instance& instance : scene.instances) {
      if (instance.removed) continue;
      const Instance* same = partOf(again, instance.part);
      ASSERT_TRUE(same) << scene.nodes[instance.node].path;
      EXPECT_EQ(same->id, instance.id);
      EXPECT_EQ(again.materials[same->material].data.id, scene.materials[instance.material].data.id);
    }
  }
}

// Loaded materials of equal names have other numbers than added ones.
TEST(Export, IdsOfLoadedMaterialsStayIfEqualNamesWereRemoved) {
  GltfBuilder file = triangleFile();
  for (int i = 0; i < 3; ++i) file.add("materials", {{"name", "m"}});
  Scene scene = file.load();
  std::vector<uint32_t> before, after;
  uint32_t first = ~0u;
  for (uint32_t i = 0; i < scene.materials.size(); ++i) {
    if (scene.materials[i].name != "m") continue;
    before.push_back(scene.materials[i].data.id);
    first = std::min(first, i);
  }
  ASSERT_EQ(before.size(), 3u);
  removeMaterial(scene, first);
  for (const Material& material : exported(scene).materials)
    if (material.name.starts_with("m")) after.push_back(material.data.id);
  EXPECT_THAT(after, testing::IsSupersetOf({before[1], before[2]}));
}

// The slot defines the encoding: sRGB for colors, linear for data. Both textures have the byte 128: sRGB 128 is linear
// 0.2159, which is 55 of 255, and linear 128 of 255 is sRGB 0.7350, which is 188 of 255.
TEST(Export, TexturesAreConvertedToTheEncodingOfTheirSlot) {
  for (const char* name : {"out.glb", "out.obj"}) {
    Scene scene = triangleFile().load();
    Material material{.name = "both"};
    for (const bool srgb : {false, true}) {
      Texture texture = makeTexture({1, 1}, srgb, srgb ? "color" : "data");
      for (int i = 0; i < 4; ++i) texture.pixels.get()[i] = std::byte{128};
      const int index = static_cast<int>(addTexture(scene, texture));
      const uint32_t color = srgb ? shared::kTextureBaseColor : shared::kTextureEmissive;
      const uint32_t data = srgb ? shared::kTextureMetallicRoughness : shared::kTextureNormal;
      material.slots[color].texture = material.slots[data].texture = index;
      material.data.textures |= 1u << color | 1u << data;
    }
    material.data.emissive = vec3(1);
    setMaterialOf(scene, 0, addMaterial(scene, material));
    const Scene again = exported(scene, name);
    const Material& same = again.materials[again.instances[0].material];
    const auto texelOf = [&](uint32_t slot) {
      return std::to_integer<int>(again.textures.at(size_t(same.slots[slot].texture)).pixels.get()[1]);
    };
    EXPECT_EQ(texelOf(shared::kTextureBaseColor), 128) << name;
    EXPECT_EQ(texelOf(shared::kTextureMetallicRoughness), 55) << name;
    EXPECT_EQ(texelOf(shared::kTextureEmissive), 188) << name;
    EXPECT_EQ(texelOf(shared::kTextureNormal), 128) << name;
    EXPECT_EQ(again.textures[size_t(same.slots[shared::kTextureBaseColor].texture)].pixels.get()[3], std::byte{128});
  }
}

// glTF's accessors have at least one element (3.6.2), so a node of an empty mesh is written without one.
TEST(Export, EmptyMeshesAreNodesWithoutMeshes) {
  for (const char* model : {"textured.glb", "skinned.glb", "static_skin.glb", "morphed.glb"}) {
    Scene scene = load(models::modelPath(model).string(), {.morphTargets = true});
    const uint32_t mesh = scene.instances[0].mesh;
    addInstance(scene, mesh, scene.instances[0].material, placement(), "empty");
    setMesh(scene, mesh, {});
    addInstance(scene, addMesh(scene, {.positions = {vec3(0)}, .attributes = {{}}}), 0, placement(), "point");
    const Scene again = exported(scene);
    EXPECT_EQ(again.nodes.size(), scene.nodes.size()) << model;
    for (const Instance& instance : scene.instances) {
      const bool isEmpty = scene.meshes[instance.mesh].indices.empty();
      EXPECT_EQ(partOf(again, instance.part) == nullptr, isEmpty) << model << scene.nodes[instance.node].path;
    }
    EXPECT_EQ(again.triangleCount(), scene.triangleCount()) << model;
  }
}

TEST(Export, ModelsKeepTheirMaterialsIfTheDiskIsFull) {
  const app::Folder folder;
  exports::exportScene(load("builtin:boxes"), folder.at("out.obj"));
  const std::vector<std::byte> materials = readFile(folder.at("out.mtl"));
  std::filesystem::remove(folder.at("out.obj"));
  std::filesystem::create_symlink("/dev/full", folder.at("out.obj"));
  try {
    exports::exportScene(load(models::modelPath("textured.glb").string()), folder.at("out.obj"));
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("No space left"));
  }
  EXPECT_EQ(readFile(folder.at("out.mtl")), materials);
  const std::filesystem::directory_iterator files(folder.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 2) << "no images";
}

TEST(Export, OtherNamesAreRejected) {
  const app::Folder folder;
  try {
    exports::exportScene(load("builtin:boxes"), folder.at("out.fbx"));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
    EXPECT_THAT(error.what(), HasSubstr(".glb, .obj or .ply"));
  }
}

}  // namespace
}  // namespace latelight::scene::test
