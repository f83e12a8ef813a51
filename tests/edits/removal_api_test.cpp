// Removing meshes, materials and textures, and replacing textures, through the public API.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <functional>

#include "base/hash.h"
#include "error_of.h"
#include "test_device.h"

namespace latelight {
namespace {

using testing::HasSubstr;

constexpr Transform kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

MeshData square(const char* name) {
  return {.name = name,
          .positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
          .indices = {0, 1, 2, 0, 2, 3},
          .uv = {{0, 1}, {1, 1}, {1, 0}, {0, 0}}};
}

// An opaque texture of one color.
TextureData plain(uint32_t width, uint32_t height, std::array<uint8_t, 3> color, bool srgb = false) {
  TextureData data{"plain", width, height, srgb, {}};
  for (uint32_t i = 0; i < width * height; ++i) data.rgba.insert(data.rgba.end(), {color[0], color[1], color[2], 255});
  return data;
}

// A wall that fills the picture and has a base color texture.
struct Wall {
  Scene scene;
  Handle<Mesh> mesh = scene.addMesh(square("wall"));
  Handle<Material> material = scene.addMaterial({.name = "paint", .metallic = 0});
  Handle<Texture> texture = scene.addTexture(plain(4, 4, {255, 0, 0}));
  Handle<Instance> instance = scene.addInstance(mesh, material, kIdentity);
  Camera camera = scene.lookAt({0, 0, 2}, {0, 0, 0}, 50);

