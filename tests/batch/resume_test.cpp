// Batches that are killed, changed or damaged: after --resume, the data set equals that of an undisturbed run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <random>
#include <set>
#include <sstream>

#include "batch/sets.h"
#include "long_tests.h"
#include "output/read.h"

namespace latelight::data {
namespace {

namespace fs = std::filesystem;
using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

const std::vector<std::string> kJob{"--scenes",  "builtin:boxes",
                                    "--repeat",  "400",
                                    "--formats", R"({"format": "files", "outputs": ["color", "depth", "id"]})",
                                    "--name",    "{variation}/{camera}"};

app::Command job(const Folder& folder, const std::string& set, std::vector<std::string> more = {}) {
  std::vector<std::string> all = kJob;
  all.insert(all.end(), {"-o", set});
  all.insert(all.end(), more.begin(), more.end());
  return batch(folder, all);
}

// The lines of the shard's log: its first line, and one per finished frame.
auto linesOf(const Folder& folder, const std::string& set) {
  return std::ranges::count(folder.read(set + "/.latelight/shard-0-of-1.jsonl"), '\n');
}

// Kills the job repeatedly and compares all visible files each time. Every fifth time this happens after a random time
// during its start, before it has a frame; otherwise once it has finished a random number of further frames, from one
// to more than the set still needs. A finished set is started over. Returns how often some frames existed and others
// were missing.
int killOften(const Folder& folder, const std::string& set, int times, uint32_t seed,
              const std::map<std::string, std::string>& whole) {
  std::mt19937 random(seed);
  int partly = 0;
  for (int kills = 0; kills < times;) {
    app::Command command = job(folder, set, {"--resume", "--threads", std::to_string(1 + random() % 3)});
    const auto enough = std::max(linesOf(folder, set), 1l) + 1 + static_cast<long>(random() % 60);
    if (kills % 5 == 0)
      command.timeout = std::chrono::milliseconds(random() % 400);
    else
      command.until = [&] { return linesOf(folder, set) >= enough; };
    const Outcome outcome = latelight(command);
    EXPECT_TRUE(outcome.signal == SIGKILL || outcome.code == 0) << outcome.text();
    const std::map<std::string, std::string> there = filesOf(folder, set);
    expectPartOf(there, whole);
    if (outcome.code == 0) fs::remove_all(folder.path() / set);
    kills += outcome.code != 0;
    partly += !there.empty() && there.size() < whole.size();
  }
  return partly;
}

TEST(Resume, AHundredKillsLeaveTheSetOfAnUndisturbedRun) {
  Folder folder;
  const Outcome undisturbed = latelight(job(folder, "whole", {"--validate"}));
  ASSERT_EQ(undisturbed.code, 0) << undisturbed.text();
  const auto whole = filesOf(folder, "whole");
  ASSERT_EQ(whole.size(), 400 * 4 + 1u);
  const int kills = latelight::test::rounds(50, 10);
  app::inPairs(2, [&](size_t i) {
    const std::string set = "killed" + std::to_string(i);
    EXPECT_GT(killOften(folder, set, kills, static_cast<uint32_t>(i), whole), kills / 5);
    const Outcome last = latelight(job(folder, set, {"--resume"}));
    EXPECT_EQ(last.code, 0) << last.text();
    expectSame(filesOf(folder, set), whole);
  });
  for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
    EXPECT_FALSE(entry.path().string().ends_with(".latelight-tmp")) << entry.path();
}

app::Command small(const Folder& folder, std::vector<std::string> more, const char* repeat = "3",
                   const char* scene = "builtin:boxes") {
  std::vector<std::string> all{"--scenes", scene, "--repeat", repeat, "-o", "set"};
  all.insert(all.end(), more.begin(), more.end());
  return batch(folder, all);
}

std::string logOf(const Folder& folder) {
  return folder.read("set/.latelight/log");
}

TEST(Resume, AFinishedSetIsLeftAsItIs) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {})).code, 0);
  const auto before = filesOf(folder, "set");
  const Outcome again = latelight(small(folder, {}));
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("'set' already contains a data set: add --resume"));
  EXPECT_EQ(latelight(small(folder, {"--resume"})).code, 0);
  EXPECT_THAT(logOf(folder), HasSubstr("begins: 0 of 3 frames"));
  expectSame(filesOf(folder, "set"), before);
}

