// Comparison of files with several outputs, each with its own metric, and FLIP against its definition.
#include "output/compare_outputs.h"

#include "output/npy.h"
#include "support.h"

namespace latelight::output {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kInf = std::numeric_limits<double>::infinity();

using Channels = std::vector<std::pair<std::string, std::vector<double>>>;
ReadImage image(const Channels& channels, ChannelType type = ChannelType::Float) {
  ReadImage made{static_cast<uint32_t>(channels.front().second.size()), 1, {}};
  for (const auto& [name, values] : channels) made.channels.push_back({name, type, values});
  return made;
}

OutputDifference only(const Channels& a, const Channels& b, const OutputOptions& options = {}) {
  const std::vector<OutputDifference> all = compareOutputs(image(a), image(b), options);
  EXPECT_EQ(all.size(), 1u);
  return all.front();
}

TEST(CompareOutputs, FindsTheOutputsOfAFile) {
  Channels channels;
  for (const char* name :
       {"A",         "B",         "G",  "N.X",      "N.Y",      "N.Z",      "P.X",      "P.Y",       "P.Z",  "R",   "Z",
        "cluster.a", "cluster.b", "id", "motion.W", "motion.X", "motion.Y", "motion.Z", "roughness", "uv.U", "uv.V"})
    channels.push_back({name, {1}});
  std::map<std::string, Measure> measures;
  for (const OutputDifference& d : compareOutputs(image(channels), image(channels))) {
    measures[d.output] = d.measure;
    EXPECT_EQ(d.beyond, 0u) << d.output;
    EXPECT_EQ(d.maximum, 0) << d.output;
  }
  EXPECT_EQ(measures, (std::map<std::string, Measure>{{"color", Measure::Color},
                                                      {"normal", Measure::Angle},
                                                      {"position", Measure::Relative},
                                                      {"depth", Measure::Relative},
                                                      {"cluster", Measure::Difference},
                                                      {"id", Measure::Identity},
                                                      {"motion", Measure::Pixels},
                                                      {"roughness", Measure::Difference},
                                                      {"uv", Measure::Difference}}));
}

TEST(CompareOutputs, DepthIsRelative) {
  // Differences of 1 of 100, 0.5 of 2 and 0, and a surface in only one of the files.
  const OutputDifference d = only({{"Z", {99, 2, kInf, 4}}}, {{"Z", {100, 1.5, kInf, kInf}}});
  EXPECT_NEAR(d.maximum, 0.25, 1e-12);
  EXPECT_NEAR(d.mean, (0.01 + 0.25) / 3, 1e-12);
  EXPECT_EQ(d.unlike, 1u);
  EXPECT_EQ(d.beyond, 3u);
  EXPECT_EQ(d.worstX, 1u);
  EXPECT_EQ(only({{"Z", {100}}}, {{"Z", {100.009}}}).beyond, 0u) << "1e-4 by default";
  EXPECT_EQ(only({{"Z", {100}}}, {{"Z", {100.011}}}).beyond, 1u);
}

// A surface in one file only has no error to compare with a maximum, but it is a difference.
TEST(CompareOutputs, TheWorstPixelMayBeUnlike) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(only({{"Z", {1, 2, 3, 4}}}, {{"Z", {1, 2, kInf, kInf}}}).worstX, 2u);
  EXPECT_EQ(only({{"Z", {1, 2, 3, nan}}}, {{"Z", {1, 2, 3, 4}}}).worstX, 3u);
  EXPECT_EQ(only({{"Z", {1, kInf, 3, 4}}}, {{"Z", {1, 2, 3, 5}}}).worstX, 3u) << "the pixel of the maximum";
  EXPECT_EQ(only({{"Z", {1, 2, 3, kInf}}}, {{"Z", {1, 2.5, 3, 4}}}).worstX, 1u) << "the pixel of the maximum";
  // The background of normals is 0 0 0.
  EXPECT_EQ(
      only({{"N.X", {1, 1}}, {"N.Y", {0, 0}}, {"N.Z", {0, 0}}}, {{"N.X", {1, 0}}, {"N.Y", {0, 0}}, {"N.Z", {0, 0}}})
          .worstX,
      1u);
}

TEST(CompareOutputs, PositionsAreRelativeToTheirLength) {
  // Vectors of lengths 5 and 13; the length of the difference is 12.
  const OutputDifference d =
      only({{"P.X", {3}}, {"P.Y", {4}}, {"P.Z", {0}}}, {{"P.X", {3}}, {"P.Y", {4}}, {"P.Z", {12}}});
  EXPECT_NEAR(d.maximum, 12.0 / 13, 1e-12);
}