  Wall() { scene.setTexture(material, TextureSlot::BaseColor, TextureUse{.texture = texture}); }
  std::array<float, 3> albedo(Renderer& renderer) const {
    Options options;
    options.width = options.height = 8;
    options.picture = false;
    options.aovs = {"albedo"};
    const std::vector<float> values = renderer.render(camera, options).aovs.at("albedo").values;
    return {values[3 * 36], values[3 * 36 + 1], values[3 * 36 + 2]};
  }
};

TEST(Removal, OfWhatIsUsedIsRefusedByTheUsersName) {
  Wall wall;
  EXPECT_THAT(errorOf([&] { wall.scene.removeMesh(wall.mesh); }), HasSubstr("the instance /wall shows it"));
  EXPECT_THAT(errorOf([&] { wall.scene.removeMaterial(wall.material); }), HasSubstr("the instance /wall shows it"));
  EXPECT_THAT(errorOf([&] { wall.scene.removeTexture(wall.texture); }), HasSubstr("the material \"paint\" samples it"));
  wall.scene.removeInstance(wall.instance);
  wall.scene.removeMesh(wall.mesh);
  EXPECT_THAT(errorOf([&] { wall.scene.removeTexture(wall.texture); }), HasSubstr("the material \"paint\" samples it"));
  wall.scene.removeMaterial(wall.material);
  wall.scene.removeTexture(wall.texture);
  EXPECT_TRUE(wall.scene.meshes().empty() && wall.scene.materials().empty() && wall.scene.textures().empty());
}

TEST(Removal, HandlesOfRemovedElementsAreRefusedEvenIfAnotherTakesTheirPlace) {
  Wall wall;
  const auto mesh = wall.scene.addMesh(square("other"));
  const auto material = wall.scene.addMaterial({.name = "other"});
  const auto texture = wall.scene.addTexture(plain(2, 2, {1, 2, 3}));
  wall.scene.removeMesh(mesh);
  wall.scene.removeMaterial(material);
  wall.scene.removeTexture(texture);
  for (int round = 0; round < 2; ++round) {
    EXPECT_THAT(errorOf([&] { wall.scene.mesh(mesh); }), HasSubstr("removed"));
    EXPECT_THAT(errorOf([&] { wall.scene.addInstance(mesh, wall.material, kIdentity); }), HasSubstr("removed"));
    EXPECT_THAT(errorOf([&] { wall.scene.assignMaterial(wall.instance, material); }), HasSubstr("removed"));
    EXPECT_THAT(errorOf([&] { wall.scene.removeMaterial(material); }), HasSubstr("removed"));
    EXPECT_THAT(errorOf([&] { wall.scene.textureData(texture); }), HasSubstr("removed"));
    EXPECT_THAT(errorOf([&] { wall.scene.setTextureData(texture, plain(2, 2, {})); }), HasSubstr("removed"));
    EXPECT_THAT(
        errorOf([&] { wall.scene.setTexture(wall.material, TextureSlot::Normal, TextureUse{.texture = texture}); }),
        HasSubstr("removed"));
    EXPECT_EQ(wall.scene.addMesh(square("next")).index, mesh.index + static_cast<uint32_t>(round));
    EXPECT_EQ(wall.scene.addMaterial({.name = "next"}).index, material.index + static_cast<uint32_t>(round));
    EXPECT_EQ(wall.scene.addTexture(plain(2, 2, {})).index, texture.index + static_cast<uint32_t>(round));
  }
}

TEST(Removal, GivesAMaterialsIdToTheNextOfItsName) {
  Scene scene;
  const auto id = [&](Handle<Material> material) { return scene.material(material).id; };
  const auto first = scene.addMaterial({.name = "paint"}), twin = scene.addMaterial({.name = "paint"});
  EXPECT_EQ(id(first), hash32("paint"));
  EXPECT_NE(id(twin), hash32("paint"));
  const uint32_t idOfTwin = id(twin);
  scene.removeMaterial(first);
  EXPECT_EQ(id(twin), idOfTwin) << "other materials keep their ids";
  EXPECT_EQ(scene.idManifest().find(std::to_string(hash32("paint"))), std::string::npos);
  EXPECT_EQ(id(scene.addMaterial({.name = "paint"})), hash32("paint"));
}

TEST(Removal, NumbersOfEqualNamesAreTheLowestFreeOnes) {
  Scene scene;
  const Handle<Mesh> mesh = scene.addMesh(square("square"));
  const Handle<Material> paint = scene.addMaterial({.name = "paint"});
  const auto add = [&](const char* name) { return scene.addInstance(mesh, paint, kIdentity, name); };
  const auto path = [&](Handle<Instance> instance) { return scene.instance(instance).node; };
  for (const char* name : {"a", "b", "c"}) {
    EXPECT_EQ(path(add(name)), fmt::format("/{}", name));
    EXPECT_EQ(path(add(name)), fmt::format("/{}#2", name));
  }
  for (int i = 0; i < 3; ++i) {
    const Handle<Instance> third = add("a");
    EXPECT_EQ(path(third), "/a#3");
    EXPECT_EQ(scene.instance(third).id, hash32("/a#3"));
    scene.removeInstance(third);
  }
  EXPECT_EQ(path(add("b#3")), "/b#3");
  EXPECT_EQ(path(add("b")), "/b#4");
  scene.removeInstance(scene.instancesOf("/b#3").front());
  scene.removeInstance(scene.instancesOf("/b#2").front());
  scene.removeInstance(scene.instancesOf("/b").front());
  for (const char* expected : {"/b", "/b#2", "/b#3", "/b#5"}) EXPECT_EQ(path(add("b")), expected);
  EXPECT_EQ(scene.addNode({.name = "c"}), "/c#3");
  EXPECT_EQ(scene.addNode({.name = "child", .parent = "/c#3"}), "/c#3/child");
  EXPECT_EQ(scene.addNode({.name = "child", .parent = "/c#3"}), "/c#3/child#2");

  const auto id = [&](Handle<Material> material) { return scene.material(material).id; };
  const Handle<Material> second = scene.addMaterial({.name = "paint"});
  EXPECT_EQ(id(second), hash32("paint#2"));
  EXPECT_EQ(id(scene.addMaterial({.name = "paint"})), hash32("paint#3"));
  scene.removeMaterial(second);
  EXPECT_EQ(id(scene.addMaterial({.name = "paint"})), hash32("paint#2"));
}

TEST(Removal, ReplacedPixelsShowInAllMaterialsAndSizes) {
  Wall wall;
  Renderer renderer(wall.scene, latelight::test::testDevice());
  EXPECT_EQ(wall.albedo(renderer), (std::array<float, 3>{1, 0, 0}));
  wall.scene.setTextureData(wall.texture, plain(16, 8, {0, 255, 0}));
  EXPECT_EQ(wall.albedo(renderer), (std::array<float, 3>{0, 1, 0}));
  EXPECT_EQ(wall.scene.texture(wall.texture).width, 16u);
  wall.scene.setTextureData(wall.texture, plain(5, 3, {0, 0, 255}));  // not a power of two
  EXPECT_EQ(wall.albedo(renderer), (std::array<float, 3>{0, 0, 1}));
  const auto grey = [&](bool srgb) {
    wall.scene.setTextureData(wall.texture, plain(4, 4, {128, 128, 128}, srgb));
    return wall.albedo(renderer)[1];
  };
  EXPECT_NEAR(grey(false), 128 / 255.0, 2e-3);
  EXPECT_NEAR(grey(true), 0.2158605, 2e-3);  // ((128 / 255 + 0.055) / 1.055) ^ 2.4
  EXPECT_THAT(errorOf([&] {
                wall.scene.setTextureData(wall.texture, {"none", 0, 0, true, {}});
              }),
              HasSubstr("no pixels"));
  EXPECT_NEAR(wall.albedo(renderer)[1], 0.2158605, 2e-3) << "a refused edit changes nothing";
}

TEST(Removal, TicketsShowWhatWasThereWhenTheyWereSubmitted) {
  Wall wall;
  Renderer renderer(wall.scene, latelight::test::testDevice());
  const auto before = wall.albedo(renderer);
  Options options;
  options.width = options.height = 8;
  options.aovs = {"albedo"};
  Ticket ticket = renderer.submit({wall.camera}, options);
  wall.scene.removeInstance(wall.instance);
  wall.scene.removeMesh(wall.mesh);
  wall.scene.removeMaterial(wall.material);
  wall.scene.removeTexture(wall.texture);
  Ticket empty = renderer.submit({wall.camera}, options);
  const std::vector<float> values = ticket.take().front().aovs.at("albedo").values;
  EXPECT_EQ(values[3 * 36], before[0]);
  EXPECT_EQ(empty.take().front().aovs.at("albedo").values[3 * 36], 0);
}

}  // namespace
}  // namespace latelight