TEST(Resume, OtherSettingsAreRenderedAgainAndLeaveNothing) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {"--formats", R"({"format": "files", "pattern": "{name}.exr"})"})).code, 0);
  ASSERT_EQ(latelight(small(folder, {"--resume", "--exposure", "1"})).code, 0);
  const auto resumed = filesOf(folder, "set");
  fs::remove_all(folder.path() / "set");
  ASSERT_EQ(latelight(small(folder, {"--exposure", "1"})).code, 0);
  expectSame(resumed, filesOf(folder, "set"));
}

// Ends a log after its first lines, the plan and the stale files, as if the process was killed after it had replaced
// files and before it had recorded them.
void forgetFrames(const Folder& folder, const std::string& log) {
  const std::string text = folder.read(log);
  const size_t frames = text.find("{\"frame\"");
  ASSERT_NE(frames, text.npos) << text;
  folder.write(log, std::string_view(text).substr(0, frames));
}

// The files of both jobs have the same names and sizes.
TEST(Resume, AnInterruptedOtherJobLeavesNothingInTheFirstOne) {
  for (const char* format : {"npz", "webdataset"})
    for (const bool isKilled : {false, true}) {
      Folder folder;
      ASSERT_EQ(latelight(small(folder, {"--formats", format}, "4")).code, 0);
      const auto before = filesOf(folder, "set");
      const Outcome other =
          latelight(small(folder, {"--formats", format, "--exposure", "2", "--shard", "0/2", "--resume"}, "4"));
      ASSERT_EQ(other.code, 0) << other.text();
      EXPECT_EQ(latelight({.arguments = {"batch", "status", "set"}, .folder = folder.path()}).code, 6);
      if (isKilled) forgetFrames(folder, "set/.latelight/shard-0-of-2.jsonl");
      const Outcome back = latelight(small(folder, {"--formats", format, "--resume"}, "4"));
      EXPECT_EQ(back.code, 0) << back.text();
      expectSame(filesOf(folder, "set"), before);
    }
}

// Both runs in between are killed, the second one before it renders a frame of the first job again.
TEST(Resume, TwoInterruptedRunsLeaveNothingInTheFirstJob) {
  Folder folder;
  const std::vector<std::string> part{"--formats", "npz", "--shard", "0/2", "--resume"};
  ASSERT_EQ(latelight(small(folder, {"--formats", "npz"}, "4")).code, 0);
  const auto before = filesOf(folder, "set");
  std::vector<std::string> other = part;
  other.insert(other.end(), {"--exposure", "2"});
  ASSERT_EQ(latelight(small(folder, other, "4")).code, 0);
  const std::string replaced = folder.read("set/000001.npz");
  EXPECT_FALSE(replaced == before.at("000001.npz"));
  fs::remove(folder.path() / "set/000001.npz");
  fs::create_directory(folder.path() / "set/000001.npz");  // the frame fails, so the set is not merged
  EXPECT_EQ(latelight(small(folder, part, "4")).code, 6);
  fs::remove(folder.path() / "set/000001.npz");
  folder.write("set/000001.npz", std::string_view(replaced));
  // Another part ends as the last one.
  EXPECT_EQ(latelight(small(folder, {"--formats", "npz", "--shard", "1/2", "--resume"}, "4")).code, 0);
  EXPECT_EQ(latelight({.arguments = {"batch", "status", "set"}, .folder = folder.path()}).code, 6);
  const Outcome back = latelight(small(folder, {"--formats", "npz", "--resume"}, "4"));
  EXPECT_EQ(back.code, 0) << back.text();
  expectSame(filesOf(folder, "set"), before);
}

// The files of a scene, which contain the frame's index, are those of other frames while another scene precedes it.
TEST(Resume, AnInterruptedJobWithMoreScenesLeavesNothingInTheFirstOne) {
  for (const std::string_view first : {R"({"asset": )", kCameraAlone}) {
    Folder folder;
    folder.write("b.gltf", std::string_view(kCameraAlone));
    const auto run = [&](std::vector<std::string> more) {
      more.insert(more.end(), {"--scenes", "?.gltf", "--repeat", "2", "--name", "{scene}-{variation}", "--formats",
                               "boxes", "-o", "set"});
      return latelight(batch(folder, more));
    };
    ASSERT_EQ(run({}).code, 0);
    const auto before = filesOf(folder, "set");
    folder.write("a.gltf", first);
    const bool isBroken = first != kCameraAlone;
    const Outcome more = isBroken ? run({"--resume"}) : run({"--resume", "--shard", "1/2"});
    EXPECT_EQ(more.code, isBroken ? 6 : 0) << more.text();
    EXPECT_FALSE(folder.read("set/boxes/b-0.json") == before.at("boxes/b-0.json"));
    if (!isBroken) forgetFrames(folder, "set/.latelight/shard-1-of-2.jsonl");
    fs::remove(folder.path() / "a.gltf");
    const Outcome back = run({"--resume"});
    EXPECT_EQ(back.code, 0) << back.text();
    expectSame(filesOf(folder, "set"), before);
  }
}