// The flow of a surface at rest is rounding: two flows of some 1e-7 m are alike, however different their lengths are.
TEST(CompareOutputs, SceneFlowIsADifferenceInMeters) {
  const auto flow = [](double x, double y, double z) {
    return Channels{{"flow.X", {x}}, {"flow.Y", {y}}, {"flow.Z", {z}}};
  };
  const OutputDifference still = only(flow(1e-7, 0, 0), flow(-3e-7, 0, 2e-7));
  EXPECT_EQ(still.measure, Measure::Difference);
  EXPECT_NEAR(still.maximum, 4e-7, 1e-15);
  EXPECT_EQ(still.beyond, 0u);
  EXPECT_EQ(only(flow(0, 0.2, 0), flow(0, 0.20009, 0)).beyond, 0u);
  EXPECT_EQ(only(flow(0, 0.2, 0), flow(0, 0.20011, 0)).beyond, 1u);
}

// The measures that docs/conventions.md lists.
TEST(CompareOutputs, HasAMeasurePerOutput) {
  const auto namesWith = [](Measure measure) {
    std::vector<std::string_view> names;
    for (const AovInfo& aov : aovs())
      if (measureOf(aov) == measure) names.push_back(aov.name);
    return names;
  };
  using testing::UnorderedElementsAre;
  EXPECT_THAT(namesWith(Measure::Color), UnorderedElementsAre("color", "albedo", "emissive"));
  EXPECT_THAT(namesWith(Measure::Relative), UnorderedElementsAre("depth", "distance", "position", "object-position"));
  EXPECT_THAT(namesWith(Measure::Angle), UnorderedElementsAre("normal", "geonormal", "tangent", "bitangent"));
  EXPECT_THAT(namesWith(Measure::Pixels), UnorderedElementsAre("motion"));
  EXPECT_THAT(namesWith(Measure::Identity), UnorderedElementsAre("id", "part", "material", "triangle"));
}

TEST(CompareOutputs, NormalsAreAngles) {
  // 90 degrees apart; equal except for the length; background in both; background in one.
  const OutputDifference d = only({{"N.X", {1, 1, 0, 0}}, {"N.Y", {0, 0, 0, 1}}, {"N.Z", {0, 0, 0, 0}}},
                                  {{"N.X", {0, 0.5, 0, 0}}, {"N.Y", {1, 0, 0, 0}}, {"N.Z", {0, 0, 0, 0}}});
  EXPECT_NEAR(d.maximum, 90, 1e-12);
  EXPECT_NEAR(d.mean, 30, 1e-12);
  EXPECT_EQ(d.unlike, 1u);
  EXPECT_EQ(d.beyond, 2u);
  // Small angles keep their digits: 1e-6 radians.
  const OutputDifference small =
      only({{"NG.X", {1}}, {"NG.Y", {0}}, {"NG.Z", {0}}}, {{"NG.X", {1}}, {"NG.Y", {1e-6}}, {"NG.Z", {0}}});
  EXPECT_NEAR(small.maximum, 1e-6 * 180 / M_PI, 1e-12);
}

TEST(CompareOutputs, MotionIsInPixels) {
  // The ends differ by (3, 4) to the previous frame, and by (6, 8) to the next one.
  const OutputDifference d = only({{"motion.X", {1}}, {"motion.Y", {1}}, {"motion.Z", {0}}, {"motion.W", {0}}},
                                  {{"motion.X", {4}}, {"motion.Y", {5}}, {"motion.Z", {6}}, {"motion.W", {8}}});
  EXPECT_NEAR(d.maximum, 10, 1e-12);
}

TEST(CompareOutputs, IdsAreEqualOrNot) {
  OutputOptions options;
  options.tolerance = 1e9;  // does not apply to ids
  const OutputDifference d = only({{"id", {1, 2, 4294967295.0, 4}}}, {{"id", {1, 3, 4294967294.0, 4}}}, options);
  EXPECT_EQ(d.beyond, 2u);
  EXPECT_EQ(d.share(), 0.5);
  options.tolerances["id"] = 1e9;
  EXPECT_THAT(errorOf([&] {
                compareOutputs(image({{"id", {1}}}), image({{"id", {2}}}), options);
              }),
              HasSubstr("equal or not"));
}

TEST(CompareOutputs, TolerancesAreByOutput) {
  const ReadImage a = image({{"Z", {1, 1}}, {"R", {0, 0}}, {"G", {0, 0}}, {"B", {0, 0}}}),
                  b = image({{"Z", {1.05, 1}}, {"R", {0, 0.05}}, {"G", {0, 0}}, {"B", {0, 0}}});
  OutputOptions options;
  options.tolerances["depth"] = 0.06;
  for (const OutputDifference& d : compareOutputs(a, b, options)) EXPECT_EQ(d.beyond, d.output == "color");
  options.tolerance = 0.06;
  options.tolerances["depth"] = 0.01;
  for (const OutputDifference& d : compareOutputs(a, b, options)) EXPECT_EQ(d.beyond, d.output == "depth");
  options.tolerances["normal"] = 1;
  EXPECT_THAT(errorOf([&] { compareOutputs(a, b, options); }), HasSubstr("\"normal\""));
}

