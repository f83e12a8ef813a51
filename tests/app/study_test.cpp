// latelight study: its files and its printed output.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"
#include "base/files.h"

namespace latelight::app {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string text(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Outcome study(const Folder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "study");
  arguments.insert(arguments.end(), {"--device", "cpu"});
  if (arguments[1] != "lights") arguments.insert(arguments.end(), {"--samples", "4000"});
  return latelight({.arguments = std::move(arguments), .folder = folder.path()});
}

TEST(Study, OfNormalsWritesTablesAndPictures) {
  Folder folder;
  const Outcome outcome = study(folder, {"normals", "-o", "out", "--bits", "8,float,8-8"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(outcome.out, HasSubstr("octahedral-precise"));
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "out"))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  EXPECT_THAT(names, ElementsAre("normals-histogram-8.png", "normals-histogram-float.png", "normals-histogram.csv",
                                 "normals-map-8.png", "normals-map-float.png", "normals.csv", "normals.json"));
  const auto json = nlohmann::json::parse(text(folder.path() / "out" / "normals.json"));
  EXPECT_EQ(json["study"], "normals");
  EXPECT_EQ(json["samples"], 4000);
  const Outcome list = latelight({"list", "normals", "--json"});
  const size_t encodings = nlohmann::json::parse(list.out)["normals"].size();
  EXPECT_EQ(json["normals"].size(), encodings * 2 * 2);  // budgets, regions
  EXPECT_THAT(text(folder.path() / "out" / "normals.csv"), HasSubstr("encoding,bits,region,mean deg"));
}

TEST(Study, WritesTheSameBytesAgain) {
  Folder folder;
  for (const char* name : {"depth", "position"}) {
    ASSERT_EQ(study(folder, {name, "-o", "a"}).code, 0);
    ASSERT_EQ(study(folder, {name, "-o", "b"}).code, 0);
  }
  size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "a")) {
    EXPECT_EQ(readFile(entry.path()), readFile(folder.path() / "b" / entry.path().filename())) << entry.path();
    ++files;
  }
  EXPECT_EQ(files, 7u);
}

TEST(Study, OfLightsWritesTablesAndPlots) {
  Folder folder;
  const Outcome outcome = study(
      folder, {"lights", "-o", "out", "--lights", "1", "--triangles", "50k", "--sizes", "32x18", "--budget", "1e6"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const std::filesystem::path out = folder.path() / "out";
  for (const char* name : {"lights.csv", "lights-passes.csv", "lights-exponents.csv", "lights-model.csv"})
    EXPECT_TRUE(std::filesystem::exists(out / name)) << name;
  EXPECT_THAT(text(out / "lights-vs-lights.svg"), HasSubstr("<title>clustered</title>"));
  const auto json = nlohmann::json::parse(text(out / "lights.json"));
  EXPECT_EQ(json["budget"], 1e6);
  EXPECT_FALSE(json.contains("samples"));
  EXPECT_EQ(json["lights"].size() % 3, 0u);  // three sweeps per technique
  EXPECT_GT(json["lights"].size(), 0u);
}

TEST(Study, PrintsJson) {
  Folder folder;
  const Outcome outcome = study(folder, {"position", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["position"].size(), 36u);
}

TEST(Study, PageReplacesNoOtherFileOfTheCommand) {
  Folder folder;
  std::filesystem::create_directory(folder.path() / "out");
  std::filesystem::create_directory_symlink("out", folder.path() / "link");
  folder.write("sky.hdr", "an environment");
  std::filesystem::create_symlink("sky.hdr", folder.path() / "sky.html");
  const std::vector<std::string> before = folder.names();
  const auto expectRejected = [&](std::vector<std::string> arguments, const char* name) {
    const Outcome outcome = study(folder, std::move(arguments));
    EXPECT_EQ(outcome.code, 2) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr(name));
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(folder.names(), before);
  };
  // A page ends in .html, unlike inputs and results.
  for (const char* name : {"out/position.csv", "link/position.json", "sky.hdr", "page", "x.png"})
    expectRejected({"position", "-o", "out", "--html", name}, "--html writes an HTML page");
  expectRejected({"accuracy", "--hdri", "sky.hdr", "--html", "sky.html"}, "'sky.html'");  // a link to it
  EXPECT_EQ(folder.read("sky.hdr"), "an environment");
  // The name that the page's link leads to is known as a result's only after the study.
  folder.write("out/position.csv", "old");
  std::filesystem::create_symlink("out/position.csv", folder.path() / "page.html");
  EXPECT_EQ(study(folder, {"position", "-o", "out", "--html", "page.html"}).code, 2);
  EXPECT_EQ(folder.read("out/position.csv"), "old");
  const Outcome outcome = study(folder, {"position", "-o", "out", "--html", "out/position.html"});
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(folder.read("out/position.html"), HasSubstr("<html"));
}

TEST(Study, PageMayBeInANewFolderOfResults) {
  Folder folder;
  const Outcome failed = study(folder, {"position", "-o", "new", "--html", "absent/x.html"});
  EXPECT_EQ(failed.code, 2) << failed.text();
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "new")) << "removed again";
  const Outcome outcome = study(folder, {"position", "-o", "new", "--html", "new/x.html"});
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(folder.read("new/x.html"), HasSubstr("<html"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "new/position.csv"));
}

}  // namespace
}  // namespace latelight::app
