// Scenes that a program builds from scratch and reads back through the public API.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iterator>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>

#include "error_of.h"
#include "output/png.h"
#include "test_device.h"

namespace latelight {
namespace {

using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;

// A square of 2 m x 2 m that faces +Z, with an upright texture.
MeshData picture() {
  MeshData mesh;
  mesh.name = "picture";
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.uv = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  mesh.normals = std::vector(4, std::array{0.0f, 0.0f, 1.0f});
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

TextureData checks() {
  return {"checks", 2, 2, true, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255}};
}

Options square(std::vector<std::string> outputs) {
  Options options;
  options.width = options.height = 16;
  options.picture = false;
  options.aovs = std::move(outputs);
  return options;
}

std::vector<float> pixel(const Aov& aov, size_t x, size_t y) {
  const float* first = aov.values.data() + (y * 16 + x) * aov.channels;
  return {first, first + aov.channels};
}

TEST(MadeScene, IsEmptyAtFirst) {
  Scene scene;
  EXPECT_TRUE(scene.instances().empty());
  EXPECT_TRUE(scene.nodes().empty());
  EXPECT_FALSE(scene.bounds().has_value());
  const Frame frame =
      Renderer(scene, latelight::test::testDevice()).render(scene.defaultCamera(1), square({"depth", "id"}));
  EXPECT_TRUE(frame.rgba.empty());
  EXPECT_THAT(frame.aovs.at("depth").values, testing::Each(std::numeric_limits<float>::infinity()));
  EXPECT_THAT(frame.aovs.at("id").ids, testing::Each(0u));
}

TEST(MadeScene, ShowsItsTexturesTexels) {
  Scene scene;
  Renderer renderer(scene, latelight::test::testDevice());  // elements that are added later are uploaded, too
  const Camera camera = scene.lookAt({0, 0, 2}, {0, 0, 0}, 53.13010235f);  // the square fills the picture
  renderer.render(camera, square({"albedo"}));
  const auto material = scene.addMaterial({.name = "paint", .roughness = 1});
  const auto texture = scene.addTexture(checks());
  scene.setTexture(material, TextureSlot::BaseColor, TextureUse{.texture = texture, .smooth = false});
  scene.addInstance(scene.addMesh(picture()), material, Transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  const Frame frame = renderer.render(camera, square({"albedo", "depth"}));
  const Aov& albedo = frame.aovs.at("albedo");
  EXPECT_THAT(pixel(albedo, 3, 3), ElementsAre(1, 0, 0));
  EXPECT_THAT(pixel(albedo, 12, 3), ElementsAre(0, 1, 0));
  EXPECT_THAT(pixel(albedo, 3, 12), ElementsAre(0, 0, 1));
  EXPECT_THAT(pixel(albedo, 12, 12), ElementsAre(1, 1, 1));
  EXPECT_THAT(frame.aovs.at("depth").values, testing::Each(FloatNear(2, 1e-5f)));
  scene.setTexture(material, TextureSlot::BaseColor, {});
  EXPECT_THAT(pixel(renderer.render(camera, square({"albedo"})).aovs.at("albedo"), 3, 3), ElementsAre(1, 1, 1));
}

TEST(MadeScene, GivesBackWhatItWasMadeOf) {
  Scene scene;
  const auto mesh = scene.addMesh(picture());
  const MeshData read = scene.meshData(mesh);
  EXPECT_EQ(read.positions, picture().positions);
  EXPECT_EQ(read.uv, picture().uv);
  EXPECT_EQ(read.indices, picture().indices);
  EXPECT_THAT(read.normals, testing::Each(ElementsAre(0, 0, 1)));
  const auto texture = scene.addTexture(checks());
  EXPECT_EQ(scene.textureData(texture).rgba, checks().rgba);
  const auto material = scene.addMaterial({});
  EXPECT_FALSE(scene.textureOf(material, TextureSlot::Emissive).has_value());
  scene.setTexture(material, TextureSlot::Emissive, TextureUse{.texture = texture, .wrapU = Wrap::Clamp});
  EXPECT_EQ(scene.textureOf(material, TextureSlot::Emissive)->texture, texture);
  EXPECT_EQ(scene.textureOf(material, TextureSlot::Emissive)->wrapU, Wrap::Clamp);
  scene.addInstance(mesh, material, Transform{2, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 7, 0, 0, 0, 1}, "wall");
  EXPECT_THAT(scene.bounds()->min, ElementsAre(3, -1, 7));
  EXPECT_THAT(scene.bounds()->max, ElementsAre(7, 1, 7));
  ASSERT_EQ(scene.nodes().size(), 1u);
  EXPECT_EQ(scene.nodes()[0].path, "/wall");
  EXPECT_EQ(scene.nodes()[0].transform, scene.instance(scene.instances()[0]).transform);
}

TEST(MadeScene, GivesBackTheLayersOfItsMaterials) {
  Scene scene;
  Material glass;
  glass.name = "glass";
  glass.clearcoat = 0.5f, glass.clearcoatRoughness = 0.25f, glass.clearcoatNormalScale = 2;
  glass.sheenColor = {0.25f, 0.5f, 0.75f}, glass.sheenRoughness = 0.5f;
  glass.anisotropy = 0.5f, glass.anisotropyRotation = 90;
  glass.iridescence = 1, glass.iridescenceIor = 1.5f;
  glass.iridescenceThinnest = 50, glass.iridescenceThickest = 500;
  glass.transmission = 0.75f, glass.thickness = 2, glass.dispersion = 3;
  glass.attenuationColor = {0.5f, 1, 0.25f};
  glass.diffuseTransmission = 0.125f, glass.diffuseTransmissionColor = {1, 0.5f, 0};
  const Handle<Material> handle = scene.addMaterial(glass);
  const Material found = scene.material(handle);
  EXPECT_EQ(found.clearcoat, 0.5f);
  EXPECT_EQ(found.clearcoatRoughness, 0.25f);
  EXPECT_EQ(found.clearcoatNormalScale, 2);
  EXPECT_EQ(found.sheenColor, glass.sheenColor);
  EXPECT_EQ(found.sheenRoughness, 0.5f);
  EXPECT_EQ(found.anisotropy, 0.5f);
  EXPECT_NEAR(found.anisotropyRotation, 90, 1e-4);
  EXPECT_EQ(found.iridescence, 1);
  EXPECT_EQ(found.iridescenceIor, 1.5f);
  EXPECT_EQ(found.iridescenceThinnest, 50);
  EXPECT_EQ(found.iridescenceThickest, 500);
  EXPECT_EQ(found.transmission, 0.75f);
  EXPECT_EQ(found.thickness, 2);
  EXPECT_EQ(found.dispersion, 3);
  EXPECT_EQ(found.attenuationColor, glass.attenuationColor);
  EXPECT_EQ(found.attenuationDistance, std::numeric_limits<float>::infinity());
  EXPECT_EQ(found.diffuseTransmission, 0.125f);
  EXPECT_EQ(found.diffuseTransmissionColor, glass.diffuseTransmissionColor);
  const Handle<Texture> texture = scene.addTexture(checks());
  scene.setTexture(handle, TextureSlot::DiffuseTransmissionColor, TextureUse{.texture = texture, .uvSet = 1});
  EXPECT_EQ(scene.textureOf(handle, TextureSlot::DiffuseTransmissionColor).value().texture, texture);
  EXPECT_FALSE(scene.textureOf(handle, TextureSlot::SheenColor).has_value());
  glass.attenuationDistance = 0;
  EXPECT_THAT(errorOf([&] { scene.setMaterial(handle, glass); }), HasSubstr("attenuation distance"));
  glass.attenuationDistance = 4;
  scene.setMaterial(handle, glass);
  EXPECT_EQ(scene.material(handle).attenuationDistance, 4);
}

TEST(MadeScene, HasTheCamerasThatAreAdded) {
  Scene scene;
  Camera camera = scene.lookAt({1, 2, 3}, {0, 0, 0}, 50);
  camera.name = "front";
  camera.principalX = 0.25f;
  camera.lens = Lens{.width = 64, .height = 48, .fx = 70, .fy = 60, .cx = 30, .cy = 20};
  scene.addCamera(camera);
  const Camera& read = scene.cameras().at(0);
  EXPECT_EQ(read.name, "front");
  EXPECT_EQ(read.principalX, 0.25f);
  EXPECT_EQ(read.lens->fy, 60);
  for (size_t i = 0; i < 16; ++i) EXPECT_NEAR(read.cameraToWorld[i], camera.cameraToWorld[i], 1e-6);
}

TEST(MadeScene, IsLitByAnEnvironmentOfPixels) {
  Scene scene;
  Options options = square({"color"});
  options.background = "hdri";
  const EnvironmentData sky{64, 32, std::vector(64 * 32, std::array{0.25f, 0.5f, 2.0f})};
  const Frame frame = Renderer(scene, latelight::test::testDevice(), sky).render(scene.defaultCamera(1), options);
  EXPECT_THAT(pixel(frame.aovs.at("color"), 8, 8), ElementsAre(0.25f, 0.5f, 2.0f, 1));
  const auto wrong = [&] { Renderer(scene, latelight::test::testDevice(), EnvironmentData{32, 32, {}}); };
  EXPECT_THAT(errorOf(wrong), HasSubstr("twice as wide"));
}

TEST(MadeScene, RefusesWhatCannotBe) {
  Scene scene;
  const auto material = scene.addMaterial({});
  EXPECT_THAT(errorOf([&] { scene.addTexture({"a", 0, 1, true, {}}); }), HasSubstr("no pixels"));
  EXPECT_THAT(errorOf([&] { scene.addTexture({"a", 2, 1, true, {1, 2, 3}}); }), HasSubstr("3 bytes"));
  EXPECT_THAT(errorOf([&] { scene.setTexture(material, TextureSlot::Normal, TextureUse{}); }), HasSubstr("a texture"));
  EXPECT_THAT(errorOf([&] { encodePng(2, 2, {1, 2, 3}); }), HasSubstr("3 bytes are given"));
}

TEST(PublicPng, HoldsThePicture) {
  const std::vector<uint8_t> rgba{1, 2, 3, 255, 4, 5, 6, 128};
  const output::ReadImage read = output::decodePng(encodePng(2, 1, rgba), "memory");
  EXPECT_EQ(read.width, 2u);
  EXPECT_EQ(read.height, 1u);
}

TEST(PublicLists, HaveEveryOption) {
  std::set<std::string> names;
  for (const OptionInfo& option : optionInfos()) names.insert(option.name);
#define OPTION_NUMBER(type, member, name, ...) EXPECT_TRUE(names.contains(name)) << name;
#define OPTION_CHOICE(Enum, member, name, ...) EXPECT_TRUE(names.contains(name)) << name;
#include <latelight/options.def>
  const std::vector<OutputInfo> outputs = outputInfos();
  const auto id = std::ranges::find(outputs, "id", &OutputInfo::name);
  ASSERT_NE(id, outputs.end());
  EXPECT_TRUE(id->ids);
}

TEST(MadeScene, HasColorsThatAreFactors) {
  Scene scene;
  MeshData mesh = picture();
  mesh.colors.assign(4, {1, 0, 0.5f, 1});
  EXPECT_EQ(scene.meshData(scene.addMesh(mesh)).colors, mesh.colors);
  for (const float wrong : {200.0f, -0.5f}) {
    mesh.colors[3][0] = wrong;
    EXPECT_THAT(errorOf([&] { scene.addMesh(mesh); }), HasSubstr("\"picture\" must lie from 0 to 1, and one is"));
  }
  EXPECT_EQ(scene.meshes().size(), 1u);
}

TEST(Waiting, FinishReturnsWhenAllIsDone) {
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, latelight::test::testDevice());
  const Camera camera = scene.defaultCamera(1);
  std::vector<Ticket> tickets;
  for (int i = 0; i < 3; ++i) tickets.push_back(renderer.submit({camera, camera}, square({"depth"})));
  renderer.finish();
  for (const Ticket& ticket : tickets) EXPECT_TRUE(ticket.done());
  EXPECT_EQ(tickets[2].take().size(), 2u);
}

TEST(Waiting, EndsByWhatTheCheckThrows) {
  const Scene scene("builtin:hall,triangles=60k,lights=20");
  Renderer renderer(scene, latelight::test::testDevice());
  Options options = square({"depth"});
  options.width = options.height = 64;
  const Frame before = renderer.render(scene.defaultCamera(1), options);
  int checks = 0;
  renderer.whileWaiting([&] { throw std::runtime_error(std::to_string(++checks)); });
  Options large;
  large.width = large.height = 512;
  large.aa = "ss4";
  EXPECT_THROW(renderer.render(scene.defaultCamera(1), large), std::runtime_error);
  EXPECT_EQ(checks, 1);
  renderer.whileWaiting({});
  EXPECT_EQ(renderer.render(scene.defaultCamera(1), options).aovs.at("depth").values, before.aovs.at("depth").values);
}

// A call may consist of waits that are all shorter than the interval of the checks.
TEST(Waiting, ChecksAcrossShortWaits) {
  using std::chrono::steady_clock;
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, latelight::test::testDevice());
  const Camera camera = scene.defaultCamera(1);
  const Frame before = renderer.render(camera, square({"depth"}));
  int64_t checks = 0;
  renderer.whileWaiting([&] { ++checks; });
  const steady_clock::time_point start = steady_clock::now();
  while (steady_clock::now() - start < std::chrono::milliseconds(500)) renderer.render(camera, square({"depth"}));
  EXPECT_GE(checks, 3);
  EXPECT_LE(checks, (steady_clock::now() - start) / std::chrono::milliseconds(50) + 1);
  renderer.whileWaiting([&] { throw std::runtime_error("stop"); });
  for (int i = 0; i < 3; ++i)
    EXPECT_THROW(
        {
          while (steady_clock::now() - start < std::chrono::seconds(60)) {
            const Frame frame = renderer.render(camera, square({"depth"}));
            EXPECT_EQ(frame.aovs.at("depth").values, before.aovs.at("depth").values);
          }
        },
        std::runtime_error);
  renderer.whileWaiting({});
  EXPECT_EQ(renderer.render(camera, square({"depth"})).aovs.at("depth").values, before.aovs.at("depth").values);
}

// Waits until a callback that is set now is due in the next wait of this thread.
void passInterval() {
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
}

TEST(Waiting, RejectsCallsOfTheRendererFromItsCallback) {
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, latelight::test::testDevice());
  Renderer other(scene, latelight::test::testDevice());
  const Camera camera = scene.defaultCamera(1);
  const Options options = square({"depth"});
  const Frame before = renderer.render(camera, options);
  Ticket ticket = renderer.submit({camera}, options);
  const std::array<double, 3> origin{0, 0, 5}, direction{0, 0, -1};
  const std::function<void()> calls[] = {[&] { renderer.render(camera, options); },
                                         [&] { renderer.submit({camera}, options); },
                                         [&] {
                                           renderer.cast({&origin, 1}, {&direction, 1});
                                         },
                                         [&] {
                                           renderer.pick(camera, {{0, 0}}, options);
                                         },
                                         [&] { renderer.labels(camera, options); },
                                         [&] { renderer.finish(); },
                                         [&] { static_cast<void>(ticket.done()); },
                                         [&] { ticket.take(); }};
  std::vector<std::string> rejections;
  std::vector<float> depths;
  renderer.whileWaiting([&] {
    if (!rejections.empty()) return;
    for (const auto& call : calls) rejections.push_back(errorOf(call));
    depths = other.render(camera, options).aovs.at("depth").values;
  });
  passInterval();
  EXPECT_EQ(renderer.render(camera, options).aovs.at("depth").values, before.aovs.at("depth").values);
  EXPECT_EQ(rejections,
            std::vector<std::string>(std::size(calls),
                                     "the renderer is in use: a signal handler or callback that runs while it waits "
                                     "must not call it"));
  EXPECT_EQ(depths, before.aovs.at("depth").values);
  EXPECT_EQ(ticket.take().front().aovs.at("depth").values, before.aovs.at("depth").values);
}

