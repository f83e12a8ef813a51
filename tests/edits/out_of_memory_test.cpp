// Edits of which each allocation fails in turn: the edit throws Error(OutOfMemory), the scene is unchanged, and the
// same edit then succeeds with the result of one that was not disturbed. The same for images after edits.
#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <new>
#include <string>
#include <vector>

#include "app/folder.h"
#include "counted_allocations.h"
#include "long_tests.h"
#include "test_device.h"

namespace latelight {
namespace {

constexpr Transform kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr Transform kMoved{1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0.25, 0, 0, 0, 1};

// Names too long to be stored without an allocation.
const std::string kLong = " with a name that requires an allocation";

MeshData triangle(float height) {
  return {.name = "triangle" + kLong,
          .positions = {{-1, -1, 0}, {1, -1, 0}, {0, height, 0}},
          .indices = {},
          .uv = {{0, 1}, {1, 1}, {0, 0}}};
}

TextureData plain(uint8_t gray) {
  return {"plain" + kLong, 2, 2, true, std::vector<uint8_t>(16, gray)};
}

// A small scene in which everything that an edit may refer to exists, also gaps.
struct Edited {
  Scene scene;
  Handle<Mesh> mesh = scene.addMesh(triangle(1)), unusedMesh = scene.addMesh(triangle(2));
  Handle<Material> material = scene.addMaterial({.name = "paint" + kLong});
  Handle<Material> unusedMaterial = scene.addMaterial({.name = "paint" + kLong});
  Handle<Texture> texture = scene.addTexture(plain(100)), unusedTexture = scene.addTexture(plain(50));
  Handle<Instance> instance = scene.addInstance(mesh, material, kIdentity, "instance" + kLong);
  Handle<Instance> twin = scene.addInstance(mesh, material, kMoved, "instance" + kLong);
  Handle<Light> light = scene.addLight({.name = "lamp" + kLong, .range = {}, .castShadow = {}});
  Handle<Light> otherLight = scene.addLight({});  // a new renderer of a scene without lights has an environment
  std::string node = scene.addNode({.name = "node" + kLong, .parent = "", .parts = {{mesh, material}}, .weights = {}});

