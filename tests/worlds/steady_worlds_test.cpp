// A long run of an agent's loop: thousands of calls with random changes of worlds whose arrays shaders convert, for
// results that stay on the device. After a few calls, nothing grows and nothing is created.
#include <malloc.h>

#include <cmath>
#include <cstring>
#include <deque>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <optional>
#include <random>

#include "long_tests.h"
#include "models/models.h"
#include "render/submit/session.h"
#include "render/support.h"
#include "render/visibility/compute/place_worlds_push.h"
#include "scene/edit.h"
#include "scene/file_frame.h"
#include "scene/load/load.h"
#include "vk/read_back.h"

namespace latelight::render::test {
namespace {

using glm::dmat4;
using glm::dvec3;

constexpr uint32_t kSteadyWorlds = 6, kSteadyWidth = 16, kSteadyHeight = 12, kWarmUpCalls = 10;

// Matrices of double[4][4], row by row.
std::vector<double> rowsOf(std::span<const dmat4> matrices) {
  std::vector<double> rows;
  for (const dmat4& matrix : matrices)
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column) rows.push_back(matrix[column][row]);
  return rows;
}

// The values of one step: the transforms of all instances, those that exist, and the camera's pose, per world.
struct Step {
  std::vector<dmat4> transforms;  // to the file's frame
  std::vector<uint8_t> exists;
  std::vector<dmat4> poses;         // in the file's frame
  std::vector<double> positions;    // of the scene's lights, in the file's frame
  std::vector<double> intensities;  // of the scene's lights; some are 0
  uint32_t broken = kSteadyWorlds;  // world with a NaN; kSteadyWorlds: none
};

Step randomStep(const scene::Scene& scene, const scene::Camera& camera, std::mt19937& random) {
  std::uniform_real_distribution<double> offset(-0.4, 0.4);
  const auto moved = [&](const dmat4& matrix) {
    const dvec3 by(offset(random), offset(random), offset(random));
    return glm::rotate(glm::translate(dmat4(1), by), offset(random), dvec3(0, 1, 0)) * matrix;
  };
  Step step;
  const dmat4 pose = openCvPose(camera, scene, false);
  for (uint32_t world = 0; world < kSteadyWorlds; ++world) {
    for (const scene::Instance& instance : scene.instances) {
      step.transforms.push_back(moved(glm::inverse(scene::worldFromFile(scene)) * instance.toWorld));
      step.exists.push_back(random() % 8 != 0);
    }
    step.poses.push_back(moved(pose));
    for (const scene::Light& light : scene.lights) {
      const dvec3 position =
          moved(glm::translate(dmat4(1), dvec3(scene::fileFromWorld(scene) * glm::dvec4(light.position, 1))))[3];
      step.positions.insert(step.positions.end(), {position.x, position.y, position.z});
      step.intensities.push_back(random() % 4 ? light.intensity : 0);
    }
  }
  if (random() % 5 == 0) {
    step.broken = static_cast<uint32_t>(random() % kSteadyWorlds);
    const size_t instance = step.broken * scene.instances.size() + random() % scene.instances.size();
    const double wrong = random() % 2 ? std::numeric_limits<double>::quiet_NaN() : INFINITY;
    step.transforms[instance][static_cast<int>(random() % 4)][static_cast<int>(random() % 3)] = wrong;
  }
  return step;
}

// Gives the step's arrays to the renderer in its own memory, as the API does with arrays of the host. `ownLights`: also
// those of lights.
WorldStates statesOf(Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera, const Step& step,
                     bool ownLights) {
  WorldStates worlds{.count = kSteadyWorlds};
  for (uint32_t i = 0; i < scene.instances.size(); ++i) worlds.instances.push_back(i);
  WorldInputs& inputs = worlds.inputs.emplace();
  inputs.cameras = {camera};
  std::vector<double> numbers = rowsOf(step.transforms);
  const uint64_t posesAt = numbers.size();
  for (const double number : rowsOf(step.poses)) numbers.push_back(number);
  const uint64_t positionsAt = numbers.size();
  numbers.insert(numbers.end(), step.positions.begin(), step.positions.end());
  const uint64_t intensitiesAt = numbers.size();
  numbers.insert(numbers.end(), step.intensities.begin(), step.intensities.end());
  const uint64_t existsAt = numbers.size() * sizeof(double);
  const std::shared_ptr<const vk::Buffer> memory = renderer.inputMemory(existsAt + (step.exists.size() + 15) / 16 * 16);
  std::memcpy(memory->mapped(), numbers.data(), existsAt);
  std::memcpy(memory->mapped() + existsAt, step.exists.data(), step.exists.size());
  const auto arrayAt = [&](uint64_t first) {
    return WorldArray{.address = memory->address() + first * sizeof(double), .element = shared::kNumberDouble};
  };
  inputs.transforms = arrayAt(0);
  inputs.cameraToWorld = arrayAt(posesAt);
  inputs.exists = memory->address() + existsAt;
  inputs.memory = {memory};
  if (!ownLights) return worlds;
  for (uint32_t i = 0; i < scene.lights.size(); ++i) worlds.lights.push_back(i);
  inputs.lights = scene.lights;
  inputs.lightPosition = arrayAt(positionsAt);
  inputs.lightIntensity = arrayAt(intensitiesAt);
  return worlds;
}

// More calls in flight than the renderer leaves unchecked: those that begin may have to repeat earlier ones first.
constexpr size_t kMostInFlight = 6;
constexpr uint32_t kGlassCopies = 60;  // more than fragment lists of the first calls have space for

// Adds blended copies of the last instance.
void addGlass(scene::Scene& scene) {
  const auto copied = static_cast<uint32_t>(scene.instances.size()) - 1;
  scene::Material glass = scene.materials[scene.instances[copied].material];
  glass.data.flags |= shared::kMaterialBlended;
  glass.data.baseColor.a = 0.1f;
  const uint32_t material = scene::addMaterial(scene, glass);
  for (uint32_t i = 0; i < kGlassCopies; ++i)
    scene::addInstance(scene, scene.instances[copied].mesh, material, scene.instances[copied].toWorld);
}

// Lights with shadow maps of all kinds.
void addLamps(scene::Scene& scene) {
  scene.lights.clear();
  scene.lights.push_back({.intensity = 8, .position = {1, 1, 2}});
  scene.lights.push_back({.type = shared::kLightSpot, .intensity = 30, .position = {-1, 1, 3}});
  scene.lights.push_back({.type = shared::kLightDirectional, .direction = glm::normalize(glm::vec3(0.3f, 0.2f, -1))});
}

// The part of an array that is a world's.
std::vector<std::byte> bytesOf(vk::Device& device, const ExportedArray& array, uint32_t world) {
  std::vector<std::byte> bytes(array.viewBytes());
  vk::readBack(device, array.memory->buffer, world * bytes.size(), bytes);
  return bytes;
}

// A picture with depth and ids, under a sun if there are shadows.
Settings steadySettings(Raster raster, ShadowFormat shadows) {
  Settings settings = settingsOf(kSteadyWidth, kSteadyHeight, {output::Aov::Depth, output::Aov::Id});
  settings.raster = raster;
  settings.lighting = &findTechnique("clustered");
  settings.display = true;
  settings.shadows = shadows;
  settings.samples = 1;
  if (shadows != ShadowFormat::None) settings.sun = SunLight{.azimuth = 0.7f, .elevation = 0.9f, .illuminance = 4};
  return settings;
}

class SteadyWorlds : public RenderTest {
 protected:
  // `shadows`: of a sun, whose maps shaders fit, or whose rays go through the hierarchy of each world. With rays,
  // surfaces also light each other.
  // `ownLights`: each world has positions and intensities of the scene's lights, which have shadows, too.
  static void run(uint32_t steps, ShadowFormat shadows, Raster raster = Raster::Compute,
                  Indirect indirect = Indirect::OneBounce, bool ownLights = false);
  static void overlap(Raster raster, ShadowFormat shadows, bool ownLights);
  // Compares a world with the same state as the only world of another renderer, whose records the host makes. (The
  // scene edited to the state may have another origin, and then depths that are rounded otherwise.)
  static void expectAlone(const RenderResult& result, const Step& step, uint32_t world, const scene::Scene& scene,
                          Renderer& alone, const Settings& settings, bool ownLights = false) {
    const size_t count = scene.instances.size();
    WorldStates state{.count = 1};
    for (uint32_t i = 0; i < count; ++i) {
      state.instances.push_back(i);
      state.transforms.push_back(scene::worldFromFile(scene) * step.transforms[world * count + i]);
      state.exists.push_back(step.exists[world * count + i]);
    }
    for (uint32_t i = 0; ownLights && i < scene.lights.size(); ++i) {
      const size_t row = world * scene.lights.size() + i;
      state.lights.push_back(i);
      scene::Light& light = state.lightValues.emplace_back(scene.lights[i]);
      light.position = scene::worldFromFile(scene) * glm::dvec4(glm::make_vec3(&step.positions[3 * row]), 1);
      light.intensity = static_cast<float>(step.intensities[row]);
    }
    scene::Camera camera = cameraOf(scene, kSteadyWidth, kSteadyHeight);
    camera.toWorld = toWorldFromOpenCv(step.poses[world], scene);
    const RenderResult expected = alone.submit({&camera, 1}, settings, {.worlds = state}, Results::Exported).take();
    for (size_t i = 0; i < expected.arrays.size(); ++i)
      EXPECT_TRUE(bytesOf(device(), result.arrays[i], world) == bytesOf(device(), expected.arrays[i], 0))
          << "array " << i;
  }
};

void SteadyWorlds::run(uint32_t steps, ShadowFormat shadows, Raster raster, Indirect indirect, bool ownLights) {
  scene::Scene scene = scene::load("builtin:boxes");
  if (ownLights) addLamps(scene);
  const scene::Environment studio = scene::loadEnvironment("studio");
  const scene::Camera camera = cameraOf(scene, kSteadyWidth, kSteadyHeight);
  Settings settings = steadySettings(raster, shadows);
  if (shadows == ShadowFormat::Rays) settings.indirect = indirect;
  Renderer renderer(device(), scene, &studio), alone(device(), scene, &studio);
  using enum Renderer::WorldLights;
  ASSERT_TRUE(renderer.placesWorlds(settings, {&camera, 1}, {}, ownLights ? InArrays : OfScene, false));
  std::mt19937 random(11);
  uint32_t replays = 0, invalid = 0;
  size_t heap = 0, compared = 0;
  RenderResult last;  // its arrays are released when the next ones are taken, as in an agent's loop
  const auto heapBytes = [] {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
  };
  for (uint32_t i = 0; i < steps && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    const Step step = randomStep(scene, camera, random);
    const uint64_t pipelines = device().pipelinesMade();
    const vk::Allocator::Statistics before = device().memory().statistics();
    const WorldStates worlds = statesOf(renderer, scene, camera, step, ownLights);
    last = renderer.submit({&camera, 1}, settings, {.worlds = worlds}, Results::Exported).take();
    const vk::Allocator::Statistics after = device().memory().statistics();
    if (i >= kWarmUpCalls) {
      EXPECT_EQ(device().pipelinesMade(), pipelines);
      EXPECT_LE(after.allocations, before.allocations);
      EXPECT_LE(after.usedBytes, before.usedBytes);
      EXPECT_LE(after.reservedBytes, before.reservedBytes);
      replays += last.statistics.replays;
    }
    for (uint32_t world = 0; world < kSteadyWorlds; ++world)
      EXPECT_EQ((last.worldStatus[world] & shared::kWorldInvalid) != 0, world == step.broken) << world;
    invalid += step.broken < kSteadyWorlds;
    const auto one = static_cast<uint32_t>(random() % kSteadyWorlds);
    if (i % 20 < 2 && one != step.broken) {
      expectAlone(last, step, one, scene, alone, settings, ownLights);
      ++compared;
    }
    if (i == std::min(100u, steps / 2)) heap = heapBytes();
  }
  EXPECT_EQ(replays, steps - kWarmUpCalls) << "steady calls submit recorded commands again";
  EXPECT_GT(invalid, 0u);
  // The validation layer keeps the names of objects that the other renderer has created.
  constexpr size_t kNames = 1536;
  EXPECT_LT(heapBytes(), heap + compared * kNames + (256u << 10)) << "of the host";
  EXPECT_TRUE(device().validationMessages().empty());
}

TEST_F(SteadyWorlds, NeitherGrowNorCreateAnything) {
  run(latelight::test::rounds(10'000u, 150u), ShadowFormat::None);
}

TEST_F(SteadyWorlds, NeitherGrowNorCreateAnythingWithShadows) {
  run(latelight::test::rounds(1'000u, 50u), ShadowFormat::D32);
}

TEST_F(SteadyWorlds, NeitherGrowNorCreateAnythingWithShadowsOfTheirLights) {
  run(latelight::test::rounds(1'000u, 50u), ShadowFormat::D32, Raster::Compute, Indirect::OneBounce, true);
}

TEST_F(SteadyWorlds, NeitherGrowNorCreateAnythingWithRays) {
  run(latelight::test::rounds(10'000u, 50u), ShadowFormat::Rays);
}

TEST_F(SteadyWorlds, NeitherGrowNorCreateAnythingWithVisibilityByRays) {
  run(latelight::test::rounds(10'000u, 50u), ShadowFormat::Rays, Raster::Rays);
}

TEST_F(SteadyWorlds, NeitherGrowNorCreateAnythingAlongPaths) {
  LATELIGHT_SKIP_UNLESS_ALL();
  run(1'000, ShadowFormat::Rays, Raster::Rays, Indirect::Path);
}

// Calls that differ in their arrays only are in flight together. Those that overflow are rendered again with their own
// arrays, after the calls that follow them.
void SteadyWorlds::overlap(Raster raster, ShadowFormat shadows, bool ownLights) {
  scene::Scene scene = scene::load("builtin:boxes");
  if (ownLights) addLamps(scene);
  const size_t opaque = scene.instances.size();
  addGlass(scene);
  const scene::Environment studio = scene::loadEnvironment("studio");
  const scene::Camera camera = cameraOf(scene, kSteadyWidth, kSteadyHeight);
  const Settings settings = steadySettings(raster, shadows);
  Renderer renderer(device(), scene, &studio), alone(device(), scene, &studio);
  std::mt19937 random(5);
  struct Call {
    Step step;
    Ticket ticket;
  };
  std::deque<Call> inFlight;
  uint32_t overlaps = 0;
  const auto take = [&] {
    const RenderResult result = inFlight.front().ticket.take();
    const Step& step = inFlight.front().step;
    for (uint32_t world = 0; world < kSteadyWorlds; ++world) {
      EXPECT_EQ((result.worldStatus[world] & shared::kWorldInvalid) != 0, world == step.broken) << world;
      if (world != step.broken) expectAlone(result, step, world, scene, alone, settings, ownLights);
    }
    inFlight.pop_front();
  };
  for (uint32_t call = 0; call < 12; ++call) {
    SCOPED_TRACE(call);
    Step step = randomStep(scene, camera, random);
    for (size_t i = 0; call < 6 && i < step.exists.size(); ++i)
      if (i % scene.instances.size() >= opaque) step.exists[i] = 0;
    const WorldStates worlds = statesOf(renderer, scene, camera, step, ownLights);
    Ticket ticket = renderer.submit({&camera, 1}, settings, {.worlds = worlds}, Results::Exported);
    overlaps += !inFlight.empty() && !inFlight.back().ticket.done();
    inFlight.push_back({std::move(step), std::move(ticket)});
    if (inFlight.size() == kMostInFlight) take();
  }
  while (!inFlight.empty()) take();
  if (device().isCpu()) {  // a GPU may have finished meanwhile
    EXPECT_GT(overlaps, 0u) << "no call was submitted before the one before it had finished";
  }
  EXPECT_TRUE(device().validationMessages().empty());
}

TEST_F(SteadyWorlds, OverlapAndOverflow) {
  overlap(Raster::Compute, ShadowFormat::Rays, false);
}

TEST_F(SteadyWorlds, OverlapAndOverflowWithShadows) {
  overlap(Raster::Compute, ShadowFormat::D32, false);
}

TEST_F(SteadyWorlds, OverlapAndOverflowWithShadowsOfTheirLights) {
  overlap(Raster::Compute, ShadowFormat::D32, true);
}

TEST_F(SteadyWorlds, OverlapAndOverflowWithVisibilityByRays) {
  overlap(Raster::Rays, ShadowFormat::Rays, false);
}

// Random transforms of the joints of the first skin in all worlds, or random vertices of the first mesh.
std::vector<float> randomDeformation(const scene::Scene& scene, bool joints, std::mt19937& random) {
  std::uniform_real_distribution<float> offset(-0.2f, 0.2f);
  std::vector<float> numbers;
  for (uint32_t world = 0; world < kSteadyWorlds; ++world) {
    for (size_t joint = 0; joints && joint < scene.rig.skins[0].joints.size(); ++joint)
      numbers.insert(numbers.end(), {1, 0, 0, offset(random), 0, 1, 0, offset(random), 0, 0, 1, offset(random)});
    for (size_t vertex = 0; !joints && vertex < scene.meshes[0].positions.size(); ++vertex)
      for (int axis = 0; axis < 3; ++axis) numbers.push_back(scene.meshes[0].positions[vertex][axis] + offset(random));
  }
  return numbers;
}

// Gives such numbers to the renderer in its own memory. `glass`: the copies that addGlass() added exist in all worlds
// or in none; otherwise the worlds list no instances.
WorldStates deformedWorlds(Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera, bool joints,
                           const std::vector<float>& numbers, std::optional<bool> glass = {}) {
  WorldStates worlds{.count = kSteadyWorlds};
  worlds.inputs.emplace().cameras = {camera};
  WorldDeformations& given = worlds.deformations;
  if (joints)
    given.joints = scene.rig.skins[0].joints;
  else
    given.meshes = {0};
  const uint64_t existsAt = numbers.size() * sizeof(float);
  const std::shared_ptr<const vk::Buffer> memory = renderer.inputMemory(existsAt + kSteadyWorlds * kGlassCopies);
  std::memcpy(memory->mapped(), numbers.data(), existsAt);
  if (glass) {
    for (uint32_t i = 0; i < kGlassCopies; ++i)
      worlds.instances.push_back(static_cast<uint32_t>(scene.instances.size()) - kGlassCopies + i);
    std::memset(memory->mapped() + existsAt, *glass ? 1 : 0, kSteadyWorlds * kGlassCopies);
    worlds.inputs->exists = memory->address() + existsAt;
  }
  given.memory = {memory};
  (joints ? given.jointTransforms : given.vertices)[0] =
      WorldArray{.address = memory->address(), .rows = 3, .element = shared::kNumberFloat};
  return worlds;
}

// The same for worlds that pose joints and move vertices: the arrays change in every call.
TEST_F(SteadyWorlds, DeformMeshesWithoutGrowth) {
  if (!device().isCpu()) GTEST_SKIP() << "the test reads arrays in the host's memory";
  const scene::Scene scene = scene::load(models::modelPath("skinned.glb").string());
  const scene::Camera camera = cameraOf(scene, kSteadyWidth, kSteadyHeight);
  Settings settings = settingsOf(kSteadyWidth, kSteadyHeight, {output::Aov::Depth, output::Aov::Motion});
  settings.raster = Raster::Compute;
  settings.lighting = &findTechnique("clustered");
  Renderer renderer(device(), scene, nullptr);
  std::mt19937 random(3);
  const uint32_t steps = latelight::test::rounds(400u, 40u);
  uint32_t replays = 0;
  RenderResult last;
  for (uint32_t i = 0; i < steps && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    const bool joints = i % 40 < 20;  // then vertices
    std::vector<float> numbers = randomDeformation(scene, joints, random);
    const uint32_t broken = static_cast<uint32_t>(random() % (2 * kSteadyWorlds));
    if (broken < kSteadyWorlds) numbers[broken * numbers.size() / kSteadyWorlds + 3] = NAN;
    const WorldStates worlds = deformedWorlds(renderer, scene, camera, joints, numbers);
    const uint64_t pipelines = device().pipelinesMade();
    const vk::Allocator::Statistics before = device().memory().statistics();
    last = renderer.submit({&camera, 1}, settings, {.worlds = worlds}, Results::Exported).take();
    const vk::Allocator::Statistics after = device().memory().statistics();
    for (uint32_t world = 0; world < kSteadyWorlds; ++world)
      EXPECT_EQ((last.worldStatus[world] & shared::kWorldInvalid) != 0, world == broken) << world;
    if (i % 20 < kWarmUpCalls) continue;
    EXPECT_EQ(device().pipelinesMade(), pipelines);
    EXPECT_LE(after.allocations, before.allocations);
    EXPECT_LE(after.usedBytes, before.usedBytes);
    EXPECT_EQ(last.statistics.replays, 1u) << "steady calls submit recorded commands again";
    replays += last.statistics.replays;
  }
  EXPECT_EQ(replays, steps / 20 * (20 - kWarmUpCalls));
  EXPECT_TRUE(device().validationMessages().empty());
}

// Calls with other joints or vertices are in flight together, and have the bytes of calls one after the other. Those
// that overflow are rendered again with their own arrays.
void overlapDeformed(vk::Device& device, bool joints, ShadowFormat shadows) {
  if (!device.isCpu()) GTEST_SKIP() << "the test reads arrays in the host's memory";
  scene::Scene scene = scene::load(models::modelPath("skinned.glb").string());
  addGlass(scene);
  const scene::Camera camera = cameraOf(scene, kSteadyWidth, kSteadyHeight);
  Settings settings = steadySettings(Raster::Compute, shadows);
  settings.aovs.push_back(output::Aov::Normal);
  const scene::Environment studio = scene::loadEnvironment("studio");
  Renderer renderer(device, scene, &studio), alone(device, scene, &studio);
  ASSERT_TRUE(renderer.placesWorlds(settings, {&camera, 1}, {}, Renderer::WorldLights::OfScene, joints));
  std::mt19937 random(7);
  struct Call {
    std::vector<float> numbers;
    bool glass;
    Ticket ticket;
  };
  std::deque<Call> inFlight;
  uint32_t overlaps = 0;
  const auto submit = [&](Renderer& to, const std::vector<float>& numbers, bool glass) {
    const WorldStates worlds = deformedWorlds(to, scene, camera, joints, numbers, glass);
    return to.submit({&camera, 1}, settings, {.worlds = worlds}, Results::Exported);
  };
  RenderResult before;
  const auto take = [&] {
    Call call = std::move(inFlight.front());
    inFlight.pop_front();
    RenderResult result = call.ticket.take();
    const RenderResult expected = submit(alone, call.numbers, call.glass).take();
    for (size_t i = 0; i < expected.arrays.size(); ++i)
      for (uint32_t world = 0; world < kSteadyWorlds; ++world)
        EXPECT_TRUE(bytesOf(device, result.arrays[i], world) == bytesOf(device, expected.arrays[i], world))
            << "array " << i << ", world " << world;
    if (!before.arrays.empty()) {
      EXPECT_FALSE(bytesOf(device, result.arrays[1], 0) == bytesOf(device, before.arrays[1], 0));
    }
    before = std::move(result);
  };
  for (uint32_t call = 0; call < 10; ++call) {
    SCOPED_TRACE(call);
    const bool glass = call >= 5;
    std::vector<float> numbers = randomDeformation(scene, joints, random);
    Ticket ticket = submit(renderer, numbers, glass);
    overlaps += !inFlight.empty() && !inFlight.back().ticket.done();
    inFlight.push_back({std::move(numbers), glass, std::move(ticket)});
    if (inFlight.size() == kMostInFlight) take();
  }
  while (!inFlight.empty()) take();
  EXPECT_GT(overlaps, 0u) << "no call was submitted before the one before it had finished";
  EXPECT_TRUE(device.validationMessages().empty());
}

TEST_F(SteadyWorlds, OverlapWithOtherJoints) {
  overlapDeformed(device(), true, ShadowFormat::None);
}

TEST_F(SteadyWorlds, OverlapWithOtherJointsAndRays) {
  overlapDeformed(device(), true, ShadowFormat::Rays);
}

TEST_F(SteadyWorlds, OverlapWithOtherVerticesAndShadowMaps) {
  overlapDeformed(device(), false, ShadowFormat::D32);
}

}  // namespace
}  // namespace latelight::render::test
