// The effects of edits on a scene, and the edits that are rejected.
#include <gmock/gmock.h>

#include <limits>
#include <set>

#include "base/error.h"
#include "base/hash.h"
#include "edits/workshop.h"
#include "render/submit/id_manifest.h"
#include "scene/edit.h"
#include "scene/ids.h"

namespace latelight::scene {
namespace {

using render::test::Dice;
using render::test::sphereMesh;
using render::test::squareMesh;
using render::test::workshop;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

mat4 shifted(float x) {
  mat4 m(1);
  m[3].x = x;
  return m;
}

// Returns the message of the rejected edit. The scene must be unchanged.
template <typename Edit>
std::string refusal(const Scene& scene, Edit edit) {
  const auto revisions = [&] {
    const SceneEdits& e = scene.edits;
    return std::array{e.meshes.revision(), e.materials.revision(), e.instances.revision(), e.lights.revision()};
  };
  const auto sizes = [&] {
    return std::array{scene.meshes.size(), scene.materials.size(), scene.instances.size(), scene.lights.size(),
                      scene.nodes.size()};
  };
  const auto before = std::pair(revisions(), sizes());
  try {
    edit();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
    EXPECT_EQ(std::pair(revisions(), sizes()), before);
    return error.what();
  }
  return "nothing was refused";
}

TEST(SceneEdit, NotesWhatChanged) {
  Scene scene = workshop();
  setTransform(scene, 3, shifted(1));
  setMaterialOf(scene, 1, 0);
  setMaterial(scene, 2, scene.materials[4]);
  setLight(scene, 1, scene.lights[2]);
  setMesh(scene, 0, squareMesh());
  EXPECT_THAT(scene.edits.instances.since(0), ElementsAre(1, 3));
  EXPECT_THAT(scene.edits.materials.since(0), ElementsAre(2));
  EXPECT_THAT(scene.edits.lights.since(0), ElementsAre(1));
  EXPECT_THAT(scene.edits.meshes.since(0), ElementsAre(0));
  EXPECT_EQ(scene.instances[3].toWorld, dmat4(shifted(1)));
  EXPECT_TRUE(scene.instances[3].placed);
  EXPECT_FALSE(scene.instances[1].placed);
  EXPECT_EQ(scene.instances[1].material, 0u);
  EXPECT_EQ(scene.lights[1].name, "spot");
  EXPECT_EQ(scene.meshes[0].positions.size(), 4u);
}

TEST(SceneEdit, AMaterialKeepsItsNameAndItsId) {
  Scene scene = workshop();
  const Material before = scene.materials[2];
  setMaterial(scene, 2, scene.materials[1]);
  EXPECT_EQ(scene.materials[2].name, before.name);
  EXPECT_EQ(scene.materials[2].data.id, before.data.id);
  EXPECT_EQ(scene.materials[2].data.metallic, 1);
}

TEST(SceneEdit, BoundsFollowTheMesh) {
  Scene scene = workshop();
  setMesh(scene, 1, sphereMesh(3));
  EXPECT_EQ(scene.meshes[1].boundsMax.y, 3);
  EXPECT_EQ(scene.meshes[1].boundsMin.y, -3);
  setMesh(scene, 1, Mesh{});
  EXPECT_EQ(scene.meshes[1].boundsMin, vec3(0));
  EXPECT_EQ(scene.meshes[1].boundsMax, vec3(0));
}

TEST(SceneEdit, WhatIsAddedTakesTheGapsOfWhatWasRemoved) {
  Scene scene = workshop();
  const uint32_t count = uint32_t(scene.instances.size()), lights = uint32_t(scene.lights.size());
  removeInstance(scene, 2);
  removeInstance(scene, 5);
  removeLight(scene, 1);
  EXPECT_EQ(addInstance(scene, 0, 1, shifted(2)), 5u);
  EXPECT_EQ(addInstance(scene, 0, 1, shifted(2)), 2u);
  EXPECT_EQ(addInstance(scene, 0, 1, shifted(2)), count);
  EXPECT_EQ(addLight(scene, scene.lights[0]), 1u);
  EXPECT_EQ(addLight(scene, scene.lights[0]), lights);
  for (const uint32_t place : {2u, 5u}) {
    EXPECT_FALSE(scene.instances[place].removed);
    EXPECT_EQ(scene.edits.instanceGaps.generation(place), 1u);
  }
  EXPECT_EQ(scene.edits.instanceGaps.generation(3), 0u);
  EXPECT_EQ(scene.edits.instanceGaps.generation(count), 0u);
  EXPECT_EQ(scene.edits.lightGaps.generation(1), 1u);
}

TEST(SceneEdit, WhatIsRemovedCountsNoMore) {
  Scene scene = workshop();
  scene.instances.resize(2);  // the floor and a ball
  const uint64_t all = scene.triangleCount();
  removeInstance(scene, 1);
  EXPECT_EQ(all - scene.triangleCount(), scene.meshes[0].indices.size() / 3);
  const output::IdManifest manifest = render::idManifest(scene);
  for (const output::IdEntry& entry : manifest.ids)
    for (const output::IdPart& part : entry.parts) EXPECT_EQ(part.node, "/workshop/ground");
  removeInstance(scene, 0);
  EXPECT_TRUE(worldBounds(scene).empty());
  EXPECT_EQ(scene.triangleCount(), 0u);
}

TEST(SceneEdit, AddedInstancesHaveNodesAndIdsOfTheirOwnThatGoWithThem) {
  Scene scene = workshop();
  const size_t nodes = scene.nodes.size();
  const uint32_t first = addInstance(scene, 1, 0, shifted(1), "crate"),
                 second = addInstance(scene, 1, 0, shifted(2), "crate");
  const auto nodeOf = [&](uint32_t instance) { return scene.nodes[scene.instances[instance].node]; };
  EXPECT_EQ(nodeOf(first).path, "/crate");
  EXPECT_THAT(nodeOf(second).path, testing::StartsWith("/crate#"));
  EXPECT_EQ(nodeOf(first).mesh, "square");
  std::set<uint32_t> ids, parts;
  for (const Instance& instance : scene.instances) {
    EXPECT_TRUE(ids.insert(instance.id).second);
    EXPECT_TRUE(parts.insert(instance.part).second);
  }
  EXPECT_FALSE(ids.contains(0) || parts.contains(0));
  const uint32_t id = scene.instances[first].id;
  removeInstance(scene, first);
  // an instance is named after its mesh
  EXPECT_EQ(scene.instances[addInstance(scene, 1, 0, shifted(1), "crate")].id, id);
  for (int i = 0; i < 100; ++i) removeInstance(scene, addInstance(scene, 0, 0, shifted(3)));
  EXPECT_EQ(scene.nodes.size(), nodes + 3);
}

TEST(SceneEdit, AnObjectHasOneNodeAndOneId) {
  Scene scene = workshop();
  const ObjectPart parts[] = {{0, 1, shifted(1)}, {1, 2, shifted(2)}};
  const std::vector<uint32_t> added = addObject(scene, parts, "cup");
  ASSERT_EQ(added.size(), 2u);
  const Instance first = scene.instances[added[0]], second = scene.instances[added[1]];
  EXPECT_EQ(scene.nodes[first.node].path, "/cup");
  EXPECT_EQ(first.node, second.node);
  EXPECT_EQ(first.id, hash32("/cup"));
  EXPECT_EQ(second.id, hash32("/cup"));
  EXPECT_EQ(first.part, hash32("/cup/primitive0"));
  EXPECT_EQ(second.part, hash32("/cup/primitive1"));
  EXPECT_EQ(second.primitive, 1u);
  EXPECT_EQ(second.material, 2u);
  removeInstance(scene, added[0]);
  EXPECT_EQ(scene.nodes[second.node].path, "/cup");
  removeInstance(scene, added[1]);
  EXPECT_EQ(scene.nodes[second.node].path, "");
  EXPECT_THAT(refusal(scene, [&] { addObject(scene, {}, "cup"); }), HasSubstr("without meshes"));
  const ObjectPart wrong[] = {{0, 1, shifted(1)}, {0, 99, shifted(2)}};
  EXPECT_THAT(refusal(scene, [&] { addObject(scene, wrong, "cup"); }), HasSubstr("no material 99"));
  EXPECT_EQ(scene.instances[addObject(scene, parts, "cup")[0]].id, hash32("/cup"));
}

TEST(SceneEdit, WhatIsRestoredIsAsItWas) {
  Scene scene = workshop();
  const Instance before = scene.instances[2];
  removeInstance(scene, 2);
  removeInstance(scene, 4);
  const uint64_t revision = scene.edits.instances.revision();
  restoreInstance(scene, 2);
  EXPECT_FALSE(scene.instances[2].removed);
  EXPECT_EQ(scene.instances[2].id, before.id);
  EXPECT_EQ(scene.nodes[scene.instances[2].node].path, scene.nodes[before.node].path);
  EXPECT_FALSE(scene.instances[2].placed);
  EXPECT_THAT(scene.edits.instances.since(revision), ElementsAre(2));
  EXPECT_EQ(addInstance(scene, 0, 0, shifted(1), "ball"), 4u);  // in the other gap, not that of the restored instance
  const std::string present = refusal(scene, [&] { restoreInstance(scene, 2); });
  EXPECT_THAT(present, HasSubstr("the instance 2 is not one"));
  EXPECT_THAT(refusal(scene, [&] { restoreInstance(scene, 4); }), HasSubstr("the instance 4 is not one"));
  removeInstance(scene, 4);
  EXPECT_THAT(refusal(scene, [&] { restoreInstance(scene, 4); }), HasSubstr("the instance 4 is not one"));
}

TEST(SceneEdit, AddedMaterialsHaveIdsOfTheirOwn) {
  Scene scene = workshop();
  std::set<uint32_t> ids{0};
  for (int i = 0; i < 3; ++i) addMaterial(scene, scene.materials[1]);
  addMaterial(scene, plainMaterial("", vec3(1), 0, 1));
  for (const Material& material : scene.materials) EXPECT_TRUE(ids.insert(material.data.id).second);
}

TEST(SceneEdit, RefusesWhatIsNotThere) {
  Scene scene = workshop();
  removeInstance(scene, 1);
  removeLight(scene, 0);
  EXPECT_EQ(refusal(scene, [&] { setTransform(scene, 99, mat4(1)); }), "there is no instance 99: the scene has 9");
  EXPECT_EQ(refusal(scene, [&] { setTransform(scene, 1, mat4(1)); }), "the instance 1 has been removed");
  EXPECT_EQ(refusal(scene, [&] { removeInstance(scene, 1); }), "the instance 1 has been removed");
  EXPECT_EQ(refusal(scene, [&] { setMaterialOf(scene, 1, 0); }), "the instance 1 has been removed");
  EXPECT_EQ(refusal(scene, [&] { setMaterialOf(scene, 0, 7); }), "there is no material 7: the scene has 7");
  EXPECT_EQ(refusal(scene, [&] { setMaterial(scene, 8, scene.materials[0]); }),
            "there is no material 8: the scene has 7");
  EXPECT_EQ(refusal(scene, [&] { addInstance(scene, 3, 0, mat4(1)); }), "there is no mesh 3: the scene has 3");
  EXPECT_EQ(refusal(scene, [&] { addInstance(scene, 0, 9, mat4(1)); }), "there is no material 9: the scene has 7");
  EXPECT_EQ(refusal(scene, [&] { setLight(scene, 0, scene.lights[1]); }), "the light 0 has been removed");
  EXPECT_EQ(refusal(scene, [&] { removeLight(scene, 3); }), "there is no light 3: the scene has 3");
  EXPECT_EQ(refusal(scene, [&] { setMesh(scene, 5, squareMesh()); }), "there is no mesh 5: the scene has 3");
}

TEST(SceneEdit, RefusesTransformsAndNames) {
  Scene scene = workshop();
  EXPECT_THAT(refusal(scene, [&] { setTransform(scene, 0, shifted(kNaN)); }), HasSubstr("transform of an instance"));
  mat4 projective(1);
  projective[2][3] = 1;
  EXPECT_THAT(refusal(scene, [&] { setTransform(scene, 0, projective); }), HasSubstr("last row 0 0 0 1"));
  EXPECT_THAT(refusal(scene, [&] { addInstance(scene, 0, 0, projective); }), HasSubstr("last row 0 0 0 1"));
  EXPECT_THAT(refusal(scene, [&] { addInstance(scene, 0, 0, mat4(1), "a/b"); }), HasSubstr("\"a/b\""));
}

TEST(SceneEdit, RefusesMaterials) {
  Scene scene = workshop();
  const auto refused = [&](auto change) {
    Material material = scene.materials[1];
    change(material);
    const std::string sentence = refusal(scene, [&] { setMaterial(scene, 1, material); });
    EXPECT_EQ(refusal(scene, [&] { addMaterial(scene, material); }), sentence);
    return sentence;
  };
  const auto data = [&](auto member, auto value) {
    return refused([&](Material& material) { material.data.*member = value; });
  };
  using M = shared::Material;
  EXPECT_EQ(data(&M::metallic, 1.5f), "the metallic share of the material \"metal\" must be between 0 and 1, not 1.5");
  EXPECT_THAT(data(&M::roughness, kNaN), HasSubstr("roughness"));
  EXPECT_THAT(data(&M::baseColor, vec4(0, -1, 0, 1)), HasSubstr("base color"));
  EXPECT_THAT(data(&M::emissive, vec3(0, 0, kNaN)), HasSubstr("emitted light"));
  EXPECT_EQ(data(&M::normalScale, kNaN), "the normal scale of the material \"metal\" must be a finite number, not nan");
  EXPECT_EQ(data(&M::specular, 1.5f),
            "the specular strength of the material \"metal\" must be between 0 and 1, not 1.5");
  EXPECT_THAT(data(&M::alphaCutoff, -1.0f), HasSubstr("alpha cutoff"));
  EXPECT_THAT(data(&M::f0, 2.0f), HasSubstr("f0"));
  const auto layer = [&](auto member, auto value) {
    return refused([&](Material& material) { material.data.layers.*member = value; });
  };
  using L = shared::MaterialLayers;
  EXPECT_EQ(layer(&L::clearcoat, 2.0f), "the clear coat of the material \"metal\" must be between 0 and 1, not 2");
  EXPECT_THAT(layer(&L::sheenColor, vec3(0, 2, 0)), HasSubstr("sheen color"));
  EXPECT_THAT(layer(&L::thickness, -1.0f), HasSubstr("thickness"));
  EXPECT_THAT(layer(&L::dispersion, kNaN), HasSubstr("dispersion"));
  EXPECT_THAT(data(&M::flags, shared::kMaterialMasked | shared::kMaterialBlended),
              HasSubstr("both masked and blended"));
  EXPECT_THAT(refused([](Material& m) { m.slots[1].texture = 3; }), HasSubstr("texture 3, and the scene has 3"));
  EXPECT_THAT(refused([](Material& m) { m.slots[0].texture = 1; }), HasSubstr("both as used and as unused"));
}

TEST(SceneEdit, RefusesLights) {
  Scene scene = workshop();
  const auto refused = [&](auto member, auto value) {
    Light light = scene.lights[2];
    light.*member = value;
    const std::string sentence = refusal(scene, [&] { setLight(scene, 2, light); });
    EXPECT_EQ(refusal(scene, [&] { addLight(scene, light); }), sentence);
    return sentence;
  };
  EXPECT_EQ(refused(&Light::intensity, -2.0f),
            "the intensity of the light \"spot\" must be a finite number of at least 0, not -2");
  EXPECT_THAT(refused(&Light::position, vec3(kNaN)), HasSubstr("position"));
  EXPECT_THAT(refused(&Light::direction, vec3(0)), HasSubstr("length 1"));
  EXPECT_THAT(refused(&Light::color, vec3(1, -1, 1)), HasSubstr("color"));
  EXPECT_THAT(refused(&Light::range, 0.0f), HasSubstr("range"));
  EXPECT_THAT(refused(&Light::innerCone, 1.0f), HasSubstr("cones"));
  EXPECT_THAT(refused(&Light::outerCone, 2.0f), HasSubstr("cones"));
  EXPECT_THAT(refused(&Light::size, -1.0f), HasSubstr("size"));
  EXPECT_THAT(refused(&Light::type, shared::kLightTypes), HasSubstr("unknown type"));
  EXPECT_THAT(refused(&Light::type, shared::kLightTube), HasSubstr("size"));
  EXPECT_THAT(refused(&Light::node, 40), HasSubstr("follows node 40"));
}

TEST(SceneEdit, RefusesMeshes) {
  Scene scene = workshop();
  const auto refused = [&](auto change) {
    Mesh mesh = squareMesh(true);
    change(mesh);
    const std::string sentence = refusal(scene, [&] { setMesh(scene, 1, mesh); });
    EXPECT_EQ(refusal(scene, [&] { addMesh(scene, mesh); }), sentence);
    return sentence;
  };
  EXPECT_EQ(refused([](Mesh& m) { m.indices.pop_back(); }),
            "the mesh \"square\" has 5 indices, which is not a multiple of three");
  EXPECT_EQ(refused([](Mesh& m) { m.indices[4] = 4; }), "the mesh \"square\" has the index 4 but only 4 vertices");
  EXPECT_THAT(refused([](Mesh& m) { m.attributes.pop_back(); }), HasSubstr("4 positions, 3 normals"));
  EXPECT_THAT(refused([](Mesh& m) { m.extras.pop_back(); }), HasSubstr("3 colors"));
  EXPECT_THAT(refused([](Mesh& m) { m.positions[1].y = kNaN; }), HasSubstr("positions"));
  EXPECT_THAT(refused([](Mesh& m) { m.attributes[1].normal.y = kNaN; }), HasSubstr("normals"));
  EXPECT_THAT(refused([](Mesh& m) { m.attributes[1].uv0.y = kNaN; }), HasSubstr("texture coordinates"));
  EXPECT_THAT(refused([](Mesh& m) { m.extras[1].color.y = kNaN; }), HasSubstr("colors"));
  EXPECT_THAT(refused([](Mesh& m) { m.deformation = std::make_shared<Deformation>(); }),
              HasSubstr("a deformation of 0"));
}

// Compares with a std::set, with many equal hashes.
TEST(UniqueIds, WhatIsReleasedIsFreeAndNothingElse) {
  Dice dice(3);
  UniqueIds ids;
  std::set<uint32_t> taken;
  for (int i = 0; i < 20000; ++i) {
    const uint32_t id = 1 + dice.below(700) * (1 + 4096 * dice.below(2));
    if (dice.chance(0.5f)) {
      EXPECT_EQ(ids.take(id), taken.insert(id).second) << id;
    } else {
      ids.release(id);
      taken.erase(id);
    }
  }
  EXPECT_FALSE(ids.take(0));
}

}  // namespace
}  // namespace latelight::scene
