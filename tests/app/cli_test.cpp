// What the program says about itself, and that it accepts what it offers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"

namespace latelight::app {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::MatchesRegex;

Outcome succeed(std::vector<std::string> arguments) {
  const Outcome outcome = latelight(std::move(arguments));
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_EQ(outcome.err, "");
  return outcome;
}

struct Help {
  const char* command;
  std::vector<const char*> names;
};

TEST(CommandLine, HelpNamesEveryOption) {
  const std::vector<Help> helps{{"render",
                                 {"SCENE",
                                  "--out",
                                  "-o",
                                  "--size",
                                  "--variant",
                                  "--camera",
                                  "--eye",
                                  "--target",
                                  "--up",
                                  "--orbit",
                                  "--fov",
                                  "--frame",
                                  "--layout",
                                  "--normals",
                                  "--normal-space",
                                  "--position",
                                  "--lighting",
                                  "--shading",
                                  "--aa",
                                  "--hdri",
                                  "--hdri-rotate",
                                  "--hdri-intensity",
                                  "--exposure",
                                  "--tonemap",
                                  "--background",
                                  "--aov",
                                  "--debug",
                                  "--normal-frame",
                                  "--axes",
                                  "--no-side-file",
                                  "--device",
                                  "--json",
                                  "--dump-graph",
                                  "--validate"}},
                                {"list", {"TOPIC", "--json"}},
                                {"devices", {"--json"}},
                                {"study", {"NAME", "--out", "--seed", "--bits"}},
                                {"doctor", {"--json"}},
                                {"compare", {"A", "B", "--tolerance", "--share", "--channel", "--diff", "--json"}}};
  const std::string all = succeed({"--help"}).out;
  EXPECT_THAT(all, HasSubstr("--version"));
  EXPECT_THAT(all, HasSubstr("--quiet"));
  for (const Help& help : helps) {
    EXPECT_THAT(all, HasSubstr(help.command));
    const std::string text = succeed({help.command, "--help"}).out;
    for (const char* name : help.names) EXPECT_THAT(text, HasSubstr(name)) << help.command;
  }
}

TEST(CommandLine, TellsItsVersion) {
  EXPECT_THAT(succeed({"--version"}).out, MatchesRegex("latelight [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

json listAll() {
  return json::parse(succeed({"list", "--json"}).out);
}

std::vector<std::string> namesOf(const json& rows) {
  std::vector<std::string> names;
  for (const json& row : rows) names.push_back(row["name"]);
  return names;
}

TEST(List, TextAndJsonNameTheSame) {
  const json all = listAll();
  EXPECT_THAT(all.size(), testing::Ge(7u));
  const std::string text = succeed({"list"}).out;
  for (const auto& [topic, rows] : all.items()) {
    EXPECT_THAT(text, HasSubstr(topic + "\n"));
    EXPECT_FALSE(rows.empty()) << topic;
    const std::string alone = succeed({"list", topic}).out;
    EXPECT_THAT(text, HasSubstr(alone));
    EXPECT_EQ(json::parse(succeed({"list", topic, "--json"}).out)[topic], rows);
    for (const std::string& name : namesOf(rows)) EXPECT_THAT(alone, HasSubstr("\n  " + name));
  }
}

// The names that the option's error sentence gives are those of the list.
TEST(List, AgreesWithWhatErrorsOffer) {
  const json all = listAll();
  const std::map<std::string, std::string> options{
      {"layouts", "--layout"},     {"normals", "--normals"},   {"normal-spaces", "--normal-space"},
      {"positions", "--position"}, {"lighting", "--lighting"}, {"shading", "--shading"},
      {"tonemaps", "--tonemap"},   {"aovs", "--aov"}};
  for (const auto& [topic, option] : options) {
    const std::string sentence = latelight({"render", "builtin:boxes", "-o", "a.png", option, "?"}).err;
    std::string names;
    for (const std::string& name : namesOf(all[topic])) names += (names.empty() ? "" : ", ") + name;
    EXPECT_THAT(sentence, HasSubstr(": " + names + "\n")) << option;
  }
}

// Runs each, two at a time; every one must end well without a word.
void expectAllRender(const std::vector<std::vector<std::string>>& choices) {
  Folder folder;
  std::vector<Outcome> outcomes(choices.size());
  inPairs(choices.size(), [&](size_t i) {
    std::vector<std::string> arguments{"render", "--size", "32x18", "--device", "cpu", "--validate"};
    arguments.insert(arguments.end(), choices[i].begin(), choices[i].end());
    arguments.insert(arguments.end(), {"-o", folder.at(std::to_string(i) + ".exr")});
    outcomes[i] = latelight(arguments);
  });
  for (size_t i = 0; i < choices.size(); ++i) {
    std::string text;
    for (const std::string& argument : choices[i]) text += argument + " ";
    EXPECT_EQ(outcomes[i].code, 0) << text << outcomes[i].text();
    EXPECT_EQ(outcomes[i].err, "") << text;
    EXPECT_TRUE(std::filesystem::exists(folder.at(std::to_string(i) + ".exr"))) << text;
  }
}

// Layouts x normals x lighting x shading; tonemaps, of which only the last pass knows, take turns.
TEST(List, EveryCombinationRendersWithoutAValidationMessage) {
  const json all = listAll();
  const std::vector<std::string> tonemaps = namesOf(all["tonemaps"]);
  std::vector<std::vector<std::string>> choices;
  for (const std::string& layout : namesOf(all["layouts"]))
    for (const std::string& normals : namesOf(all["normals"]))
      for (const std::string& lighting : namesOf(all["lighting"]))
        for (const std::string& shading : namesOf(all["shading"]))
          choices.push_back({"builtin:boxes", "--layout", layout, "--normals", normals, "--lighting", lighting,
                             "--shading", shading, "--tonemap", tonemaps[choices.size() % tonemaps.size()], "--aov",
                             "color,depth,normal,albedo"});
  EXPECT_GE(choices.size(), tonemaps.size());
  expectAllRender(choices);
}

TEST(List, EverySceneAndEveryAovRenders) {
  const json all = listAll();
  std::vector<std::vector<std::string>> choices;
  for (const std::string& scene : namesOf(all["scenes"])) choices.push_back({scene});
  for (const std::string& aov : namesOf(all["aovs"])) choices.push_back({"builtin:boxes", "--aov", aov});
  expectAllRender(choices);
}

}  // namespace
}  // namespace latelight::app
