// Completions in real shells, and the manual page.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "app/folder.h"
#include "app/process.h"

namespace latelight::app {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::StartsWith;
using testing::UnorderedElementsAre;

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// The words without their descriptions.
std::vector<std::string> completed(std::vector<std::string> words) {
  words.insert(words.begin(), {"complete", "--"});
  const Outcome outcome = latelight(words);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  std::vector<std::string> lines = linesOf(outcome.out);
  for (std::string& line : lines) line = line.substr(0, line.find('\t'));
  return lines;
}

TEST(Completions, OfCommandsOptionsAndNames) {
  EXPECT_THAT(completed({"ren"}), ElementsAre("render"));
  EXPECT_THAT(completed({""}), IsSupersetOf({"render", "list", "man"}));
  EXPECT_THAT(completed({"render", "--lig"}), ElementsAre("--lighting", "--light-size"));
  EXPECT_THAT(completed({"render", "--lighting", "cl"}), ElementsAre("clustered"));
  EXPECT_THAT(completed({"render", "--aov", "depth,norm"}), ElementsAre("depth,normal"));
  EXPECT_THAT(completed({"render", "--debug", "li"}), IsSupersetOf({"lights", "lights-tested"}));
  EXPECT_THAT(completed({"render", "builtin:h"}), ElementsAre("builtin:hall", ":files"));
  EXPECT_THAT(completed({"render", "builtin:hall", "-o", "a"}), ElementsAre(":files"));
  EXPECT_THAT(completed({"render", "--json", "builtin:h"}), Contains("builtin:hall")) << "a flag takes no value";
  EXPECT_THAT(completed({"bench", "fr"}), ElementsAre("frame"));
  EXPECT_THAT(completed({"bench", "frame", "--layo"}), ElementsAre("--layout"));
  EXPECT_THAT(completed({"list", "norm"}), IsSupersetOf({"normals", "normal-frames"}));
  EXPECT_THAT(completed({"study", ""}), Contains("accuracy"));
  EXPECT_THAT(completed({"completions", ""}), ElementsAre("bash", "zsh", "fish"));
  EXPECT_THAT(completed({"render", "--device", ""}), ElementsAre("auto", "cpu"));
  EXPECT_THAT(completed({"study", "depth", "--device", "c"}), ElementsAre("cpu"));
  EXPECT_THAT(completed({"batch", "--devices", "a"}), ElementsAre("auto", "all"));
  EXPECT_THAT(completed({"render", "--tonemap=a"}), ElementsAre("--tonemap=aces", "--tonemap=agx"));
  EXPECT_THAT(completed({"render", "--aov=depth,norm"}), ElementsAre("--aov=depth,normal"));
  EXPECT_THAT(completed({"render", "--out=a"}), ElementsAre(":files"));
  EXPECT_THAT(completed({"render", "--json="}), ElementsAre()) << "a flag accepts no value";
  EXPECT_THAT(completed({"nonsense", "--nothing", "x"}), ElementsAre());
}

// An option that is offered must be one that the command accepts, and thus one that its help lists, or the program's.
TEST(Completions, OfOptionsThatTheCommandAccepts) {
  const std::vector<std::vector<std::string>> commands{
      {"render"},          {"view"},           {"report"}, {"serve"}, {"batch"},
      {"batch", "verify"}, {"batch", "merge"}, {"list"},   {"study"}, {"export"},
      {"bench", "raster"}, {"bench", "frame"}, {"compare"}};
  for (std::vector<std::string> command : commands) {
    command.emplace_back("--");
    std::vector<std::string> offered = completed(command);
    command.back() = "--help";
    const std::string help = latelight(command).out;
    std::ranges::sort(offered);
    EXPECT_EQ(std::ranges::adjacent_find(offered), offered.end()) << command.front();
    EXPECT_THAT(offered, IsSupersetOf({"--help", "--quiet"}));
    for (const std::string& option : offered)
      EXPECT_TRUE(option == "--quiet" || option == "--version" ||
                  testing::Matches(testing::ContainsRegex("[ ,]" + option + "[ ,\n]"))(help))
          << command.front() << " " << option;
  }
  EXPECT_THAT(completed({"view", "--labe"}), ElementsAre());
  EXPECT_THAT(completed({"report", "--len"}), ElementsAre());
  EXPECT_THAT(completed({"serve", "--pi"}), ElementsAre());
  EXPECT_THAT(completed({"batch", "verify", "--"}), UnorderedElementsAre("--help", "--quiet"));
  EXPECT_THAT(completed({"batch", "verify", "a", ""}), ElementsAre(":files"));
}

TEST(Completions, OfNoOtherShell) {
  const Outcome outcome = latelight({"completions", "tcsh"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("bash, zsh and fish"));
}

// Returns the words that a shell proposes with its own script.
std::string inShell(const std::string& shell, const std::string& script) {
  const Folder folder;
  std::ofstream(folder.at("script")) << script;
  std::ofstream(folder.at("scene file.glb")) << "";
  const std::string path = std::filesystem::path(LATELIGHT_PROGRAM).parent_path().string() + ":" + std::getenv("PATH");
  const Outcome outcome = runProcess(
      "/usr/bin/env", {.arguments = {shell, "script"}, .environment = {{"PATH", path}}, .folder = folder.path()});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return outcome.out;
}

TEST(Completions, InBash) {
  const auto completedTo = [](const std::string& line) {
    return inShell("bash", "source <(latelight completions bash)\nCOMP_LINE='" + line +
                               "' COMP_POINT=${#COMP_LINE}\n_latelight 2>/dev/null\nprintf '%s|' \"${COMPREPLY[@]}\"");
  };
  EXPECT_EQ(completedTo("latelight render --lig"), "--lighting|--light-size|");
  EXPECT_EQ(completedTo("latelight render builtin:h"), "hall|") << "behind the colon is another word for readline";
  EXPECT_EQ(completedTo("latelight render --aov depth,norm"), "depth,normal|");
  EXPECT_EQ(completedTo("latelight render sce"), "scene file.glb|");
  EXPECT_EQ(completedTo("latelight render --tonemap=ac"), "aces|") << "readline also separates words at equals signs";
  EXPECT_EQ(completedTo("latelight render --hdri=sce"), "scene file.glb|");
  EXPECT_THAT(completedTo("latelight list "), HasSubstr("aovs|"));
}

TEST(Completions, InFish) {
  if (runProcess("/usr/bin/env", {.arguments = {"which", "fish"}}).code != 0) GTEST_SKIP() << "fish is not installed";
  EXPECT_THAT(inShell("fish", "latelight completions fish | source\ncomplete -C 'latelight study pos'"),
              StartsWith("position\t"));
}

TEST(Completions, ParseInZsh) {
  if (runProcess("/usr/bin/env", {.arguments = {"which", "zsh"}}).code != 0) GTEST_SKIP() << "zsh is not installed";
  EXPECT_EQ(inShell("zsh", "latelight completions zsh > _latelight && zsh -n _latelight && echo fine"), "fine\n");
}

TEST(ManPage, DescribesEveryCommandAndOption) {
  const std::string page = latelight({"man"}).out;
  for (const char* text : {".TH LATELIGHT 1", ".SH NAME", ".SH EXIT STATUS", ".SS render", ".SS bench frame"})
    EXPECT_THAT(page, HasSubstr(text));
  for (const std::string& option : completed({"render", "--"})) {
    std::string escaped;
    for (const char c : option) escaped += c == '-' ? "\\-" : std::string(1, c);
    EXPECT_TRUE(option == "--help" || page.find(escaped + "\\fR") != page.npos) << option;
  }
}

TEST(ManPage, IsWhatMandocTakes) {
  const Folder folder;
  std::ofstream(folder.at("page")) << latelight({"man"}).out;
  const Outcome lint =
      runProcess("/usr/bin/mandoc", {.arguments = {"-T", "lint", "-W", "warning", "page"}, .folder = folder.path()});
  // A date would make builds differ.
  EXPECT_EQ(lint.out + lint.err, "mandoc: page:1:17: WARNING: missing date, using \"\": TH\n");
}

}  // namespace
}  // namespace latelight::app
