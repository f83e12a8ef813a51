// The subcommand as the program runs it: what it prints, writes and exits with.
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "output/npy.h"
#include "support.h"

namespace latelight::output {
namespace {

using testing::HasSubstr;

class CompareCommand : public InFolder {
 protected:
  CompareCommand() {
    const Picture a{2, 1, {0, 0, 0, 255, 10, 10, 10, 255}}, b{2, 1, {0, 0, 0, 255, 30, 10, 10, 255}};
    writePicture(at("a.png"), a);
    writePicture(at("b.png"), b);
    writePicture(at("small.png"), {1, 1, {0, 0, 0, 255}});
  }
  // Its exit code; what it printed is in `printed`.
  int run(std::vector<std::string> arguments) {
    CLI::App cli;
    app::addCompareCommand(cli);
    std::vector<std::string> reversed{arguments.rbegin(), arguments.rend()};
    reversed.push_back("compare");
    testing::internal::CaptureStdout();
    int code = 0;
    try {
      cli.parse(reversed);
    } catch (const app::Exit& exit) {
      code = static_cast<int>(exit.code);
    } catch (const Error& error) {
      code = static_cast<int>(error.code());
    } catch (const CLI::ParseError&) {
      code = static_cast<int>(ExitCode::Usage);
    }
    printed = testing::internal::GetCapturedStdout();
    return code;
  }
  std::string printed;
};

TEST_F(CompareCommand, ExitsByLikeness) {
  EXPECT_EQ(run({at("a.png"), at("a.png")}), 0);
  EXPECT_THAT(printed, HasSubstr("alike\n"));
  EXPECT_EQ(run({at("a.png"), at("b.png")}), 1);
  EXPECT_THAT(printed, HasSubstr("not alike\n"));
  EXPECT_THAT(printed, HasSubstr("(channel R at 1,0)"));
  EXPECT_THAT(printed, HasSubstr("50 % of the pixels (1 of 2)"));
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--share", "0.5"}), 0);
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--tolerance", "0.1"}), 0);
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--channel", "G,B"}), 0);
}

TEST_F(CompareCommand, WritesADifferencePicture) {
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--diff", at("d.png")}), 1);
  EXPECT_EQ(readImage(at("d.png")).find("R")->values, (std::vector<double>{0, 1}));
}

TEST_F(CompareCommand, PrintsJson) {
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--json"}), 1);
  const auto json = nlohmann::json::parse(printed);
  EXPECT_EQ(json["alike"], false);
  EXPECT_NEAR(json["maximum"].get<double>(), 20 / 255.0, 1e-12);
  EXPECT_EQ(json["share"], 0.5);
  EXPECT_EQ(json["worst"]["x"], 1);
  run({at("a.png"), at("a.png"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(printed)["psnr"], "inf");
}

TEST_F(CompareCommand, EndsWithBadInputOrUsage) {
  EXPECT_EQ(run({at("a.png"), at("missing.png")}), 3);
  EXPECT_EQ(run({at("a.png"), at("small.png")}), 3);
  EXPECT_EQ(run({at("a.png")}), 2);
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--channel", "Q"}), 2);
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--tolerance", "-1"}), 2);
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--share", "2"}), 2);
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--diff", at("no/d.png")}), 2);
}

}  // namespace
}  // namespace latelight::output