// The callback of another renderer that is called in between does not change which renderer is in use.
TEST(Waiting, RejectsCallsFromCallbacksWithinCallbacks) {
  const Scene scene("builtin:boxes");
  Renderer first(scene, latelight::test::testDevice());
  Renderer second(scene, latelight::test::testDevice());
  const Camera camera = scene.defaultCamera(1);
  std::vector<std::string> rejections;
  second.whileWaiting([&] { rejections.push_back(errorOf([&] { first.render(camera, square({"depth"})); })); });
  first.whileWaiting([&] {
    first.whileWaiting({});
    passInterval();
    second.render(camera, square({"depth"}));
  });
  passInterval();
  first.render(camera, square({"depth"}));
  ASSERT_FALSE(rejections.empty());
  EXPECT_THAT(rejections.front(), HasSubstr("is in use"));
}

// The state of the callback that runs outlives its replacement. The sanitizer reports a use after free.
TEST(Waiting, TheCallbackMayReplaceItself) {
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, latelight::test::testDevice());
  const Camera camera = scene.defaultCamera(1);
  std::vector<std::string> texts;
  renderer.whileWaiting([&renderer, &texts, text = std::string(100, 'a')] {
    renderer.whileWaiting([&texts] { texts.push_back("second"); });
    texts.push_back(text);
  });
  while (texts.size() < 2) {
    passInterval();
    renderer.render(camera, square({"depth"}));
  }
  EXPECT_THAT(texts, ElementsAre(std::string(100, 'a'), "second"));
}

