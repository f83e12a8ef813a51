// Jobs as files and as options: their values, and the messages for invalid ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "base/error.h"
#include "base/memory.h"
#include "data/batch/job.h"
#include "data/batch/schema.h"
#include "data/scene_files.h"
#include "render/options/options.h"

namespace latelight::data {
namespace {

using app::Folder;
using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::string wrongIn(std::string_view name, std::string_view text) {
  Folder folder;
  folder.write(name, text);
  try {
    makeJob(readJobFile(folder.at(name)));
  } catch (const Error& error) {
    EXPECT_THAT(error.code(), AnyOf(ExitCode::Usage, ExitCode::BadInput));
    std::string sentence = error.what();
    const std::string path = folder.path().string() + "/";
    for (size_t at; (at = sentence.find(path)) != std::string::npos;) sentence.erase(at, path.size());
    return sentence;
  }
  return "";
}

TEST(Job, SaysTheSameInBothLanguages) {
  Folder folder;
  folder.write(
      "job.json",
      std::string_view(R"({"scenes": ["builtin:boxes"], "output": "set", "repeat": 3, "seed": 18446744073709551615,
    "options": {"size": "64x48", "exposure": -1.5, "time": 2, "loop": true, "shadow-lights": 4}})"));
  folder.write("job.yaml", std::string_view(R"(# comments, as YAML has them
scenes: [builtin:boxes]
output: set
repeat: 3
seed: 18446744073709551615
options: {size: 64x48, exposure: -1.5, time: 2, loop: true, shadow-lights: 4}
)"));
  const JobDocument json = readJobFile(folder.at("job.json")), yaml = readJobFile(folder.at("job.yaml"));
  EXPECT_EQ(json.json, yaml.json);
  EXPECT_EQ(yaml.lines.at("options.exposure"), 6);
  const Job job = makeJob(yaml);
  EXPECT_EQ(job.folder, "set");
  EXPECT_THAT(job.scenes, ElementsAre("builtin:boxes"));
  EXPECT_EQ(job.repeat, 3u);
  EXPECT_EQ(job.seed, 18446744073709551615u);
  EXPECT_EQ(job.settings.width, 64u);
  EXPECT_FLOAT_EQ(job.settings.exposure.ev, -1.5f);
  EXPECT_TRUE(job.settings.loop);
  EXPECT_EQ(job.settings.shadowLights.most, 4u);
}

TEST(Job, FilesHaveNamesInAnyCase) {
  Folder folder;
  const std::string_view rules = R"({"front$": "sign"})";
  folder.write("RULES.JSON", rules);
  using Json = nlohmann::ordered_json;
  Json job{{"scenes", "builtin:boxes"}, {"output", "set"}};
  job["formats"].push_back({{"format", "coco"}, {"categories", folder.at("RULES.JSON")}});
  for (const char* name : {"JOB.JSON", "JOB.YAML", "JOB.Yml"}) {
    folder.write(name, job.dump());  // JSON is YAML, too
    const JobDocument document = readJobFile(folder.at(name));
    EXPECT_EQ(document.json, job) << name;
    EXPECT_EQ(makeJob(document).formats.at(0).options["categories"], Json::parse(rules)) << name;
  }
}

// The loaders of other formats than glTF list only images that they read.
TEST(Job, FormatsOfScenesAreRecognizedInAnyCase) {
  for (const char* source : {"a.glb", "A.GLB", "a.gltf", "A.glTF", "builtin:boxes"})
    EXPECT_FALSE(listsFilesOnlyWithTextures(source)) << source;
  for (const char* source : {"a.obj", "A.OBJ", "glb"}) EXPECT_TRUE(listsFilesOnlyWithTextures(source)) << source;
}

TEST(Job, PatternsAreFilledIn) {
  Folder folder;
  for (const char* name : {"b.glb", "a.glb", "c.gltf"}) folder.write(name, std::string_view("x"));
  JobDocument document;
  document.json = {{"scenes", {folder.at("*.glb"), "builtin:hall"}}, {"output", "set"}};
  EXPECT_THAT(makeJob(document).scenes, ElementsAre(folder.at("a.glb"), folder.at("b.glb"), "builtin:hall"));
}

TEST(Job, ScenesHaveTangentsForNormalMapsOfVariations) {
  JobDocument document;
  document.json = {{"scenes", "builtin:boxes"}, {"output", "set"}};
  EXPECT_FALSE(makeJob(document).load.tangents);
  document.json["variations"] = {{{"type", "textures"}, {"slot", "normal"}, {"files", {"n.png"}}}};
  EXPECT_TRUE(makeJob(document).load.tangents);
}

TEST(Job, WrongOnesAreToldByKeyAndLine) {
  const std::string start = "scenes: builtin:boxes\noutput: set\n";
  const std::pair<std::string, std::string> yaml[] = {
      {"sizes: 3\n", "job.yaml:3: sizes: unknown key"},
      {"options:\n  exposur: 1\n", "job.yaml:4: options.exposur: unknown key"},
      {"options:\n  exposure: bright\n", "job.yaml:4: options.exposure: --exposure takes a number"},
      {"options:\n  bloom: 7\n", "job.yaml:4: options.bloom takes a number from 0 to 1, not 7"},
      {"options:\n  tonemap: red\n",
       "job.yaml:4: options.tonemap takes khronos, aces, agx, reinhard or none, not \"red\""},
      {"options:\n  size: 64\n", "job.yaml:4: options.size: --size takes"},
      {"options:\n  loop: 1\n", "job.yaml:4: options.loop takes true or false, not 1"},
      {"options:\n  animation: Foo\n", "job.yaml:4: options.animation: --animation and --loop require --time"},
      {"options:\n  fps: 3\n  loop: true\n", "job.yaml:5: options.loop: --animation and --loop require --time"},
      {"options:\n  bayer: rggb\n  aa: fxaa\n", "job.yaml:5: options.aa: --aa fxaa smooths the finished picture"},
      {"options:\n  aa: fxaa\n  full-well: 1000\n", "job.yaml:4: options.aa: --aa fxaa smooths the finished picture"},
      {"options:\n  size: 8x8\n  black-level: 5000\n",
       "job.yaml:5: options.black-level: --black-level 5000 must be below the highest value of --bit-depth 12"},
      {"options:\n  aa: msaa4\n  shadows: rays\n", "job.yaml:4: options.aa: --aa msaa4 does not sample --shadows rays"},
      {"options:\n  normals: octahedral\n  layout: killzone2\n",
       "job.yaml:4: options.normals: --normals does not apply to the layout killzone2"},
      {"options:\n  layout: exact\n  position: reciprocal\n  lighting: forward\n",
       "job.yaml:5: options.position: --position does not apply to the layout exact"},
      {"options: 7\n", "job.yaml:3: options takes an object of keys and values, not 7"},
      {"repeat: 0\n", "job.yaml:3: repeat takes a whole number from 1 to 1e+06, not 0"},
      {"repeat: 1.5\n", "job.yaml:3: repeat takes a whole number"},
      {"seed: -1\n", "job.yaml:3: seed takes a whole number from 0, not -1"},
      {"repeat: \"2\"\n", "job.yaml:3: repeat takes a whole number from 1 to 1e+06, not \"2\""},
      {"formats: []\n", "job.yaml:3: formats is an empty list"},
      {"formats:\n  - files\n  - painting\n", "job.yaml:5: formats[1]: there is no format \"painting\""},
      {"formats: [{outputs: [depth]}]\n", "job.yaml:3: formats[0]: the key \"format\" must name the format"},
      {"formats: [{format: files, outputs: [dept]}]\n", "job.yaml:3: formats[0]: "},
      {"formats: [{format: files, pattern: all.png}]\n", "job.yaml:3: formats[0]: pattern must contain {name}"},
      {"formats: [{format: files, pattern: \"../{name}.png\"}]\n",
       "job.yaml:3: formats[0]: pattern must be a path below"},
      {"formats: [{format: files, outputs: [position]}]\n", "job.yaml:3: formats[0]: a PNG file cannot store position"},
      {"formats:\n  - {format: coco, keypoints: [{name: a}]}\n  - boxes\n  - {format: yolo, keypoints: [{name: b}]}\n",
       "job.yaml:6: formats[2]: the keypoints of the format yolo differ from those of the format coco"},
      {"hdri: sky.hdr\n", "job.yaml:3: hdri: there is no file \"sky.hdr\""},
      {"name: \"\"\n", "job.yaml:3: name is empty"},
      {"repeat: 2\nrepeat: 3\n", "job.yaml:4: the key repeat is there twice"},
      {"options: {exposure: 1\n", "it is not YAML"},
      {"a: &a [*a, *a]\n", "job.yaml:3: an alias stands within what it names"},
      {"? [a]\n: b\n", "job.yaml:3: a key is a text"},
      {"---\nscenes: builtin:hall\n", "job.yaml:3: a second document begins"},
      {"---\n---\nscenes: builtin:hall\n", "job.yaml:4: a second document begins"},
      {"---\n,\n", "job.yaml:4: it is not YAML"},
  };
  for (const auto& [text, sentence] : yaml) EXPECT_THAT(wrongIn("job.yaml", start + text), HasSubstr(sentence)) << text;
  // The sensor reads only pictures, and a larger bit depth has a larger highest value.
  EXPECT_EQ(wrongIn("job.yaml", start + "options: {aa: fxaa, bayer: rggb}\nformats: [depth-png]\n"), "");
  EXPECT_EQ(wrongIn("job.yaml", start + "options: {black-level: 5000, bit-depth: 14}\n"), "");
  EXPECT_THAT(wrongIn("job.yaml", "output: set\n"), HasSubstr("the key \"scenes\" is missing"));
  EXPECT_THAT(wrongIn("job.yaml", "scenes: [no/*.glb]\noutput: set\n"),
              HasSubstr("job.yaml:1: scenes[0]: no file matches"));
  EXPECT_THAT(wrongIn("job.yaml", "scenes: [builtin:boxes, builtin:boxes]\noutput: set\n"),
              HasSubstr("is listed twice"));
  EXPECT_THAT(wrongIn("job.yaml", "scenes: [builtin:boxes,\n no.glb]\noutput: set\n"),
              HasSubstr("job.yaml:2: scenes[1]: there is no file \"no.glb\""));
  EXPECT_THAT(wrongIn("job.yaml", "- a\n"), HasSubstr("a job is an object"));
  EXPECT_EQ(wrongIn("job.yaml", ""), "job.yaml: a job is an object of keys and values");
  EXPECT_THAT(wrongIn("job.json", ""), HasSubstr("job.json:1: it is not JSON"));
  EXPECT_THAT(wrongIn("job.txt", ""), HasSubstr("does not end in a language"));
}

// Names of files end at a NUL, so frames whose names differ after it would replace each other. Elements of scenes may
// have such names.
TEST(Job, NamesOfFilesHaveNoNul) {
  const auto wrong = [](const std::string& keys) {
    return wrongIn("job.json", R"({"scenes": "builtin:boxes", )" + keys);
  };
  EXPECT_EQ(
      wrong(R"("output": "set", "name": "a\u0000{index}"})"),
      R"(job.json:1: name has a NUL character, which names of files cannot have, in "a\u0000{index}": remove it)");
  EXPECT_THAT(wrong(R"("output": "set\u0000"})"), HasSubstr("job.json:1: output has a NUL character"));
  EXPECT_THAT(wrong(R"("output": "set", "formats": ["boxes", {"format": "files", "pattern": "a\u0000{name}.png"}]})"),
              HasSubstr("job.json:1: formats[1].pattern has a NUL character"));
  EXPECT_EQ(wrong(R"("output": "set", "cameras": {"type": "scene", "names": ["a\u0000b"]}})"), "");
}

// A document end without a further document, or followed by empty ones, is accepted as a single document.
// yaml-cpp reads each of these as empty documents without end.
TEST(Job, TextsThatBeginNoValueAreNotYaml) {
  for (const char* text : {",", "]", "}", ", a: 1", "] ---\n--- ]"})
    EXPECT_THAT(wrongIn("job.yaml", text), HasSubstr("job.yaml:1: it is not YAML")) << text;
}

TEST(Job, OneDocumentMayEnd) {
  for (const char* end : {"...\n", "---\n", "# the end\n"})
    EXPECT_EQ(wrongIn("job.yaml", std::string("---\nscenes: builtin:boxes\noutput: set\n") + end), "") << end;
}

// 64-bit integers are repeated as written, on both sides of 2^63.
TEST(Job, LargeNumbersAreRepeatedAsTheyAre) {
  const std::string start = "scenes: builtin:boxes\noutput: set\n";
  for (const char* number : {"9223372036854775807", "9223372036854775808", "18446744073709551615"}) {
    EXPECT_THAT(wrongIn("job.yaml", start + "repeat: " + number + "\n"), HasSubstr(std::string("not ") + number));
    EXPECT_THAT(wrongIn("job.yaml", start + "id-depth: " + number + "\n"), HasSubstr(std::string("not ") + number));
    EXPECT_THAT(
        wrongIn("job.json", std::string(R"({"scenes": "builtin:boxes", "output": "set", "repeat": )") + number + "}"),
        HasSubstr(std::string("not ") + number));
  }
}

double secondsOf(const std::function<void()>& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Nine levels of nine aliases would expand to 9^9 strings.
TEST(Job, AliasesDoNotMultiplyWithoutABound) {
  std::string laughs = "a0: &a0 [lol, lol, lol, lol, lol, lol, lol, lol, lol]\n";
  for (int level = 1; level < 9; ++level) {
    const std::string below = "*a" + std::to_string(level - 1);
    laughs += fmt::format("a{}: &a{} [{}", level, level, below);
    for (int i = 1; i < 9; ++i) laughs += ", " + below;
    laughs += "]\n";
  }
  EXPECT_LT(secondsOf([&] { EXPECT_THAT(wrongIn("job.yaml", laughs), HasSubstr("its aliases repeat too much")); }), 1);
  // A few copies are accepted.
  Folder folder;
  folder.write("job.yaml", std::string_view("k: &k [1, [2, 3]]\nl: [*k, *k]\nm: *k\n"));
  EXPECT_EQ(readJobFile(folder.at("job.yaml")).json.dump(),
            R"({"k":[1,[2,3]],"l":[[1,[2,3]],[1,[2,3]]],"m":[1,[2,3]]})");
}

// If each key were compared with all previous ones, 200,000 keys would take minutes.
TEST(Job, ManyKeysTakeLinearTime) {
  std::string yaml, json = "{";
  for (int i = 0; i < 200'000; ++i) {
    yaml += fmt::format("key{}: 1\n", i);
    json += fmt::format("{}\"key{}\": 1", i ? "," : "", i);
  }
  EXPECT_LT(secondsOf([&] { EXPECT_THAT(wrongIn("job.yaml", yaml), HasSubstr("key0: unknown key")); }), 5);
  EXPECT_LT(secondsOf([&] { EXPECT_THAT(wrongIn("job.json", json + "}"), HasSubstr("key0: unknown key")); }), 5);
  EXPECT_THAT(wrongIn("job.json", json + ",\n\"key7\": 2}"), HasSubstr("job.json:2: the key key7 is there twice"));
}

// A job that declares that it needs more memory than there is.
TEST(Job, MemoryIsClaimedBeforeItIsTaken) {
  Folder folder;
  std::string many = R"({"scenes": "builtin:boxes", "output": "set", "variations": [)";
  for (int i = 0; i < 400'000; ++i) many += i ? ",{}" : "{}";
  folder.write("job.json", many + "]}");
  const uint64_t before = memoryLimit();
  setMemoryLimit(16 << 20);
  std::string sentence;
  try {
    readJobFile(folder.at("job.json"));
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::OutOfMemory);
    sentence = error.what();
  }
  setMemoryLimit(before);
  EXPECT_THAT(sentence, HasSubstr("there is no memory for the job '"));
  EXPECT_NO_THROW(readJobFile(folder.at("job.json")));
}

TEST(Job, WrongJsonIsToldByItsLine) {
  EXPECT_THAT(wrongIn("job.json", "{\"scenes\": \"builtin:boxes\",\n\"output\": \"set\",\n\n\"sizes\": 3}"),
              HasSubstr("job.json:4: sizes: unknown key"));
  EXPECT_THAT(wrongIn("job.json", "{\"scenes\": \"builtin:boxes\",\n\"output\": set}"),
              HasSubstr("job.json:2: it is not JSON"));
  EXPECT_THAT(wrongIn("job.json", "{\"scenes\": "), HasSubstr("job.json:1: it is not JSON"));
  EXPECT_THAT(wrongIn("job.json", std::string(100'000, '[')),
              HasSubstr("job.json:1: it is nested deeper than 64 levels"));
  EXPECT_THAT(wrongIn("job.yaml", std::string(100'000, '[')), HasSubstr("job.yaml"));
}

// The limits are those of the table that the command line uses.
TEST(Schema, HasEveryOptionOfAPicture) {
  const auto& options = jobSchema()["properties"]["options"]["properties"];
  EXPECT_EQ(options.size(), render::options().size());
  EXPECT_EQ(options["bloom"]["maximum"], 1);
  EXPECT_EQ(options["fps"]["minimum"], 1e-3);
  EXPECT_THAT(options["raster"]["enum"], ElementsAre("auto", "hardware", "compute", "rays"));
  EXPECT_EQ(options["ao-radius"]["exclusiveMinimum"], 0);
}

}  // namespace
}  // namespace latelight::data
