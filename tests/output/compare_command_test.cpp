// `latelight compare` as a process: its printed output, its files and its exit codes.
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "base/files.h"
#include "output/exr.h"
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
  // Returns its exit code, and sets `printed` to its output and `message` to that of its error.
  int run(std::vector<std::string> arguments) {
    CLI::App cli;
    app::addCompareCommand(cli);
    std::vector<std::string> reversed{arguments.rbegin(), arguments.rend()};
    reversed.push_back("compare");
    testing::internal::CaptureStdout();
    int code = 0;
    message.clear();
    try {
      cli.parse(reversed);
    } catch (const app::Exit& exit) {
      code = static_cast<int>(exit.code);
    } catch (const Error& error) {
      code = static_cast<int>(error.code());
      message = error.what();
    } catch (const CLI::ParseError&) {
      code = static_cast<int>(ExitCode::Usage);
    }
    printed = testing::internal::GetCapturedStdout();
    return code;
  }
  std::string printed, message;
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
  const auto color = json["outputs"]["color"];
  EXPECT_NEAR(color["maximum"].get<double>(), 20 / 255.0, 1e-12);
  EXPECT_EQ(color["share"], 0.5);
  EXPECT_EQ(color["worst"]["x"], 1);
  EXPECT_EQ(color["worst"]["channel"], "R");
  EXPECT_GT(color["flip"].get<double>(), 0);
  run({at("a.png"), at("a.png"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(printed)["outputs"]["color"]["psnr"], "inf");
  EXPECT_EQ(nlohmann::json::parse(printed)["outputs"]["color"]["flip"], 0);
}

// Depths of 2 and 2.02 m, and two ids of which one differs: a common maximum over both would be meaningless.
TEST_F(CompareCommand, MeasuresEachOutput) {
  const auto write = [&](const char* name, float depth, uint32_t id) {
    AovImage z = makeAovImage(Aov::Depth, 2, 1), ids = makeAovImage(Aov::Id, 2, 1);
    z.values = {2, depth};
    ids.ids = {4000000000u, id};
    const AovImage* images[] = {&z, &ids};
    writeFile(at(name), encodeExr(images, {}));
  };
  write("a.exr", 2, 7);
  write("b.exr", 2.02f, 4000000000u);
  EXPECT_EQ(run({at("a.exr"), at("b.exr")}), 1);
  EXPECT_THAT(printed, HasSubstr("depth  relative error: maximum 0.0099"));
  EXPECT_THAT(printed, HasSubstr("id     different in 50 % of the pixels (1 of 2)"));
  EXPECT_EQ(run({at("a.exr"), at("b.exr"), "--json"}), 1);
  const auto outputs = nlohmann::json::parse(printed)["outputs"];
  EXPECT_EQ(outputs["depth"]["measure"], "relative");
  EXPECT_EQ(outputs["id"]["measure"], "identity");
  EXPECT_EQ(outputs["id"]["share"], 0.5);
  EXPECT_EQ(run({at("a.exr"), at("b.exr"), "--tolerance", "depth=0.01"}), 1) << "the ids differ";
  EXPECT_EQ(run({at("a.exr"), at("b.exr"), "--tolerance", "depth=0.01,id=1"}), 2) << "ids have no tolerance";
  EXPECT_EQ(printed, "");
  EXPECT_EQ(run({at("a.exr"), at("b.exr"), "--tolerance", "depth=0.01,id=0"}), 1);
  EXPECT_EQ(run({at("a.exr"), at("b.exr"), "--tolerance", "1", "--share", "0.5"}), 0);
  EXPECT_EQ(run({at("a.exr"), at("b.exr"), "--channel", "Z", "--tolerance", "0.01"}), 0);
  EXPECT_EQ(run({at("a.exr"), at("b.exr"), "--tolerance", "normal=1"}), 2) << "the files have none";
  EXPECT_EQ(run({at("a.exr"), at("b.exr"), "--tolerance", "depth="}), 2);
}

// JSON has no NaN.
TEST_F(CompareCommand, HasNoPsnrIfAPixelIsNan) {
  AovImage color = makeAovImage(Aov::Color, 1, 1);
  color.values.assign(color.values.size(), 0.5f);
  writeFile(at("a.npy"), encodeNpy(color));
  color.values[0] = std::numeric_limits<float>::quiet_NaN();
  writeFile(at("b.npy"), encodeNpy(color));
  EXPECT_EQ(run({at("a.npy"), at("b.npy")}), 1);
  EXPECT_THAT(printed, HasSubstr("PSNR undefined"));
  EXPECT_THAT(printed, HasSubstr("1 values are infinite"));
  EXPECT_EQ(run({at("a.npy"), at("b.npy"), "--json"}), 1);
  const auto json = nlohmann::json::parse(printed)["outputs"]["color"];
  EXPECT_TRUE(json["psnr"].is_null());
  EXPECT_EQ(json["unlike"], 1);
}

TEST_F(CompareCommand, RejectsTwoTolerancesOfAnOutput) {
  EXPECT_EQ(run({at("a.png"), at("a.png"), "--tolerance", "color=1,color=2"}), 2);
  EXPECT_THAT(message, HasSubstr("two numbers for \"color\""));
  EXPECT_EQ(run({at("a.png"), at("a.png"), "--tolerance", "1,2"}), 2);
  EXPECT_THAT(message, HasSubstr("two numbers for all outputs"));
  EXPECT_EQ(run({at("a.png"), at("a.png"), "--tolerance", "1", "--tolerance", "2"}), 2);
  EXPECT_EQ(run({at("a.png"), at("a.png"), "--tolerance", "1,color=2"}), 0);
}

// Compares colors with a perceptual metric.
TEST_F(CompareCommand, JudgesByFlip) {
  run({at("a.png"), at("b.png"), "--json"});
  const double flip = nlohmann::json::parse(printed)["outputs"]["color"]["flip"];
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--flip", fmt::format("{}", flip * 1.01)}), 0);
  EXPECT_EQ(run({at("a.png"), at("b.png"), "--flip", fmt::format("{}", flip * 0.99)}), 1);
}

TEST_F(CompareCommand, RejectsOptionsOfFlipWithoutColors) {
  AovImage depth = makeAovImage(Aov::Depth, 2, 1);
  depth.values = {2, 3};
  writeFile(at("a.depth.npy"), encodeNpy(depth));
  EXPECT_EQ(run({at("a.depth.npy"), at("a.depth.npy"), "--flip", "0.1", "--diff", at("d.png")}), 2);
  EXPECT_THAT(message, HasSubstr("--flip judges colors"));
  EXPECT_FALSE(std::filesystem::exists(at("d.png")));
  EXPECT_EQ(run({at("a.depth.npy"), at("a.depth.npy"), "--ppd", "30"}), 2);
  EXPECT_THAT(message, HasSubstr("--ppd applies to the FLIP of colors"));
  EXPECT_EQ(printed, "");
  EXPECT_EQ(run({at("a.depth.npy"), at("a.depth.npy")}), 0);
  EXPECT_EQ(run({at("a.png"), at("a.png"), "--flip", "0.1", "--ppd", "30"}), 0);
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

// Standard output has the report, which bytes of a PNG would break.
TEST_F(CompareCommand, WritesADifferencePictureToPngFilesOnly) {
  for (const char* name : {"d.jpg", "d", "d.exr"}) {
    EXPECT_EQ(run({at("a.png"), at("b.png"), "--diff", at(name)}), 2);
    EXPECT_EQ(message, fmt::format("--diff writes PNG; give it a name that ends in .png, not \"{}\"", at(name)));
    EXPECT_FALSE(std::filesystem::exists(at(name)));
  }
  for (const auto& more : {std::vector<std::string>{}, {"--json"}}) {
    std::vector<std::string> arguments{at("a.png"), at("b.png"), "--diff", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(run(arguments), 2);
    EXPECT_EQ(printed, "");
  }
}

}  // namespace
}  // namespace latelight::output
