// Jobs as files and as options: what they say, and what is said of wrong ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "base/error.h"
#include "data/batch/job.h"
#include "data/batch/schema.h"
#include "render/options.h"

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
    "options": {"size": "64x48", "exposure": -1.5, "loop": true, "shadow-lights": 4}})"));
  folder.write("job.yaml", std::string_view(R"(# comments, as YAML has them
scenes: [builtin:boxes]
output: set
repeat: 3
seed: 18446744073709551615
options: {size: 64x48, exposure: -1.5, loop: true, shadow-lights: 4}
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
  EXPECT_FLOAT_EQ(job.settings.exposure, -1.5f);
  EXPECT_TRUE(job.settings.loop);
  EXPECT_EQ(job.settings.shadowLights.most, 4u);
}

TEST(Job, PatternsAreFilledIn) {
  Folder folder;
  for (const char* name : {"b.glb", "a.glb", "c.gltf"}) folder.write(name, std::string_view("x"));
  JobDocument document;
  document.json = {{"scenes", {folder.at("*.glb"), "builtin:hall"}}, {"output", "set"}};
  EXPECT_THAT(makeJob(document).scenes, ElementsAre(folder.at("a.glb"), folder.at("b.glb"), "builtin:hall"));
}

TEST(Job, WrongOnesAreToldByKeyAndLine) {
  const std::string start = "scenes: builtin:boxes\noutput: set\n";
  const std::pair<std::string, std::string> yaml[] = {
      {"sizes: 3\n", "job.yaml:3: sizes: there is no such key"},
      {"options:\n  exposur: 1\n", "job.yaml:4: options.exposur: there is no such key"},
      {"options:\n  exposure: bright\n", "job.yaml:4: options.exposure takes a number"},
      {"options:\n  bloom: 7\n", "job.yaml:4: options.bloom takes a number from 0 to 1, not 7"},
      {"options:\n  tonemap: red\n",
       "job.yaml:4: options.tonemap takes khronos, aces, agx, reinhard or none, not \"red\""},
      {"options:\n  size: 64\n", "job.yaml:4: options.size: --size takes"},
      {"options:\n  loop: 1\n", "job.yaml:4: options.loop takes true or false, not 1"},
      {"options: 7\n", "job.yaml:3: options takes an object of keys and values, not 7"},
      {"repeat: 0\n", "job.yaml:3: repeat takes a whole number from 1 to 1e+06, not 0"},
      {"repeat: 1.5\n", "job.yaml:3: repeat takes a whole number"},
      {"seed: -1\n", "job.yaml:3: seed takes a whole number from 0, not -1"},
      {"repeat: \"2\"\n", "job.yaml:3: repeat takes a whole number from 1 to 1e+06, not \"2\""},
      {"formats: []\n", "job.yaml:3: formats is an empty list"},
      {"formats:\n  - files\n  - painting\n", "job.yaml:5: formats[1]: there is no format \"painting\""},
      {"formats: [{outputs: [depth]}]\n", "job.yaml:3: formats[0]: the key \"format\" must name the format"},
      {"formats: [{format: files, outputs: [dept]}]\n", "job.yaml:3: formats[0]: "},
      {"formats: [{format: files, pattern: all.png}]\n", "job.yaml:3: formats[0]: pattern needs {name}"},
      {"formats: [{format: files, pattern: \"../{name}.png\"}]\n", "job.yaml:3: formats[0]: pattern is a name below"},
      {"formats: [{format: files, outputs: [position]}]\n", "job.yaml:3: formats[0]: a PNG file cannot store position"},
      {"hdri: sky.hdr\n", "job.yaml:3: hdri: there is no file \"sky.hdr\""},
      {"name: \"\"\n", "job.yaml:3: name is empty"},
      {"repeat: 2\nrepeat: 3\n", "job.yaml:4: the key repeat is there twice"},
      {"options: {exposure: 1\n", "it is not YAML"},
      {"a: &a [*a, *a]\n", "job.yaml:"},
  };
  for (const auto& [text, sentence] : yaml) EXPECT_THAT(wrongIn("job.yaml", start + text), HasSubstr(sentence)) << text;
  EXPECT_THAT(wrongIn("job.yaml", "output: set\n"), HasSubstr("the key \"scenes\" is missing"));
  EXPECT_THAT(wrongIn("job.yaml", "scenes: [no/*.glb]\noutput: set\n"),
              HasSubstr("job.yaml:1: scenes[0]: no file is called"));
  EXPECT_THAT(wrongIn("job.yaml", "scenes: [builtin:boxes, builtin:boxes]\noutput: set\n"),
              HasSubstr("is listed twice"));
  EXPECT_THAT(wrongIn("job.yaml", "scenes: [builtin:boxes,\n no.glb]\noutput: set\n"),
              HasSubstr("job.yaml:2: scenes[1]: there is no file \"no.glb\""));
  EXPECT_THAT(wrongIn("job.yaml", "- a\n"), HasSubstr("a job is an object"));
  EXPECT_THAT(wrongIn("job.yaml", ""), HasSubstr("a job is an object"));
  EXPECT_THAT(wrongIn("job.txt", ""), HasSubstr("does not end in a language"));
}

TEST(Job, WrongJsonIsToldByItsLine) {
  EXPECT_THAT(wrongIn("job.json", "{\"scenes\": \"builtin:boxes\",\n\"output\": \"set\",\n\n\"sizes\": 3}"),
              HasSubstr("job.json:4: sizes: there is no such key"));
  EXPECT_THAT(wrongIn("job.json", "{\"scenes\": \"builtin:boxes\",\n\"output\": set}"),
              HasSubstr("job.json:2: it is not JSON"));
  EXPECT_THAT(wrongIn("job.json", "{\"scenes\": "), HasSubstr("job.json:1: it is not JSON"));
  EXPECT_THAT(wrongIn("job.json", std::string(100'000, '[')), HasSubstr("nested too deeply"));
  EXPECT_THAT(wrongIn("job.yaml", std::string(100'000, '[')), HasSubstr("job.yaml"));
}

// The bounds are those of the table that the command line has.
TEST(Schema, HasEveryOptionOfAPicture) {
  const auto& options = jobSchema()["properties"]["options"]["properties"];
  EXPECT_EQ(options.size(), render::options().size());
  EXPECT_EQ(options["bloom"]["maximum"], 1);
  EXPECT_EQ(options["fps"]["minimum"], 1e-3);
  EXPECT_THAT(options["raster"]["enum"], ElementsAre("auto", "hardware", "compute"));
  EXPECT_EQ(options["ao-radius"]["exclusiveMinimum"], 0);
}

}  // namespace
}  // namespace latelight::data