  Edited() {
    scene.setTexture(material, TextureSlot::BaseColor, TextureUse{.texture = texture});
    scene.addCamera(scene.lookAt({0, 0, 4}, {0, 0, 0}));
  }
};

using Call = std::function<void()>;

struct Edit {
  const char* name;
  std::function<Call(Edited&)> prepare;  // the call holds its arguments, so that only the edit allocates
  bool mayBePartial = false;             // if it fails; another call then completes it
};
void PrintTo(const Edit& edit, std::ostream* out) {
  *out << edit.name;
}

const Edit kEdits[] = {
    {"SetTransform", [](Edited& e) { return [&e] { e.scene.setTransform(e.instance, kMoved); }; }},
    {"AssignMaterial", [](Edited& e) { return [&e] { e.scene.assignMaterial(e.instance, e.unusedMaterial); }; }},
    {"AddInstance",
     [](Edited& e) {
       return [&e, name = "instance" + kLong] { e.scene.addInstance(e.mesh, e.material, kMoved, name); };
     }},
    {"RemoveInstance", [](Edited& e) { return [&e] { e.scene.removeInstance(e.twin); }; }},
    {"SetMaterial",
     [](Edited& e) {
       return [&e, to = Material{.name = "other" + kLong, .metallic = 0, .clearcoat = 1}] {
         e.scene.setMaterial(e.material, to);
       };
     }},
    {"AddMaterial",
     [](Edited& e) { return [&e, added = Material{.name = "paint" + kLong}] { e.scene.addMaterial(added); }; }},
    {"RemoveMaterial", [](Edited& e) { return [&e] { e.scene.removeMaterial(e.unusedMaterial); }; }},
    {"SetLight",
     [](Edited& e) {
       return [&e, to = Light{.name = "other" + kLong, .intensity = 5}] { e.scene.setLight(e.light, to); };
     }},
    {"AddLight", [](Edited& e) { return [&e, added = Light{.name = "second" + kLong}] { e.scene.addLight(added); }; }},
    {"RemoveLight", [](Edited& e) { return [&e] { e.scene.removeLight(e.light); }; }},
    {"SetMesh", [](Edited& e) { return [&e, to = triangle(3)] { e.scene.setMesh(e.mesh, to); }; }},
    {"AddMesh", [](Edited& e) { return [&e, added = triangle(3)] { e.scene.addMesh(added); }; }},
    {"RemoveMesh", [](Edited& e) { return [&e] { e.scene.removeMesh(e.unusedMesh); }; }},
    {"SetTexture",
     [](Edited& e) { return [&e] { e.scene.setTexture(e.material, TextureSlot::BaseColor, std::nullopt); }; }},
    {"SetTextureData", [](Edited& e) { return [&e, to = plain(200)] { e.scene.setTextureData(e.texture, to); }; }},
    {"AddTexture", [](Edited& e) { return [&e, added = plain(200)] { e.scene.addTexture(added); }; }},
    {"RemoveTexture", [](Edited& e) { return [&e] { e.scene.removeTexture(e.unusedTexture); }; }},
    {"AddCamera",
     [](Edited& e) {
       return [&e, added = e.scene.lookAt({0, 0, 2}, {0, 0, 0})] { e.scene.addCamera(added); };
     }},
    {"AddNode",
     [](Edited& e) {
       NodeData added{.name = "child"};
       added.parent = e.node;
       added.parts = {{e.mesh, e.material}, {e.unusedMesh, e.unusedMaterial}};
       return [&e, added] { e.scene.addNode(added); };
     }},
    {"AddSkin", [](Edited& e) { return [&e, added = Skin{.joints = {e.node}}] { e.scene.addSkin(added); }; }},
    {"AddAnimation",
     [](Edited& e) {
       const AnimationChannel channel{.node = e.node, .times = {0, 1}, .values = {0, 0, 0, 1, 1, 1}};
       return
           [&e, name = "animation" + kLong, channels = std::vector{channel}] { e.scene.addAnimation(name, channels); };
     }},
    {"SetNodeTransform", [](Edited& e) { return [&e] { e.scene.setNodeTransform(e.node, kMoved); }; }, true},
};

// Everything that the scene's file and its lists state.
std::string stateOf(const Edited& edited, const std::filesystem::path& folder) {
  const Scene& scene = edited.scene;
  const std::string file = (folder / "scene.glb").string();
  scene.exportTo(file);
  std::ifstream bytes(file, std::ios::binary);
  std::string state{std::istreambuf_iterator<char>(bytes), {}};
  state += scene.idManifest();
  for (const size_t count :
       {scene.nodes().size(), scene.instances().size(), scene.materials().size(), scene.meshes().size(),
        scene.textures().size(), scene.lights().size(), scene.cameras().size(), scene.animations().size()})
    state += " " + std::to_string(count);
  return state;
}

// What happens to an edit whose nth allocation fails.
enum class Outcome { Fails, SucceedsWithout, HasFewer };

Outcome outcomeOf(int allocation, const Edit& edit, Edited& edited) {
  const Call call = edit.prepare(edited);
  try {
    const int count = test::allocationsOf(call, allocation);
    return count < allocation ? Outcome::HasFewer : Outcome::SucceedsWithout;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::OutOfMemory);
  } catch (const std::bad_alloc&) {
    ADD_FAILURE() << "std::bad_alloc for allocation " << allocation;
  }
  return Outcome::Fails;
}

class OutOfMemory : public testing::TestWithParam<Edit> {};

TEST_P(OutOfMemory, LeavesTheSceneUnchanged) {
  const app::Folder folder;
  const Edit& edit = GetParam();
  std::string before, after;
  {
    Edited undisturbed;
    before = stateOf(undisturbed, folder.path());
    edit.prepare(undisturbed)();
    after = stateOf(undisturbed, folder.path());
  }
  for (int allocation = 1; allocation < 2000; ++allocation) {
    Edited edited;
    const Outcome outcome = outcomeOf(allocation, edit, edited);
    if (outcome == Outcome::HasFewer) return;
    if (outcome == Outcome::Fails) {
      if (!edit.mayBePartial) {
        ASSERT_TRUE(stateOf(edited, folder.path()) == before) << "allocation " << allocation;
      }
      edit.prepare(edited)();
    }
    ASSERT_TRUE(stateOf(edited, folder.path()) == after) << "allocation " << allocation;
  }
  FAIL() << "the edit never succeeds";
}

// The renderer existed before the failures.
TEST_P(OutOfMemory, LeavesRenderersUpToDate) {
  Edited edited;
  Renderer renderer(edited.scene, latelight::test::testDevice());
  Options options;
  options.width = options.height = 16;
  const Camera camera = edited.scene.cameras().front();
  renderer.render(camera, options);
  for (int allocation = 1; allocation < 2000; ++allocation)
    if (outcomeOf(allocation, GetParam(), edited) != Outcome::Fails) break;
  Renderer other(edited.scene, latelight::test::testDevice());
  EXPECT_TRUE(renderer.render(camera, options).rgba == other.render(camera, options).rgba);
}

// Each allocation of an image after edits fails in turn. The next image is that of a new renderer: the device has the
// whole scene, and nothing that was destroyed is used. The device follows the edits in the first hundreds of
// allocations.
TEST(OutOfMemoryTest, TheNextImageShowsAllEdits) {
  constexpr Transform kFar{1, 0, 0, 1e6, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // moves the origin of the device's scene
  Options options;
  options.width = options.height = 16;
  const int step = test::rounds(1, 7), last = test::rounds(3000, 400);
  int failures = 0;
  for (int allocation = 1; allocation < last; allocation += step) {
    Edited edited;
    const Camera camera = edited.scene.cameras().front();
    Renderer renderer(edited.scene, test::testDevice());
    renderer.render(camera, options);
    const Handle<Material> added = edited.scene.addMaterial({.name = "paint"});
    edited.scene.setTexture(added, TextureSlot::BaseColor, TextureUse{.texture = edited.unusedTexture});
    edited.scene.addInstance(edited.unusedMesh, added, kMoved);
    edited.scene.setTransform(edited.twin, kFar);
    try {
      if (test::allocationsOf([&] { renderer.render(camera, options); }, allocation) < allocation) break;
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ExitCode::OutOfMemory);
      ++failures;
    }
    Renderer other(edited.scene, test::testDevice());
    ASSERT_TRUE(renderer.render(camera, options).rgba == other.render(camera, options).rgba)
        << "allocation " << allocation;
  }
  EXPECT_GT(failures, 10);
}

INSTANTIATE_TEST_SUITE_P(Edits, OutOfMemory, testing::ValuesIn(kEdits),
                         [](const testing::TestParamInfo<Edit>& edit) { return std::string(edit.param.name); });

}  // namespace
}  // namespace latelight
