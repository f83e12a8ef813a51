// Ids in images: objects as a person would identify them, their parts and materials, and the manifest that resolves the
// ids.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <map>
#include <set>

#include "base/hash.h"
#include "render/submit/id_manifest.h"
#include "render/submit/picking.h"
#include "render/support.h"
#include "scene/gltf_builder.h"
#include "scene/load/load.h"
#include "test_device.h"

namespace latelight::render::test {
namespace {

using nlohmann::json;
using output::Aov;
using output::IdEntry;
using output::IdManifest;
using output::IdPart;
using scene::test::GltfBuilder;

constexpr uint32_t kSize = 96;

json quad(GltfBuilder& file, float left, float right, int material, bool skinned = false) {
  const int positions = file.positions(
      {{left, -.2f, 0}, {right, -.2f, 0}, {right, .2f, 0}, {left, -.2f, 0}, {right, .2f, 0}, {left, .2f, 0}});
  json primitive = {{"attributes", {{"POSITION", positions}}}, {"material", material}};
  if (!skinned) return primitive;
  primitive["attributes"]["JOINTS_0"] =
      file.accessor(file.view(std::vector<uint8_t>(24)), scene::test::kUnsignedByte, "VEC4", 6);
  primitive["attributes"]["WEIGHTS_0"] = file.vectors(std::vector<glm::vec4>(6, glm::vec4(1, 0, 0, 0)));
  return primitive;
}

// At the top, a pair with two materials and two singles named Twin, all children of Shelf; in the middle, three copies
// of the pair; at the bottom, a skinned pair that its joint moves there.
GltfBuilder shelfFile() {
  GltfBuilder b;
  const int red = b.add("materials", {{"name", "red"}}), blue = b.add("materials", {{"name", "blue"}});
  b.add("meshes", {{"name", "pair"}, {"primitives", {quad(b, -.2f, 0, red), quad(b, 0, .2f, blue)}}});
  b.add("meshes", {{"name", "single"}, {"primitives", {quad(b, -.2f, .2f, red)}}});
  b.add("meshes", {{"name", "body"}, {"primitives", {quad(b, -.2f, 0, blue, true), quad(b, 0, .2f, red, true)}}});
  const auto child = [&](const char* name, int mesh, float x) {
    return b.add("nodes", {{"name", name}, {"mesh", mesh}, {"translation", {x, .6, 0}}});
  };
  const int pair = child("Pair", 0, -.6f), twin = child("Twin", 1, 0), other = child("Twin", 1, .6f);
  b.node({{"name", "Shelf"}, {"children", {pair, twin, other}}});
  const int places = b.positions({{-.6f, 0, 0}, {0, 0, 0}, {.6f, 0, 0}});
  b.node({{"name", "Row"},
          {"mesh", 0},
          {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}});
  const int joint = b.node({{"name", "Joint"}, {"translation", {0, -.6, 0}}});
  b.add("skins", {{"joints", {joint}}});
  b.node({{"name", "Body"}, {"mesh", 2}, {"skin", 0}});
  return b;
}

class ShelfFile {
 public:
  ShelfFile() { scene::test::writeBytes(path(), shelfFile().glb()); }
  std::string path() const { return (folder_.path() / "shelf.glb").string(); }

 private:
  scene::test::TemporaryFolder folder_;
};

scene::Scene shelf(const scene::IdGrouping& grouping = {}) {
  return scene::load(ShelfFile().path(), {.ids = grouping});
}

const IdEntry* find(const IdManifest& manifest, uint32_t id) {
  const auto found = std::ranges::find(manifest.ids, id, &IdEntry::id);
  return found == manifest.ids.end() ? nullptr : &*found;
}

// Returns the entries by "/node" or "/node:copy".
std::map<std::string, const IdEntry*> byName(const IdManifest& manifest) {
  std::map<std::string, const IdEntry*> names;
  for (const IdEntry& entry : manifest.ids)
    names[entry.copy ? fmt::format("{}:{}", entry.node, *entry.copy) : entry.node] = &entry;
  EXPECT_EQ(names.size(), manifest.ids.size());
  return names;
}

class Ids : public RenderTest {
 protected:
  output::FrameOutput frameOf(const scene::Scene& scene, const scene::Camera& camera) {
    return renderOne(device(), scene, camera, settingsOf(kSize, kSize, {Aov::Id, Aov::Part, Aov::Material}));
  }

