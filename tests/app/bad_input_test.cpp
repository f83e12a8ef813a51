// Damaged input files end with exit code 0 or 3 and a one-sentence message, never with a signal, another code or a
// hang.
#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "app/damage.h"
#include "app/process.h"
#include "base/error.h"
#include "base/log.h"
#include "long_tests.h"
#include "own_process.h"
#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"
#include "scene/load/load.h"
#include "scene/scene.h"

namespace latelight::app {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kSecondsACase = 3600;  // a case that runs longer hangs and is killed

// --- many cases per process -----------------------------------------------------------------------------------------

// "scenes 0 600": the kind, the first case and the end of the range
constexpr const char* kRange = "LATELIGHT_TEST_CASES";

// Checks the indices that the renderer relies on. Invalid ones would be read out of bounds on the device.
std::string flawOf(const scene::Scene& scene) {
  const auto inRange = [](int64_t i, size_t count) { return i >= 0 && static_cast<size_t>(i) < count; };
  for (const scene::Mesh& mesh : scene.meshes) {
    if (mesh.attributes.size() != mesh.positions.size()) return "attributes do not match the positions";
    if (!mesh.extras.empty() && mesh.extras.size() != mesh.positions.size()) return "extras do not match the positions";
    if (mesh.indices.size() % 3 != 0) return "indices are no triangles";
    for (const uint32_t i : mesh.indices)
      if (!inRange(i, mesh.positions.size())) return "an index is out of range";
    for (const glm::vec3 p : mesh.positions)
      if (!std::isfinite(p.x + p.y + p.z)) return "a position is not finite";
  }
  for (const scene::Material& material : scene.materials)
    for (const scene::TextureSlot& slot : material.slots)
      if (slot.texture != -1 && !inRange(slot.texture, scene.textures.size())) return "a texture is out of range";
  for (const scene::Texture& texture : scene.textures)
    if (texture.width == 0 || texture.height == 0 || !texture.pixels) return "a texture is empty";
  for (const scene::Instance& instance : scene.instances)
    if (!inRange(instance.mesh, scene.meshes.size()) || !inRange(instance.material, scene.materials.size()) ||
        !inRange(instance.node, scene.nodes.size()) || instance.id == 0)
      return "an instance is out of range";
  return "";
}

std::string flawOf(const std::string& sentence, const std::string& file) {
  if (sentence.find(file) == std::string::npos) return "the sentence does not name the file";
  for (const unsigned char c : sentence)
    if (c < 0x20 || c == 0x7f) return "the sentence has control characters";
  return "";
}

// The minimum number of cases of each kind that the program must detect.
void planted(unsigned seed) {
  if (seed == 1) std::abort();
  if (seed == 2) throw std::bad_alloc();
  if (seed == 3) fail(ExitCode::Internal, "not the file's fault");
  if (seed == 4) badInput("a sentence that names no file");
  if (seed == 5)
    for (alarm(1);;) pause();
}

// Returns how the program mishandled this case; empty if it handled it correctly.
std::string load(const std::string& kind, unsigned seed, const fs::path& path) {
  try {
    if (kind == "scenes") return flawOf(scene::load(path.string()));
    if (kind == "pictures") scene::readPicture(path);
    if (kind == "environments") scene::loadEnvironment(path.string());
    if (kind == "planted") planted(seed);
  } catch (const Error& error) {
    const std::string flaw = flawOf(error.what(), path.filename().string());
    if (error.code() == ExitCode::BadInput && flaw.empty()) return "";
    return fmt::format("code {}: {} ({})", static_cast<int>(error.code()), error.what(), flaw);
  } catch (const std::exception& error) {
    return fmt::format("not an Error: {}", error.what());
  }
  return "";
}

// The tests below run this in another process. It prints "> <case>" before each case, so that the parent process can
// tell in which one it ended.
TEST(BadInputInAProcess, DISABLED_Batch) {
  char kind[32];
  unsigned first = 0, end = 0;
  ASSERT_EQ(std::sscanf(std::getenv(kRange), "%31s %u %u", kind, &first, &end), 3);
  setQuiet(true);
  const std::vector<GoodScene>& good = std::string(kind) == "scenes" ? goodScenes() : goodPictures();
  for (unsigned seed = first; seed < end; ++seed) {
    const Damage broken = damage(good, seed);
    Folder folder;
    const fs::path path = writeTo(folder, broken);
    std::printf("> %u\n", seed);
    std::fflush(stdout);
    alarm(kSecondsACase);
    const std::string flaw = load(kind, seed, path);
    alarm(0);
    if (!flaw.empty()) std::printf("! %s: %s\n", broken.what.c_str(), flaw.c_str());
  }
  std::printf("done\n");
}

// Returns the last case that a batch had begun when it ended early.
unsigned lastCase(const std::string& out) {
  const size_t at = out.rfind("> ");
  return at == std::string::npos ? 0 : static_cast<unsigned>(std::strtoul(out.c_str() + at + 2, nullptr, 10));
}

void expectNoHarm(const std::string& kind, const std::vector<GoodScene>& good, unsigned count) {
  Folder scratch;  // for the files that a killed batch does not remove
  test::runAllShardsInChildren();
  for (unsigned first = 0; first < count;) {
    const Outcome batch = runProcess(
        "/proc/self/exe", {.arguments = {"--gtest_filter=BadInputInAProcess.*", "--gtest_also_run_disabled_tests"},
                           .environment = {{kRange, fmt::format("{} {} {}", kind, first, count)},
                                           {"GTEST_OUTPUT", ""},
                                           {"TMPDIR", scratch.path().string()}}});
    for (size_t at = batch.out.find("\n! "); at != std::string::npos; at = batch.out.find("\n! ", at + 1))
      ADD_FAILURE() << batch.out.substr(at + 3, batch.out.find('\n', at + 1) - at - 3);
    if (batch.code == 0 && batch.out.find("\ndone\n") != std::string::npos) return;
    ASSERT_THAT(batch.out, testing::HasSubstr("> ")) << batch.text();
    const unsigned last = lastCase(batch.out);
    ADD_FAILURE() << damage(good, last).what << ": " << batch.text();
    first = last + 1;
  }
}

TEST(BadInput, GoodFilesAreGood) {
  Folder folder;
  for (const GoodScene& scene : goodScenes()) {
    writeTo(folder, {"", scene.main, scene.files});
    const std::string file = folder.at(scene.main);
    EXPECT_GT(scene::load(file).triangleCount(), 0u) << scene.name;
  }
  for (const GoodScene& picture : goodPictures()) {
    writeTo(folder, {"", picture.main, picture.files});
    EXPECT_EQ(scene::readPicture(folder.at(picture.main)).width, 64u) << picture.name;
  }
}

// A batch in which no case fails would prove nothing.
TEST(BadInput, BatchesCatchWhatIsPlanted) {
  testing::TestPartResultArray failures;
  {
    testing::ScopedFakeTestPartResultReporter reporter(
        testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &failures);
    expectNoHarm("planted", goodPictures(), 7);
  }
  ASSERT_EQ(failures.size(), 5);
  for (int i = 0; i < 5; ++i)
    EXPECT_THAT(failures.GetTestPartResult(i).message(), testing::HasSubstr("case " + std::to_string(i + 1) + ","));
}

// The damage must pass the first check, or the test covers nothing else.
TEST(BadInput, DamageIsVaried) {
  std::set<std::string> sentences;
  unsigned unharmed = 0;
  setQuiet(true);
  for (unsigned seed = 0; seed < 200; ++seed) {
    Folder folder;
    const fs::path path = writeTo(folder, damage(goodScenes(), seed));
    try {
      scene::load(path.string());
      ++unharmed;
    } catch (const Error& error) {
      sentences.insert(std::string(error.what()).substr(path.string().size()));
    }
  }
  setQuiet(false);
  EXPECT_GT(unharmed, 20u);
  EXPECT_GT(sentences.size(), 40u);
}

TEST(BadInput, EightHundredDamagedScenes) {
  expectNoHarm("scenes", goodScenes(), 800);
}
TEST(BadInput, TwoHundredDamagedPictures) {
  expectNoHarm("pictures", goodPictures(), 200);
}
TEST(BadInput, DamagedEnvironmentsUpToTheirMaps) {
  expectNoHarm("environments", goodPictures(), 16);
}

// --- complete program runs ------------------------------------------------------------------------------------------

struct Rendered {
  std::string what;
  Outcome outcome;
  std::vector<std::string> left;  // files that did not exist before
};

// Runs render at 64x36 in the folder of the damaged files.
Rendered renderDamaged(const std::vector<GoodScene>& good, unsigned seed) {
  Folder folder;
  const Damage broken = damage(good, seed);
  writeTo(folder, broken);
  std::set<std::string> before;
  for (const std::string& name : folder.names()) before.insert(name);
  std::vector<std::string> arguments{"render", "-o", "picture.png", "--size", "64x36", "--device", "cpu", "--quiet"};
  if (&good == &goodScenes())
    arguments.push_back(broken.main);
  else
    arguments.insert(arguments.end(), {"builtin:boxes", "--hdri", broken.main});
  Rendered result{broken.what, latelight({.arguments = arguments, .folder = folder.path()}), {}};
  for (const std::string& name : folder.names())
    if (!before.contains(name)) result.left.push_back(name);
  return result;
}

void expectWholeOrRefused(const Rendered& rendered) {
  const Outcome& outcome = rendered.outcome;
  SCOPED_TRACE(rendered.what);
  ASSERT_TRUE(outcome.code == 0 || outcome.code == 3) << outcome.text();
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), outcome.code == 0 ? 0 : 1) << outcome.err;
  const std::vector<std::string> expected =
      outcome.code == 0 ? std::vector<std::string>{"picture.png"} : std::vector<std::string>{};
  EXPECT_EQ(rendered.left, expected);
}