// The formats of the stored job write the files of the whole set.
TEST(Resume, ARejectedJobLeavesTheStoredOne) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {"--formats", "coco"})).code, 0);
  const std::string job = folder.read("set/.latelight/job.json");
  const Outcome rejected = latelight(
      small(folder, {"--formats", "bop", "--cameras", R"({"type": "scene", "names": ["missing"]})", "--resume"}));
  EXPECT_EQ(rejected.code, 2) << rejected.text();
  EXPECT_EQ(folder.read("set/.latelight/job.json"), job);
  const Outcome merged = latelight({.arguments = {"batch", "merge", "set"}, .folder = folder.path()});
  EXPECT_EQ(merged.code, 0) << merged.text();
}

TEST(Resume, MoreVariationsAreRenderedBesideThoseThatAreThere) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {})).code, 0);
  ASSERT_EQ(latelight(small(folder, {"--resume"}, "5")).code, 0);
  EXPECT_THAT(logOf(folder), HasSubstr("begins: 2 of 5 frames"));
  const auto resumed = filesOf(folder, "set");
  fs::remove_all(folder.path() / "set");
  ASSERT_EQ(latelight(small(folder, {}, "5")).code, 0);
  expectSame(resumed, filesOf(folder, "set"));
}

TEST(Resume, FewerVariationsLeaveNothingOfTheOthers) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {}, "5")).code, 0);
  ASSERT_EQ(latelight(small(folder, {"--resume"})).code, 0);
  const auto resumed = filesOf(folder, "set");
  EXPECT_EQ(resumed.size(), 3 + 1u);
}

TEST(Resume, ASmallerJobLeavesNoFoldersOfOthers) {
  const auto folders = [](const Folder& folder) {
    std::set<std::string> names;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder.path() / "set"))
      if (entry.is_directory()) names.insert(entry.path().lexically_relative(folder.path() / "set").string());
    return names;
  };
  Folder folder;
  const auto render = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--scenes", "builtin:boxes", "--name", "{scene}/{variation}/{index}", "-o", "set",
                             "--formats", "npz", "--formats", "depth-png"});
    const Outcome outcome = latelight(batch(folder, more));
    EXPECT_EQ(outcome.code, 0) << outcome.text();
  };
  render({"--repeat", "2", "--scenes", "builtin:spheres"});
  EXPECT_THAT(folders(folder), testing::IsSupersetOf({"spheres/1", "boxes/1", "depth/spheres", "depth/spheres/1"}));
  render({"--resume"});
  EXPECT_THAT(folders(folder),
              testing::UnorderedElementsAre(".latelight", "boxes", "boxes/0", "depth", "depth/boxes", "depth/boxes/0"));
}

TEST(Resume, ADamagedFileIsFoundAndMadeAgain) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {})).code, 0);
  const auto before = filesOf(folder, "set");
  std::string damaged = before.at("000001.png");
  damaged[damaged.size() / 2] ^= 1;
  folder.write("set/000001.png", damaged);
  const Outcome verify = latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()});
  EXPECT_EQ(verify.code, 3);
  EXPECT_THAT(verify.err, HasSubstr("'000001.png' is not as it was written"));
  fs::remove(folder.path() / "set/000001.png");
  EXPECT_EQ(latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()}).code, 3);
  ASSERT_EQ(latelight(small(folder, {"--resume"})).code, 0);
  EXPECT_EQ(latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()}).code, 0);
  expectSame(filesOf(folder, "set"), before);
}