  // Expects that the manifest contains each pixel's id with its part, that part with its material, and each parent up
  // to a root, and that each part belongs to one id. Returns the visible ids.
  std::set<uint32_t> check(const scene::Scene& scene, const output::FrameOutput& frame) {
    const IdManifest manifest = idManifest(scene);
    std::map<uint32_t, std::pair<uint32_t, uint32_t>> parts;  // the id and the material of each part
    for (const IdEntry& entry : manifest.ids) {
      EXPECT_TRUE(entry.parent == 0 || find(manifest, entry.parent)) << entry.node;
      EXPECT_NE(entry.parent, entry.id);
      for (const IdPart& part : entry.parts)
        EXPECT_TRUE(parts.try_emplace(part.id, entry.id, part.material).second) << part.node;
    }
    EXPECT_EQ(parts.size(), scene.instances.size());
    std::set<uint32_t> seen;
    for (size_t i = 0; i < imageOf(frame, Aov::Id).ids.size(); ++i) {
      const uint32_t id = imageOf(frame, Aov::Id).ids[i], part = imageOf(frame, Aov::Part).ids[i],
                     material = imageOf(frame, Aov::Material).ids[i];
      if (id == 0) {
        EXPECT_EQ(part, 0u);
        EXPECT_EQ(material, 0u);
        continue;
      }
      seen.insert(id);
      EXPECT_TRUE(parts.contains(part) && parts[part] == std::pair(id, material)) << i;
      EXPECT_TRUE(std::ranges::count(manifest.materials, material, &output::IdMaterial::id) == 1) << material;
    }
    return seen;
  }
};

TEST_F(Ids, AreWhatAPersonWouldPointAt) {
  const scene::Scene scene = shelf();
  const std::set<uint32_t> seen = check(scene, frameOf(scene, frontCamera()));
  const IdManifest manifest = idManifest(scene);
  auto names = byName(manifest);
  std::vector<std::string> keys;
  for (const auto& [name, entry] : names) keys.push_back(name);
  EXPECT_THAT(keys, testing::ElementsAre("/Body", "/Row", "/Row:0", "/Row:1", "/Row:2", "/Shelf", "/Shelf/Pair",
                                         "/Shelf/Twin", "/Shelf/Twin#2"));
  for (const auto& [name, entry] : names)
    EXPECT_EQ(seen.contains(entry->id), name != "/Row" && name != "/Shelf") << name;
  EXPECT_EQ(names["/Shelf"]->parent, 0u);
  EXPECT_TRUE(names["/Shelf"]->parts.empty());
  EXPECT_EQ(names["/Shelf/Pair"]->id, hash32("/Shelf/Pair"));
  EXPECT_EQ(names["/Shelf/Pair"]->parent, names["/Shelf"]->id);
  EXPECT_EQ(names["/Shelf/Pair"]->mesh, "pair");
  EXPECT_THAT(manifest.materialsOf(*names["/Shelf/Pair"]), testing::ElementsAre("red", "blue"));
  EXPECT_EQ(names["/Shelf/Pair"]->parts.size(), 2u);
  EXPECT_EQ(names["/Shelf/Twin"]->parts.size(), 1u);
  EXPECT_EQ(names["/Row:1"]->parent, names["/Row"]->id);
  EXPECT_EQ(names["/Row:1"]->parts.size(), 2u);
  EXPECT_THAT(manifest.materialsOf(*names["/Body"]), testing::ElementsAre("blue", "red"));
  for (const auto& [name, entry] : names) EXPECT_EQ(entry->skinned, name == "/Body") << name;
}

// Grouping merges ids; the images of parts and materials do not change.
TEST_F(Ids, GroupsMergeTheIdsOfTheirNodes) {
  const scene::Scene alone = shelf();
  const output::FrameOutput apart = frameOf(alone, frontCamera());
  struct Case {
    scene::IdGrouping grouping;
    std::set<uint32_t> seen;
  };
  const uint32_t shelfId = hash32("/Shelf"), row = hash32("/Row"), body = hash32("/Body");
  const std::set<uint32_t> copies{hash32("/Row/instance0"), hash32("/Row/instance1"), hash32("/Row/instance2")};
  std::set<uint32_t> named{shelfId, body, hash32("/Shelf/Twin#2")};
  named.insert(copies.begin(), copies.end());
  for (const Case& one : {Case{{.depth = 0}, {shelfId, row, body}}, Case{{.nodes = {"Shelf", "/Shelf/Twin#2"}}, named},
                          Case{{.nodes = {"Shelf", "Row"}}, {shelfId, row, body}}}) {
    const scene::Scene scene = shelf(one.grouping);
    const output::FrameOutput frame = frameOf(scene, frontCamera());
    EXPECT_EQ(check(scene, frame), one.seen);
    for (const Aov aov : {Aov::Part, Aov::Material}) EXPECT_EQ(imageOf(frame, aov).ids, imageOf(apart, aov).ids);
    const IdManifest manifest = idManifest(scene);
    std::set<std::string> nodes;
    for (const IdPart& part : find(manifest, shelfId)->parts) nodes.insert(part.node);
    EXPECT_TRUE(nodes.contains("/Shelf/Pair") && nodes.contains("/Shelf/Twin"));
    EXPECT_EQ(nodes.contains("/Shelf/Twin#2"), !one.seen.contains(hash32("/Shelf/Twin#2")));
  }
}

TEST_F(Ids, BuiltInScenesListTheirIdsInManifests) {
  for (const char* name : {"builtin:boxes", "builtin:spheres", "builtin:hall,triangles=50k,lights=1"}) {
    SCOPED_TRACE(name);
    const scene::Scene scene = scene::load(name);
    EXPECT_GT(check(scene, frameOf(scene, cameraOf(scene, kSize, kSize))).size(), 3u);
  }
}

// Picking resolves pixels by part, because several parts with different meshes and materials share an id.
TEST_F(Ids, PickingReturnsMeshAndMaterial) {
  for (const scene::IdGrouping& grouping : {scene::IdGrouping{}, scene::IdGrouping{.depth = 0}}) {
    const scene::Scene scene = shelf(grouping);
    const output::FrameOutput frame = frameOf(scene, frontCamera());
    std::map<uint32_t, glm::uvec2> pixels;  // one pixel per part
    for (uint32_t i = 0; i < kSize * kSize; ++i) pixels[imageOf(frame, Aov::Part).ids[i]] = {i % kSize, i / kSize};
    EXPECT_EQ(pixels.size(), 1 + scene.instances.size());
    Renderer renderer(device(), scene, nullptr);
    for (const scene::Instance& instance : scene.instances) {
      const Picked picked =
          pick(renderer, scene, frontCamera(), settingsOf(kSize, kSize), {&pixels[instance.part], 1}).picked.front();
      EXPECT_EQ(picked.id, instance.id);
      EXPECT_EQ(picked.part, instance.part);
      EXPECT_EQ(picked.node, scene.nodes[instance.node].path);
      EXPECT_EQ(picked.mesh, scene.nodes[instance.node].mesh);
      EXPECT_EQ(picked.primitive, instance.primitive);
      EXPECT_EQ(picked.material, scene.materials[instance.material].name);
    }
  }
}

TEST_F(Ids, ThePublicApiListsIdsInItsManifest) {
  const ShelfFile file;
  const latelight::Scene scene(file.path(), latelight::SceneOptions{.idNodes = {"Shelf"}});
  const json manifest = json::parse(scene.idManifest());
  latelight::Renderer renderer(scene, latelight::test::testDevice());
  latelight::Options options;
  options.width = options.height = kSize;
  options.aovs = {"id", "part", "material"};
  const latelight::Camera camera = scene.defaultCamera(1);
  const latelight::Frame frame = renderer.render(camera, options);
  std::set<uint32_t> seen;
  for (size_t i = 0; i < size_t{kSize} * kSize; ++i) {
    const uint32_t id = frame.aovs.at("id").ids[i];
    if (!seen.insert(id).second || id == 0) continue;
    const json& entry = manifest["ids"].at(std::to_string(id));
    const json part = {{"id", frame.aovs.at("part").ids[i]}, {"material", frame.aovs.at("material").ids[i]}};
    EXPECT_TRUE(std::ranges::any_of(entry["parts"], [&](const json& candidate) {
      return candidate["id"] == part["id"] && candidate["material"] == part["material"];
    })) << entry;
    EXPECT_TRUE(manifest["materials"].contains(part["material"].dump()));
    const latelight::Pick pick =
        renderer.pick(camera, {{static_cast<uint32_t>(i % kSize), static_cast<uint32_t>(i / kSize)}}, options).front();
    EXPECT_EQ(pick.id, id);
    EXPECT_EQ(pick.part, part["id"].get<uint32_t>());
  }
  EXPECT_THAT(seen, testing::IsSupersetOf({0u, hash32("/Shelf"), hash32("/Row/instance2"), hash32("/Body")}));
  EXPECT_THROW(latelight::Scene(file.path(), latelight::SceneOptions{.idNodes = {"Cupboard"}}), latelight::Error);
}

}  // namespace
}  // namespace latelight::render::test
