// The program's own descriptions (help, version) are complete, and it accepts the options that they list.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"
#include "long_tests.h"
#include "pairwise.h"

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
  const std::vector<Help> helps{
      {"render", {"SCENE", "--out", "-o", "--size", "--json"}},
      {"list", {"TOPIC", "--size", "--samples", "--json"}},
      {"devices", {"--json"}},
      {"study", {"NAME", "--out", "--seed", "--bits", "--lights", "--triangles", "--sizes", "--budget"}},
      {"doctor", {"--json"}},
      {"bench", {"raster", "frame", "views", "worlds", "rays", "lights", "shade"}},
      {"batch",
       {"JOB", "--scenes", "--output", "-o", "--exposure", "--resume", "--shard", "verify", "merge", "status"}},
      {"export", {"SCENE", "--out", "-o", "--unit", "--up-axis", "--point-radius", "--variant"}},
      {"compare", {"A", "B", "--tolerance", "--share", "--flip", "--ppd", "--channel", "--diff", "--json"}}};
  const std::string all = succeed({"--help"}).out;
  EXPECT_THAT(all, HasSubstr("--version"));
  EXPECT_THAT(all, HasSubstr("--quiet"));
  for (const Help& help : helps) {
    EXPECT_THAT(all, HasSubstr(help.command));
    const std::string text = succeed({help.command, "--help"}).out;
    for (const char* name : help.names) EXPECT_THAT(text, HasSubstr(name)) << help.command;
  }
}

// The help lists every row of the table of options, with its default and its first name.
TEST(CommandLine, HelpFollowsTheTableOfOptions) {
  const std::string help = succeed({"render", "--help"}).out;
  const json options = json::parse(succeed({"list", "options", "--json"}).out)["options"];
  EXPECT_GT(options.size(), 50u);
  for (const json& option : options) {
    const std::string name = option["name"];
    const size_t at = help.find("\n  " + (name == "--out" ? "-o," + name : name) + " ");
    ASSERT_NE(at, std::string::npos) << name;
    const std::string line = help.substr(at + 1, help.find('\n', at + 1) - at - 1);
    const std::string standard = option.contains("default") ? "=" + option["default"].get<std::string>() : "";
    EXPECT_THAT(line, HasSubstr(standard)) << name;
    EXPECT_THAT(line, HasSubstr(option["description"].get<std::string>()));
  }
}