// A batch would replace the files to which they lead.
TEST(Resume, LinksThatLeadOutOfTheSetAreRejected) {
  Folder folder;
  ASSERT_EQ(latelight(small(folder, {})).code, 0);
  const auto before = filesOf(folder, "set");
  const auto verify = [&] { return latelight({.arguments = {"batch", "verify", "set"}, .folder = folder.path()}); };
  const auto expectRejected = [&](const std::string& link, const fs::path& target) {
    const fs::path path = folder.path() / "set" / link;
    fs::create_symlink(target, path);
    const std::string sentence = "'set/" + link + "' is a link that does not lead to a file of the data set";
    const Outcome resumed = latelight(small(folder, {"--resume"}, "5"));
    EXPECT_EQ(resumed.code, 2) << resumed.text();
    EXPECT_THAT(resumed.err, HasSubstr(sentence));
    const Outcome verified = verify();
    EXPECT_EQ(verified.code, 3) << verified.text();
    EXPECT_THAT(verified.err, HasSubstr(sentence));
    const Outcome merged = latelight({.arguments = {"batch", "merge", "set"}, .folder = folder.path()});
    EXPECT_EQ(merged.code, 2) << merged.text();
    fs::remove(path);
  };
  folder.write("mine", before.at("000001.png"));  // verify compares its contents, which are the same
  fs::create_directory(folder.path() / "others");
  fs::remove(folder.path() / "set/000001.png");
  for (const fs::path& target : {folder.path() / "mine", fs::path("../mine")}) expectRejected("000001.png", target);
  expectRejected("000004.png", "../missing");
  expectRejected("000004.png", "000004.png");
  expectRejected("more", folder.path() / "others");
  expectRejected("set", "..");
  EXPECT_EQ(folder.read("mine"), before.at("000001.png"));
  EXPECT_FALSE(fs::exists(folder.path() / "missing"));
  // Links in the set, and to it.
  fs::rename(folder.path() / "set", folder.path() / "others/there");
  fs::create_symlink("others/there", folder.path() / "set");
  folder.write("set/stored", before.at("000001.png"));
  fs::create_symlink("stored", folder.path() / "set/000001.png");
  fs::create_symlink(folder.path() / "set", folder.path() / "set/itself");
  EXPECT_EQ(verify().code, 0);
  EXPECT_EQ(latelight(small(folder, {"--resume"}, "5")).code, 0);
  EXPECT_EQ(verify().code, 0);
}

TEST(Resume, AChangedSceneIsRenderedAgain) {
  Folder folder;
  const std::string gltf = kCameraAlone;
  folder.write("scene.gltf", gltf);
  ASSERT_EQ(latelight(small(folder, {}, "3", "scene.gltf")).code, 0);
  folder.write("scene.gltf", gltf + " ");
  ASSERT_EQ(latelight(small(folder, {"--resume"}, "3", "scene.gltf")).code, 0);
  EXPECT_THAT(logOf(folder), HasSubstr("begins: 3 of 3 frames are to be rendered\n"));
  ASSERT_EQ(latelight(small(folder, {"--resume"}, "3", "scene.gltf")).code, 0);
  EXPECT_THAT(logOf(folder), HasSubstr("begins: 0 of 3 frames"));
}

// Renders a set with these options, changes a file, and expects that --resume renders all frames again, once, and that
// the set then equals that of an undisturbed run.
void expectRenderedAgain(const Folder& folder, const std::vector<std::string>& options,
                         const std::function<void()>& change) {
  const auto run = [&](const std::string& set, std::vector<std::string> more = {}) {
    more.insert(more.end(), options.begin(), options.end());
    more.insert(more.end(), {"--repeat", "2", "-o", set});
    return latelight(batch(folder, more));
  };
  const Outcome first = run("set");
  ASSERT_EQ(first.code, 0) << first.text();
  change();
  const Outcome again = run("set", {"--resume"});
  ASSERT_EQ(again.code, 0) << again.text();
  const auto lines = [&] {
    std::vector<std::string> lines;
    std::istringstream log(logOf(folder));
    for (std::string line; std::getline(log, line);)
      if (line.find(" begins: ") != std::string::npos) lines.push_back(line.substr(line.find("begins: ") + 8));
    return lines;
  };
  EXPECT_EQ(lines().back(), "2 of 2 frames are to be rendered");
  ASSERT_EQ(run("undisturbed").code, 0);
  expectSame(filesOf(folder, "set"), filesOf(folder, "undisturbed"));
  ASSERT_EQ(run("set", {"--resume"}).code, 0);
  EXPECT_EQ(lines().back(), "0 of 2 frames are to be rendered");
  fs::remove_all(folder.path() / "set");
  fs::remove_all(folder.path() / "undisturbed");
}

// A Radiance picture of two pixels with this exponent, and red, green and blue of 128.
std::string radiance(char exponent) {
  const std::string pixel{'\x80', '\x80', '\x80', exponent};
  return "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + pixel + pixel;
}