// --- colors of PNG files and of float files --------------------------------------------------------------------------

// The sRGB code 188/255 is 0.502886 in linear light (IEC 61966-2-1: ((c + 0.055) / 1.055)^2.4).
constexpr double kLinear188 = 0.502886;

TEST(CompareOutputs, ColorsOfPngAreLinearNextToFloats) {
  const double code = 188 / 255.0;
  const ReadImage png = image({{"R", {code}}, {"G", {0}}, {"B", {1}}}, ChannelType::Unorm8),
                  alike = image({{"R", {kLinear188}}, {"G", {0}}, {"B", {1}}}),
                  codes = image({{"R", {code}}, {"G", {0}}, {"B", {1}}});
  for (const auto& [a, b] : {std::pair(png, alike), std::pair(alike, png)}) {
    const OutputDifference d = compareOutputs(a, b)[0];
    EXPECT_NEAR(d.maximum, 0, 1e-6);
    EXPECT_NEAR(d.flip, 0, 1e-4);
    EXPECT_EQ(d.beyond, 0u);
  }
  const OutputDifference d = compareOutputs(png, codes)[0];
  EXPECT_NEAR(d.maximum, code - kLinear188, 1e-6);
  EXPECT_NEAR(d.psnr, 10 * std::log10(3 / std::pow(code - kLinear188, 2)), 1e-3);
  EXPECT_EQ(d.beyond, 1u);
  // Selected channels are converted, too.
  EXPECT_NEAR(compareOutputs(png, alike, {.channels = {"R"}})[0].maximum, 0, 1e-6);
}

// Rounding to 8 bits changes linear values next to white by up to 0.0045, half the step between two levels.
TEST(CompareOutputs, RoundingToALevelIsNoDifference) {
  for (int level = 1; level <= 255; ++level) {
    const double coded = (level - 0.499) / 255;
    const double linear = coded <= 0.04045 ? coded / 12.92 : std::pow((coded + 0.055) / 1.055, 2.4);
    EXPECT_EQ(compareOutputs(image({{"Y", {level / 255.0}}}, ChannelType::Unorm8), image({{"Y", {linear}}}))[0].beyond,
              0u)
        << level;
  }
  EXPECT_EQ(compareOutputs(image({{"Y", {1}}}, ChannelType::Unorm8), image({{"Y", {0.98}}}))[0].beyond, 1u);
}

// Alpha is straight in PNG files and premultiplied in float files.
TEST(CompareOutputs, AlphaOfPngIsPremultipliedNextToFloats) {
  const double code = 188 / 255.0, half = 0.5 * kLinear188;
  const ReadImage png = image({{"R", {code}}, {"G", {code}}, {"B", {code}}, {"A", {0.5}}}, ChannelType::Unorm8),
                  floats = image({{"R", {half}}, {"G", {half}}, {"B", {half}}, {"A", {0.5}}});
  const OutputDifference d = compareOutputs(floats, png)[0];
  EXPECT_NEAR(d.maximum, 0, 1e-6);
  EXPECT_NEAR(d.flip, 0, 1e-4);
  // Two PNG files: FLIP judges what is visible over black, and the maximum the stored codes.
  const ReadImage clear = image({{"R", {code}}, {"G", {0}}, {"B", {0}}, {"A", {0}}}, ChannelType::Unorm8),
                  black = image({{"R", {0}}, {"G", {0}}, {"B", {0}}, {"A", {0}}}, ChannelType::Unorm8);
  EXPECT_EQ(compareOutputs(clear, black)[0].flip, 0);
  EXPECT_NEAR(compareOutputs(clear, black)[0].maximum, code, 1e-12);
}

TEST(CompareOutputs, GrayPngIsColorInBothOrders) {
  const ReadImage png = image({{"Y", {188 / 255.0}}}, ChannelType::Unorm8), floats = image({{"Y", {kLinear188}}});
  for (const auto& [a, b] : {std::pair(png, floats), std::pair(floats, png)}) {
    const OutputDifference d = compareOutputs(a, b)[0];
    EXPECT_EQ(d.output, "color");
    EXPECT_NEAR(d.maximum, 0, 1e-6);
  }
}

// --- files that are named after an output ---------------------------------------------------------------------------