// Pictures and a ray, with the results of calls that wait undisturbed.
struct AwaitedWork {
  Scene scene{"builtin:boxes"};
  Renderer renderer{scene, latelight::test::testDevice()};
  Camera camera = scene.defaultCamera(1);
  Options options = square({"depth"});
  std::array<double, 3> origin{0, 0, 5}, direction{0, 0, -1};
  std::vector<float> depths = renderer.render(camera, options).aovs.at("depth").values;
  std::vector<float> distances = renderer.cast({&origin, 1}, {&direction, 1}).distance;
};

TEST(Waiting, TheCallbackMayDestroyOrMoveTheTicketThatWaits) {
  AwaitedWork work;
  const auto takeWhile = [&](const auto& take, const std::function<void()>& change) {
    int changes = 0;
    work.renderer.whileWaiting([&] { changes++ == 0 ? change() : void(); });
    passInterval();
    auto result = take();
    EXPECT_GT(changes, 0);
    work.renderer.whileWaiting({});
    return result;
  };
  auto pictures = std::make_unique<Ticket>(work.renderer.submit({work.camera}, work.options));
  const std::vector<Frame> frames = takeWhile([&] { return pictures->take(); }, [&] { pictures.reset(); });
  EXPECT_EQ(frames.front().aovs.at("depth").values, work.depths);

  auto arrays = std::make_unique<Ticket>(work.renderer.submit({work.camera}, work.options, Results::Arrays));
  const auto taken = takeWhile([&] { return arrays->takeArrays(); }, [&] { arrays.reset(); });
  std::vector<float> copied(work.depths.size());
  taken.at("depth").copyToHost(std::as_writable_bytes(std::span(copied)));
  EXPECT_EQ(copied, work.depths);

  float distance = 0;
  auto rays = std::make_unique<CastTicket>(
      work.renderer.submitCast({&work.origin, 1}, {&work.direction, 1}, CastTargets{.distance = &distance}));
  takeWhile([&] { return rays->take(), true; }, [&] { rays.reset(); });
  EXPECT_EQ(std::vector{distance}, work.distances);

  Ticket moved = work.renderer.submit({work.camera}, work.options),
         other = work.renderer.submit({work.camera}, work.options);
  EXPECT_EQ(takeWhile([&] { return moved.take(); }, [&] { other = std::move(moved); }).size(), 1u);
  EXPECT_TRUE(other.done());
  EXPECT_THAT(errorOf([&] { other.take(); }), HasSubstr("taken already"));
}