TEST(BadInput, AHundredDamagedFilesThroughTheProgram) {
  const unsigned scenes = latelight::test::rounds(80u, 20u), pictures = scenes / 4;
  constexpr unsigned kFirst = 5000;
  std::vector<Rendered> all(scenes + pictures);
  inPairs(all.size(), [&](size_t i) {
    all[i] = renderDamaged(i < scenes ? goodScenes() : goodPictures(), kFirst + static_cast<unsigned>(i));
  });
  for (const Rendered& rendered : all) expectWholeOrRefused(rendered);
}

// --- malformed files of test collections ----------------------------------------------------------------------------

constexpr const char* kAssimp = "/usr/share/assimp/models/glTF2";

// Parts of the paths of files that need not fail: their names state the defect, or they require an extension.
constexpr const char* kRefused[] = {"techniqueWebGL",  "BoxWithInfinites", "IncorrectVertexArrays",
                                    "IndexOutOfRange", "MissingBin",       "RecursiveNodes",
                                    "SchemaFailures",  "NoScene.gltf",     "wrongTypes"};

TEST(BadInput, EveryAssimpTestModel) {
  if (!fs::exists(kAssimp)) GTEST_SKIP() << "Debian's assimp-testmodels is not installed.";
  std::vector<fs::path> files;
  for (const char* folder : {"/usr/share/assimp/models/glTF2", "/usr/share/assimp/models/glTF"})
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  EXPECT_GE(files.size(), 50u);
  // test_scene loads all of them.
  const size_t step = latelight::test::runsInFull() ? 1 : 4;
  for (size_t i = 0; i * step < files.size(); ++i) files[i] = files[i * step];
  files.resize((files.size() + step - 1) / step);
  Folder folder;
  std::vector<Outcome> outcomes(files.size());
  inPairs(files.size(), [&](size_t i) {
    outcomes[i] = latelight({"render", files[i].string(), "-o", folder.at(std::to_string(i) + ".png"), "--size",
                             "64x36", "--device", "cpu", "--quiet"});
  });
  for (size_t i = 0; i < files.size(); ++i) {
    const std::string name = files[i].lexically_relative(fs::path(kAssimp).parent_path()).string();
    const bool old = name.starts_with("glTF/");  // glTF 1.0
    const bool refused = old || std::any_of(std::begin(kRefused), std::end(kRefused),
                                            [&](const char* part) { return name.find(part) != std::string::npos; });
    std::printf("exit %d  %s  %s", outcomes[i].code, name.c_str(),
                outcomes[i].err.empty() ? "\n" : outcomes[i].err.c_str());
    EXPECT_EQ(outcomes[i].code, refused ? 3 : 0) << name << ": " << outcomes[i].text();
    EXPECT_EQ(fs::exists(folder.at(std::to_string(i) + ".png")), !refused) << name;
  }
}

}  // namespace
}  // namespace latelight::app