TEST(AsOutput, DecodesPngByItsName) {
  const double level = 1 / 65535.0;
  const ReadImage depth = asOutput(image({{"Y", {0, 1500 * level}}}, ChannelType::Unorm16), "a.depth.png");
  EXPECT_EQ(depth.channels[0].name, "Z");
  EXPECT_EQ(depth.channels[0].values[0], kInf);
  EXPECT_NEAR(depth.channels[0].values[1], 1.5, 1e-9);
  const ReadImage normal =
      asOutput(image({{"R", {0, 1}}, {"G", {0, 0.5}}, {"B", {0, 0.5}}}, ChannelType::Unorm16), "folder/normal.png");
  EXPECT_EQ(normal.find("N.X")->values, (std::vector<double>{0, 1}));
  EXPECT_EQ(normal.find("N.Y")->values, (std::vector<double>{0, 0}));
  const ReadImage id = asOutput(
      image({{"R", {1 / 255.0}}, {"G", {2 / 255.0}}, {"B", {3 / 255.0}}, {"A", {1}}}, ChannelType::Unorm8), "x.id.png");
  EXPECT_EQ(id.find("id")->values[0], 1 + 256 * 2 + 65536 * 3 + 16777216.0 * 255);
  EXPECT_EQ(asOutput(image({{"R", {1}}, {"G", {1}}, {"B", {1}}}, ChannelType::Unorm8), "x.png").channels[0].name, "R");
  for (const char* name : {"x.position.npy", "x.position.NPY"}) {
    const ReadImage array = asOutput(image({{"R", {1}}, {"G", {1}}, {"B", {1}}}), name);
    EXPECT_EQ(array.channels[2].name, "P.Z") << name;
  }
}

// Some tools store only the motion to the previous frame.
TEST(AsOutput, MotionMayHaveTwoChannels) {
  const auto motion = [](double x, double y) { return asOutput(image({{"Y", {x}}, {"A", {y}}}), "a/motion.npy"); };
  const std::vector<OutputDifference> all = compareOutputs(motion(1, 1), motion(4, 5));
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].output, "motion");
  EXPECT_NEAR(all[0].maximum, 5, 1e-12);
}

// Depth in PNG files is rounded to millimeters; one step is no difference.
TEST(AsOutput, AStepOfAPngIsNoDifference) {
  const auto at = [](int millimetres) {
    return asOutput(image({{"Y", {millimetres / 65535.0}}}, ChannelType::Unorm16), "a.depth.png");
  };
  EXPECT_EQ(compareOutputs(at(200), at(201))[0].beyond, 0u);
  EXPECT_EQ(compareOutputs(at(200), at(202))[0].beyond, 1u);
}

// --- FLIP -----------------------------------------------------------------------------------------------------------

LinearPicture uniform(glm::dvec3 color, uint32_t width = 24, uint32_t height = 16) {
  return {width, height, std::vector<glm::dvec3>(size_t{width} * height, color)};
}

double everywhere(const std::vector<double>& errors) {
  const auto [least, most] = std::ranges::minmax_element(errors);
  EXPECT_NEAR(*least, *most, 1e-9);
  return *most;
}

TEST(Flip, OfUniformPicturesIsTheColorMetric) {
  EXPECT_EQ(everywhere(flip(uniform({0.3, 0.5, 0.1}), uniform({0.3, 0.5, 0.1}))), 0);
  // Green and blue have the largest possible distance.
  EXPECT_NEAR(everywhere(flip(uniform({0, 1, 0}), uniform({0, 0, 1}))), 1, 1e-9);
  // Green and blue have the L* a* b* 87.736 -86.179 83.183 and 32.298 79.194 -107.859: with Hunt's effect they are
  // 203.302 apart in HyAB, and 203.302^0.7 = 41.2761. Black and white are 100 apart, and 100^0.7 = 25.1189. Beyond 0.4
  // of the largest, 16.5104, the rest is spread over 0.95 to 1: 0.95 + 0.05 (25.1189 - 16.5104) / (41.2761 - 16.5104).
  EXPECT_NEAR(everywhere(flip(uniform({0, 0, 0}), uniform({1, 1, 1}))), 0.96738, 1e-5);
}

TEST(Flip, IsSymmetricAndFadesWithDistance) {
  LinearPicture a = uniform({0.2, 0.2, 0.2}, 64, 64), b = a;
  b.rgb[32 * 64 + 32] = {1, 1, 1};
  const std::vector<double> errors = flip(a, b), other = flip(b, a);
  for (size_t i = 0; i < errors.size(); ++i) EXPECT_NEAR(errors[i], other[i], 1e-12);
  EXPECT_EQ(std::ranges::max_element(errors) - errors.begin(), 32 * 64 + 32);
  EXPECT_EQ(errors[0], 0);
  // A single pixel matters less from farther away.
  EXPECT_LT(flip(a, b, 200)[32 * 64 + 32], errors[32 * 64 + 32]);
}

}  // namespace
}  // namespace latelight::output
