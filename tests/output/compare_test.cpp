#include "output/compare.h"

#include "support.h"

namespace latelight::output {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kInf = std::numeric_limits<double>::infinity();
const double kNan = std::nan("");

ReadImage picture(ChannelType type, std::vector<double> values, const std::string& name = "Y") {
  ReadImage image{static_cast<uint32_t>(values.size()), 1, {}};
  image.channels.push_back({name, type, std::move(values)});
  return image;
}

TEST(Compare, FindsNoDifferenceBetweenEquals) {
  const ReadImage a = picture(ChannelType::Float, {1, -2, kInf, kNan});
  const Comparison c = compare(a, a);
  EXPECT_EQ(c.maximum, 0);
  EXPECT_EQ(c.mean, 0);
  EXPECT_EQ(c.psnr, kInf);
  EXPECT_EQ(c.beyond, 0u);
  EXPECT_EQ(c.unlike, 0u);
  EXPECT_EQ(c.share(), 0);
}

TEST(Compare, MeasuresPicturesMadeByHand) {
  // Differences 0, 0.1, 0, 0.3: mean 0.1, mean square 0.025, peak 1: PSNR 10 log10(40) = 16.0206 dB.
  const ReadImage a = picture(ChannelType::Unorm8, {0.2, 0.2, 0.5, 0.1});
  const ReadImage b = picture(ChannelType::Unorm8, {0.2, 0.3, 0.5, 0.4});
  const Comparison c = compare(a, b);
  EXPECT_NEAR(c.maximum, 0.3, 1e-12);
  EXPECT_NEAR(c.mean, 0.1, 1e-12);
  EXPECT_NEAR(c.psnr, 16.0206, 1e-4);
  EXPECT_EQ(c.beyond, 2u);
  EXPECT_EQ(c.pixels, 4u);
  EXPECT_EQ(c.share(), 0.5);
  EXPECT_EQ(c.worstX, 3u);
  EXPECT_EQ(c.worstY, 0u);
  EXPECT_EQ(c.worstChannel, "Y");
}

// As peak_signal_noise_ratio(a, b, data_range=1) of scikit-image: the mean square is 0.01 in each case.
TEST(Compare, PsnrHasADataRangeOfOne) {
  const auto psnr = [](std::vector<double> a, std::vector<double> b) {
    return compare(picture(ChannelType::Float, std::move(a)), picture(ChannelType::Float, std::move(b))).psnr;
  };
  EXPECT_NEAR(psnr({0.5, 0.5}, {0.6, 0.4}), 20, 1e-9);
  EXPECT_NEAR(psnr({1000.5, 0.5}, {1000.6, 0.4}), 20, 1e-9) << "bright pixels do not raise it";
  EXPECT_NEAR(psnr({0.6, 0.4}, {0.5, 0.5}), 20, 1e-9) << "in the other order";
}

TEST(Compare, CountsAPixelOnceWhateverItsChannels) {
  ReadImage a = picture(ChannelType::Unorm8, {0, 0, 0}, "R"), b = picture(ChannelType::Unorm8, {1, 0, 0}, "R");
  a.channels.push_back({"G", ChannelType::Unorm8, {0, 0, 0}});
  b.channels.push_back({"G", ChannelType::Unorm8, {1, 0, 1}});
  const Comparison c = compare(a, b);
  EXPECT_EQ(c.beyond, 2u);
  // Half of the six values differ by 1.
  EXPECT_NEAR(c.mean, 0.5, 1e-12);
  EXPECT_NEAR(c.psnr, 10 * std::log10(2.0), 1e-9);
}

TEST(Compare, AllowsOneLevelAndNotTwo) {
  for (int level = 0; level < 254; ++level) {
    const auto at = [](int l) { return picture(ChannelType::Unorm8, {l / 255.0}); };
    EXPECT_EQ(compare(at(level), at(level + 1)).beyond, 0u) << level;
    EXPECT_EQ(compare(at(level), at(level + 2)).beyond, 1u) << level;
  }
  const auto at16 = [](int l) { return picture(ChannelType::Unorm16, {l / 65535.0}); };
  EXPECT_EQ(compare(at16(4000), at16(4001)).beyond, 0u);
  EXPECT_EQ(compare(at16(4000), at16(4002)).beyond, 1u);
}

TEST(Compare, IsRelativeForLargeFloatsAndAbsoluteForSmall) {
  const auto differ = [](double x, double y) {
    return compare(picture(ChannelType::Float, {x}), picture(ChannelType::Float, {y})).beyond == 1;
  };
  EXPECT_FALSE(differ(1000, 1000.09));
  EXPECT_TRUE(differ(1000, 1000.2));
  EXPECT_FALSE(differ(0, 0.00009));
  EXPECT_TRUE(differ(0, 0.0002));
}

TEST(Compare, TakesIdsForEqualOrNot) {
  const auto id = [](double x) { return picture(ChannelType::Integer, {x}); };
  EXPECT_EQ(compare(id(4294967295.0), id(4294967295.0)).beyond, 0u);
  EXPECT_EQ(compare(id(4294967295.0), id(4294967294.0)).beyond, 1u);
}

TEST(Compare, KnowsInfinityAndNan) {
  const ReadImage a = picture(ChannelType::Float, {kInf, kInf, -kInf, kNan, kNan, 1, 2});
  const ReadImage b = picture(ChannelType::Float, {kInf, -kInf, 5, kNan, 1, kInf, 2.5});
  const Comparison c = compare(a, b);
  EXPECT_EQ(c.maximum, kInf);
  EXPECT_EQ(c.unlike, 4u);
  EXPECT_EQ(c.beyond, 5u);
  EXPECT_NEAR(c.mean, 0.5 / 3, 1e-12);
}

// There is no mean square over a difference that is infinite or NaN.
TEST(Compare, PsnrIsUndefinedIfAPixelIsUnlike) {
  const ReadImage a = picture(ChannelType::Float, {1, 2});
  EXPECT_TRUE(std::isnan(compare(a, picture(ChannelType::Float, {1, kNan})).psnr));
  EXPECT_TRUE(std::isnan(compare(picture(ChannelType::Float, {kInf, 2.5}), a).psnr));
}

TEST(Compare, HeedsTheToleranceGiven) {
  const ReadImage a = picture(ChannelType::Unorm8, {0, 0.5}), b = picture(ChannelType::Unorm8, {0.1, 0.5});
  CompareOptions options;
  options.tolerance = 0.11;
  EXPECT_EQ(compare(a, b, options).beyond, 0u);
  options.tolerance = 0.09;
  EXPECT_EQ(compare(a, b, options).beyond, 1u);
  options.tolerance = 0;
  EXPECT_EQ(compare(a, a, options).beyond, 0u);
}

TEST(Compare, HeedsTheChannelsChosen) {
  ReadImage a = picture(ChannelType::Float, {0}, "Z"), b = picture(ChannelType::Float, {0}, "Z");
  a.channels.push_back({"A", ChannelType::Float, {1}});
  b.channels.push_back({"B", ChannelType::Float, {2}});
  CompareOptions options;
  options.channels = {"Z"};
  EXPECT_EQ(compare(a, b, options).beyond, 0u);
  options.channels = {"A"};
  EXPECT_THAT(errorOf([&] { compare(a, b, options); }, ExitCode::BadInput), HasSubstr("only the first"));
  options.channels = {"Q"};
  EXPECT_THAT(errorOf([&] { compare(a, b, options); }), AllOf(HasSubstr("\"Q\""), HasSubstr("Z A")));
  EXPECT_THAT(errorOf([&] { compare(a, b); }, ExitCode::BadInput), HasSubstr("different channels"));
}

TEST(Compare, MatchesSingleChannelsWhateverTheirNames) {
  EXPECT_EQ(compare(picture(ChannelType::Float, {3}, "Z"), picture(ChannelType::Float, {3}, "Y")).beyond, 0u);
}

TEST(Compare, RefusesDifferentSizes) {
  const ReadImage a = picture(ChannelType::Float, {1}), b = picture(ChannelType::Float, {1, 2});
  EXPECT_THAT(errorOf([&] { compare(a, b); }, ExitCode::BadInput), AllOf(HasSubstr("1x1"), HasSubstr("2x1")));
}

TEST(DifferencePicture, IsGreyWithinTheToleranceAndColouredBeyond) {
  CompareOptions options;
  options.tolerance = 0.1;
  const std::vector<double> differences = excesses(picture(ChannelType::Unorm8, {0, 0, 0, 0, 0}),
                                                   picture(ChannelType::Unorm8, {0, 0.05, 0.1, 0.11, 1}), options);
  const Picture p = differencePicture(5, 1, differences);
  const auto pixel = [&](size_t i) { return std::vector<int>(p.rgba.begin() + 4 * i, p.rgba.begin() + 4 * i + 4); };
  EXPECT_EQ(pixel(0), (std::vector<int>{0, 0, 0, 255}));
  EXPECT_EQ(pixel(1), (std::vector<int>{64, 64, 64, 255}));
  EXPECT_EQ(pixel(2), (std::vector<int>{128, 128, 128, 255}));
  EXPECT_EQ(pixel(3)[0], 255);
  EXPECT_GT(pixel(3)[1], 200);
  EXPECT_EQ(pixel(3)[2], 0);
  EXPECT_LT(pixel(4)[1], pixel(3)[1]);
  const Picture unlike =
      differencePicture(1, 1, excesses(picture(ChannelType::Float, {1}), picture(ChannelType::Float, {kInf})));
  EXPECT_EQ(unlike.rgba, (std::vector<uint8_t>{255, 0, 0, 255}));
}

}  // namespace
}  // namespace latelight::output