TEST(Resume, ChangedEnvironmentsOfVariationsAreRenderedAgain) {
  Folder folder;
  folder.write("sky.hdr", radiance('\x81'));
  expectRenderedAgain(folder,
                      {"--scenes", "builtin:boxes", "--variations",
                       R"([{"type": "environments", "environments": ["studio", "sky.hdr"]}])"},
                      [&] { folder.write("sky.hdr", radiance('\x82')); });
}

TEST(Resume, ChangedTexturesOfVariationsAreRenderedAgain) {
  Folder folder;
  for (const char* exposure : {"0", "3"})
    ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "--exposure", exposure, "-o", exposure})).code, 0);
  fs::create_directory(folder.path() / "textures");
  folder.write("textures/a.png", folder.read("0/000000.png"));
  const auto options = [](const std::string& files) {
    return std::vector<std::string>{"--scenes", "builtin:boxes", "--variations",
                                    R"([{"type": "textures", "materials": "*", )" + files + "}]"};
  };
  expectRenderedAgain(folder, options(R"("files": "textures/a.png")"),
                      [&] { folder.write("textures/a.png", folder.read("3/000000.png")); });
  expectRenderedAgain(folder, options(R"("folder": "textures")"),
                      [&] { folder.write("textures/b.png", folder.read("0/000000.png")); });
  expectRenderedAgain(folder, options(R"("folder": "textures")"),
                      [&] { fs::rename(folder.path() / "textures/b.png", folder.path() / "textures/c.png"); });
}

const char* const kTriangle = "mtllib o.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 0 1\nvt 0 0\nf 1/1 2/1 3/1\n";

TEST(Resume, ChangedFilesOfScatteredObjectsAreRenderedAgain) {
  Folder folder;
  folder.write("o.obj", std::string_view(kTriangle));
  folder.write("o.mtl", std::string_view("newmtl m\nKd 1 0 0\n"));
  expectRenderedAgain(folder,
                      {"--scenes", "builtin:boxes", "--variations",
                       R"([{"type": "scatter", "objects": [{"file": "o.obj"}], "count": 3,
                            "min": [-1, -1, 0], "max": [1, 1, 2]}])"},
                      [&] { folder.write("o.mtl", std::string_view("newmtl m\nKd 0 1 0\n")); });
}

// Scenes of a job with several are planned without their textures.
TEST(Resume, ChangedTexturesOfSeveralScenesAreRenderedAgain) {
  Folder folder;
  for (const char* exposure : {"0", "3"})
    ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "--exposure", exposure, "-o", exposure})).code, 0);
  folder.write("o.mtl", std::string_view("newmtl m\nmap_Kd t.png\n"));
  folder.write("t.png", folder.read("0/000000.png"));
  for (const char* name : {"a.obj", "b.obj"}) folder.write(name, std::string_view(kTriangle));
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.end(),
                {"--scenes", "?.obj", "--cameras", R"({"type": "orbit", "count": 1, "distance": 4})", "-o", "set"});
    return latelight(batch(folder, more));
  };
  ASSERT_EQ(run({}).code, 0);
  folder.write("t.png", folder.read("3/000000.png"));
  ASSERT_EQ(run({"--resume"}).code, 0);
  const std::string log = logOf(folder), begins = "begins: 2 of 2 frames";
  EXPECT_NE(log.find(begins), log.rfind(begins)) << log;
}

TEST(Resume, ChangedCategoriesAreRenderedAgain) {
  Folder folder;
  folder.write("rules.json", std::string_view(R"({"plastic": "cup"})"));
  const std::vector<std::string> options{"--scenes",  "builtin:boxes",
                                         "--formats", R"({"format": "coco", "categories": "rules.json"})",
                                         "--formats", R"({"format": "yolo", "categories": "rules.json"})"};
  expectRenderedAgain(folder, options,
                      [&] { folder.write("rules.json", std::string_view(R"({"plastic": "mug", "metal": "pot"})")); });
}

// Returns the picture that the command render writes for the frame.
TEST(Resume, AFrameIsThePictureOfRender) {
  Folder folder;
  ASSERT_EQ(latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", "set", "--name", "{camera}"})).code, 0);
  const Outcome outcome = latelight({.arguments = {"render", "builtin:boxes", "--device", "cpu", "--camera", "main",
                                                   "--size", "32x24", "-o", "render.png"},
                                     .folder = folder.path()});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_FALSE(folder.read("render.png").empty());
  EXPECT_TRUE(folder.read("render.png") == folder.read("set/main.png"));
}

}  // namespace
}  // namespace latelight::data