// The command accepts exactly the range that the table states for a number, and its message names that range.
TEST(CommandLine, ChecksFollowTheTableOfOptions) {
  const json options = json::parse(succeed({"list", "options", "--json"}).out)["options"];
  size_t checked = 0;
  for (const json& option : options) {
    if (!option.contains("most") || option["type"] == "text") continue;
    const std::string name = option["name"], tooMuch = std::to_string(option["most"].get<int64_t>() + 1);
    const Outcome outcome = latelight({"render", "builtin:boxes", "-o", "a.png", name, tooMuch});
    EXPECT_EQ(outcome.code, 2) << name;
    EXPECT_THAT(outcome.err, HasSubstr(name + " takes a "));
    EXPECT_THAT(outcome.err, HasSubstr("not \"" + tooMuch + "\"\n"));
    ++checked;
  }
  EXPECT_GT(checked, 10u);
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

// Conversions of C would read 010 as the octal number 8, and reject 09.
TEST(CommandLine, LeadingZerosChangeNoNumber) {
  const json layouts = json::parse(succeed({"list", "layouts", "--samples", "010", "--json"}).out)["layouts"];
  EXPECT_EQ(layouts[0]["samples"], 10);
  const Outcome threads =
      latelight({"batch", "--scenes", "builtin:boxes", "-o", "set", "--threads", "09", "--dry-run"});
  EXPECT_EQ(threads.code, 0) << threads.err;
}

// The option's error message lists the same names as `list`.
TEST(List, AgreesWithWhatErrorsOffer) {
  const json all = listAll();
  const std::map<std::string, std::string> options{
      {"layouts", "--layout"},     {"normals", "--normals"},   {"normal-spaces", "--normal-space"},
      {"positions", "--position"}, {"lighting", "--lighting"}, {"shading", "--shading"},
      {"tonemaps", "--tonemap"},   {"aovs", "--aov"},          {"ao", "--ao"},
      {"axes", "--axes"},          {"shadows", "--shadows"}};
  for (const auto& [topic, option] : options) {
    const std::string sentence = latelight({"render", "builtin:boxes", "-o", "a.png", option, "?"}).err;
    std::string names;
    for (const std::string& name : namesOf(all[topic])) names += (names.empty() ? "" : ", ") + name;
    EXPECT_THAT(sentence, HasSubstr(": " + names + "\n")) << option;
  }
}

// Runs the commands, two at a time. Each must succeed without a message.
void expectAllRender(const std::vector<std::vector<std::string>>& choices) {
  Folder folder;
  std::vector<Outcome> outcomes(choices.size());
  inPairs(choices.size(), [&](size_t i) {
    std::vector<std::string> arguments{"render", "--size", "32x18", "--device", "cpu", "--validate"};
    arguments.insert(arguments.end(), choices[i].begin(), choices[i].end());
    arguments.insert(arguments.end(), {"-o", folder.at(std::to_string(i) + ".exr")});
    // Without this, most of the time would be spent in lavapipe's compiler.
    outcomes[i] = latelight({.arguments = arguments, .environment = {{"GALLIVM_PERF", "nopt"}}});
  });
  for (size_t i = 0; i < choices.size(); ++i) {
    std::string text;
    for (const std::string& argument : choices[i]) text += argument + " ";
    EXPECT_EQ(outcomes[i].code, 0) << text << outcomes[i].text();
    EXPECT_EQ(outcomes[i].err, "") << text;
    EXPECT_TRUE(std::filesystem::exists(folder.at(std::to_string(i) + ".exr"))) << text;
  }
}

// Returns the first row with this name.
json rowNamed(const json& rows, const std::string& name) {
  for (const json& row : rows)
    if (row["name"] == name) return row;
  ADD_FAILURE() << "no " << name;
  return {};
}

// The 36 MB of Killzone 2's G-buffer (Valient 2007) follow from its formats and the image size.
TEST(List, SaysWhatAPictureCosts) {
  const std::vector<std::string> small{"list", "layouts", "--size", "640x360"};
  const std::vector<std::string> twice{"list", "layouts", "--size", "1280x720", "--samples", "2"};
  const auto costs = [](std::vector<std::string> arguments) {
    arguments.push_back("--json");
    return json::parse(succeed(arguments).out)["layouts"];
  };
  const json rows = costs(twice);
  EXPECT_EQ(rowNamed(rows, "killzone2")["originalBytes"]["picture"], 36864000);
  EXPECT_EQ(rowNamed(costs(small), "killzone2")["originalBytes"]["picture"], 36864000 / 8);
  EXPECT_THAT(succeed(twice).out, HasSubstr("original: 36.9 MB (35.2 MiB)"));
  for (const json& row : rows) {
    uint64_t here = 0, original = 0;
    for (const json& target : row["targets"]) {
      here += target["bytes"].get<uint64_t>();
      original += target.value("originalBytes", target["bytes"].get<uint64_t>());
    }
    EXPECT_EQ(row["bytes"]["total"], here) << row["name"];
    EXPECT_EQ(row["bytes"]["picture"], here * 1280 * 720 * 2) << row["name"];
    EXPECT_EQ(row["originalBytes"]["total"], original) << row["name"];
  }
}

// Layouts x normals x lighting x shading x tonemaps, with every pair of choices. Layouts with their own encoding accept
// no choice of normals, and volumes, which are drawn, are not combined with layouts that are never drawn.
TEST(List, EveryPairOfChoicesRendersWithoutAValidationMessage) {
  LATELIGHT_SKIP_UNLESS_ALL();  // test_combinations combines most of them
  const json all = listAll();
  const std::vector<std::pair<std::string, std::string>> options{{"layouts", "--layout"},
                                                                 {"normals", "--normals"},
                                                                 {"lighting", "--lighting"},
                                                                 {"shading", "--shading"},
                                                                 {"tonemaps", "--tonemap"}};
  std::vector<size_t> counts;
  for (const auto& [topic, option] : options) counts.push_back(all[topic].size());
  const auto follows = [&](size_t layout) { return all["layouts"][layout]["followsNormals"].get<bool>(); };
  const auto drawn = [&](const test::Combination& c) {
    return all["layouts"][c[0]]["raster"] == "any" || all["lighting"][c[2]]["name"] != "volumes";
  };
  std::vector<std::vector<std::string>> choices;
  for (const test::Combination& c :
       test::pairwise(counts, [&](const test::Combination& c) { return (c[1] == 0 || follows(c[0])) && drawn(c); })) {
    std::vector<std::string> choice{"builtin:boxes", "--aov", "color,depth,normal,albedo"};
    for (size_t i = 0; i < options.size(); ++i)
      if (options[i].first != "normals" || follows(c[0]))
        choice.insert(choice.end(), {options[i].second, all[options[i].first][c[i]]["name"].get<std::string>()});
    choices.push_back(std::move(choice));
  }
  EXPECT_GE(choices.size(), 2 * counts[1] + counts[0] - 2);
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