TEST(Waiting, TicketsCanBeTakenAfterAnException) {
  AwaitedWork work;
  Ticket pictures = work.renderer.submit({work.camera}, work.options);
  Ticket arrays = work.renderer.submit({work.camera}, work.options, Results::Arrays);
  float distance = 0;
  CastTicket rays =
      work.renderer.submitCast({&work.origin, 1}, {&work.direction, 1}, CastTargets{.distance = &distance});
  const auto interrupt = [&](const std::function<void()>& take) {
    work.renderer.whileWaiting([] { throw std::runtime_error("stop"); });
    passInterval();
    EXPECT_THROW(take(), std::runtime_error);
    work.renderer.whileWaiting({});
  };
  interrupt([&] { pictures.take(); });
  interrupt([&] { arrays.takeArrays(); });
  interrupt([&] { rays.take(); });
  EXPECT_EQ(pictures.take().front().aovs.at("depth").values, work.depths);
  std::vector<float> copied(work.depths.size());
  arrays.takeArrays().at("depth").copyToHost(std::as_writable_bytes(std::span(copied)));
  EXPECT_EQ(copied, work.depths);
  rays.take();
  EXPECT_EQ(std::vector{distance}, work.distances);
  EXPECT_THAT(errorOf([&] { pictures.take(); }), HasSubstr("taken already"));
  EXPECT_THAT(errorOf([&] { arrays.takeArrays(); }), HasSubstr("taken already"));
  EXPECT_THAT(errorOf([&] { rays.take(); }), HasSubstr("taken already"));
}

}  // namespace
}  // namespace latelight
