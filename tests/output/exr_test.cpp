#include "output/exr.h"

#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIDManifest.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "support.h"

namespace latelight::output {
namespace {

using testing::HasSubstr;

Metadata someMetadata() {
  Metadata metadata;
  metadata.versions = {{"latelight", "1.2.3"}};
  IdManifest ids;
  ids.ids = {{5, "/A", {}, 0, "mesh a", false, {{6, "/A", {}, "mesh a", 0, 9}}},
             {77, "/A/B", 3, 5, "mesh b", true, {{7, "/A/B", 3, "mesh b", 0, 8}, {8, "/A/B", 3, "mesh b", 1, 9}}}};
  ids.materials = {{8, "red", 1}, {9, "blue", 0}};
  metadata.ids = std::make_shared<IdManifest>(std::move(ids));
  return metadata;
}

class Exr : public InFolder {
 protected:
  void write(const std::vector<AovImage>& images, const Metadata& metadata) {
    std::vector<const AovImage*> pointers;
    for (const AovImage& image : images) pointers.push_back(&image);
    writeFile(at("f.exr"), encodeExr(pointers, metadata));
  }
  // The header as OpenEXR reads it from the file.
  Imf::Header header() const { return Imf::InputFile(at("f.exr").c_str()).header(); }
};

std::vector<AovImage> allImages(uint32_t width, uint32_t height) {
  return frameOfNumbers(width, height).aovs;
}

TEST_F(Exr, HasTheChannelsOfTheDesign) {
  write(allImages(20, 10), {});
  const std::map<std::string, Imf::PixelType> expected{{"R", Imf::HALF},
                                                       {"G", Imf::HALF},
                                                       {"B", Imf::HALF},
                                                       {"A", Imf::HALF},
                                                       {"Z", Imf::FLOAT},
                                                       {"distance", Imf::FLOAT},
                                                       {"N.X", Imf::FLOAT},
                                                       {"N.Y", Imf::FLOAT},
                                                       {"N.Z", Imf::FLOAT},
                                                       {"NG.X", Imf::FLOAT},
                                                       {"NG.Y", Imf::FLOAT},
                                                       {"NG.Z", Imf::FLOAT},
                                                       {"P.X", Imf::FLOAT},
                                                       {"P.Y", Imf::FLOAT},
                                                       {"P.Z", Imf::FLOAT},
                                                       {"albedo.R", Imf::HALF},
                                                       {"albedo.G", Imf::HALF},
                                                       {"albedo.B", Imf::HALF},
                                                       {"metallic", Imf::HALF},
                                                       {"roughness", Imf::HALF},
                                                       {"emissive.R", Imf::HALF},
                                                       {"emissive.G", Imf::HALF},
                                                       {"emissive.B", Imf::HALF},
                                                       {"ao", Imf::HALF},
                                                       {"id", Imf::UINT},
                                                       {"uv.U", Imf::FLOAT},
                                                       {"part", Imf::UINT},
                                                       {"material", Imf::UINT},
                                                       {"uv.V", Imf::FLOAT},
                                                       {"object.X", Imf::FLOAT},
                                                       {"object.Y", Imf::FLOAT},
                                                       {"object.Z", Imf::FLOAT},
                                                       {"nocs.X", Imf::FLOAT},
                                                       {"nocs.Y", Imf::FLOAT},
                                                       {"nocs.Z", Imf::FLOAT},
                                                       {"raw", Imf::FLOAT},
                                                       {"barycentric.A", Imf::FLOAT},
                                                       {"barycentric.B", Imf::FLOAT},
                                                       {"barycentric.C", Imf::FLOAT},
                                                       {"triangle", Imf::UINT},
                                                       {"T.X", Imf::FLOAT},
                                                       {"T.Y", Imf::FLOAT},
                                                       {"T.Z", Imf::FLOAT},
                                                       {"BT.X", Imf::FLOAT},
                                                       {"BT.Y", Imf::FLOAT},
                                                       {"BT.Z", Imf::FLOAT},
                                                       {"flow.X", Imf::FLOAT},
                                                       {"flow.Y", Imf::FLOAT},
                                                       {"flow.Z", Imf::FLOAT},
                                                       {"curvature.mean", Imf::FLOAT},
                                                       {"curvature.gaussian", Imf::FLOAT},
                                                       {"lights.tested", Imf::FLOAT},
                                                       {"samples", Imf::FLOAT},
                                                       {"lights.used", Imf::FLOAT},
                                                       {"motion.X", Imf::FLOAT},
                                                       {"motion.Y", Imf::FLOAT},
                                                       {"motion.Z", Imf::FLOAT},
                                                       {"motion.W", Imf::FLOAT},
                                                       {"raster.class", Imf::FLOAT},
                                                       {"raster.facing", Imf::FLOAT},
                                                       {"cluster.instance", Imf::FLOAT},
                                                       {"cluster.part", Imf::FLOAT},
                                                       {"triangle.instance", Imf::FLOAT},
                                                       {"triangle.number", Imf::FLOAT},
                                                       {"overdraw", Imf::FLOAT}};
  const Imf::Header file = header();
  std::map<std::string, Imf::PixelType> found;
  for (auto c = file.channels().begin(); c != file.channels().end(); ++c) found[c.name()] = c.channel().type;
  EXPECT_EQ(found, expected);
}

// The nearest half float, rounded here independently; beyond the range, the largest finite one.
double storedHalf(double value) {
  if (!std::isfinite(value)) return value;
  int exponent = 0;
  std::frexp(value, &exponent);
  const double step = std::ldexp(1.0, std::max(exponent, -13) - 11);
  return std::clamp(std::nearbyint(value / step) * step, -65504.0, 65504.0);
}

TEST_F(Exr, HoldsEveryAovExactly) {
  const std::vector<AovImage> images = allImages(67, 45);  // not a multiple of a block of 16 rows
  write(images, {});
  const ReadImage back = readImage(at("f.exr"));
  ASSERT_EQ(back.width, 67u);
  ASSERT_EQ(back.height, 45u);
  for (const AovImage& image : images) {
    const AovInfo& aov = info(image.aov);
    for (size_t c = 0; c < aov.channels; ++c) {
      const Channel* channel = back.find(aov.exrChannels[c]);
      ASSERT_TRUE(channel) << aov.exrChannels[c];
      for (size_t p = 0; p < channel->values.size(); ++p) {
        double want = image.ids.empty() ? image.values[p * aov.channels + c] : static_cast<double>(image.ids[p]);
        if (aov.exr == ExrType::Half) want = storedHalf(want);
        ASSERT_EQ(channel->values[p], want) << aov.exrChannels[c] << " pixel " << p;
      }
    }
  }
}

TEST_F(Exr, KeepsInfinityAndNanButMakesNone) {
  AovImage color = makeAovImage(Aov::Color, 1, 1), depth = makeAovImage(Aov::Depth, 1, 1);
  color.values = {1e9f, -1e9f, std::numeric_limits<float>::infinity(), std::nanf("")};
  write({color, depth}, {});
  const ReadImage back = readImage(at("f.exr"));
  EXPECT_EQ(back.find("R")->values[0], 65504);
  EXPECT_EQ(back.find("G")->values[0], -65504);
  EXPECT_EQ(back.find("B")->values[0], std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(back.find("A")->values[0]));
  EXPECT_EQ(back.find("Z")->values[0], std::numeric_limits<double>::infinity());
}

TEST_F(Exr, CarriesTheIdManifestOfOpenExr) {
  write({numbers(Aov::Id, 4, 4)}, someMetadata());
  const Imf::Header file = header();
  ASSERT_TRUE(Imf::hasIDManifest(file));
  const Imf::IDManifest manifest = Imf::idManifest(file);
  ASSERT_EQ(manifest.size(), 1u);
  const auto& group = manifest[manifest.find("id")];
  EXPECT_EQ(group.getComponents(), (std::vector<std::string>{"node", "parent", "mesh", "materials", "skinned"}));
  EXPECT_EQ(group.size(), 2u);
  EXPECT_EQ(group.find(5).text(), (std::vector<std::string>{"/A", "0", "mesh a", "blue", "no"}));
  EXPECT_EQ(group.find(77).text(), (std::vector<std::string>{"/A/B/instance3", "5", "mesh b", "red, blue", "yes"}));

  write({numbers(Aov::Material, 4, 4), numbers(Aov::Part, 4, 4)}, someMetadata());
  const Imf::Header both = header();
  const Imf::IDManifest two = Imf::idManifest(both);
  ASSERT_EQ(two.size(), 2u);
  const auto& parts = two[two.find("part")];
  EXPECT_EQ(parts.getComponents(), (std::vector<std::string>{"id", "node", "mesh", "primitive", "material"}));
  EXPECT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts.find(8).text(), (std::vector<std::string>{"77", "/A/B/instance3", "mesh b", "1", "9"}));
  const auto& materials = two[two.find("material")];
  EXPECT_EQ(materials.getComponents(), (std::vector<std::string>{"name", "index"}));
  EXPECT_EQ(materials.find(9).text(), (std::vector<std::string>{"blue", "0"}));

  write({numbers(Aov::Depth, 4, 4)}, someMetadata());
  EXPECT_FALSE(Imf::hasIDManifest(header()));
}

TEST_F(Exr, SaysWhatMadeItAndHow) {
  write({numbers(Aov::Depth, 4, 4)}, someMetadata());
  const Imf::Header file = header();
  EXPECT_EQ(file.typedAttribute<Imf::StringAttribute>("software").value(), "latelight 1.2.3");
  const auto json = nlohmann::json::parse(file.typedAttribute<Imf::StringAttribute>("latelight").value());
  EXPECT_EQ(json["aovs"]["depth"]["unit"], "m");
  EXPECT_FALSE(json.contains("ids"));
  EXPECT_TRUE(Imf::hasChromaticities(file));
  EXPECT_FALSE(Imf::hasCapDate(file));
}

// A camera at (1, 2, 3) in glTF's frame that looks along -X with Y up.
Metadata sidewaysCamera(const std::string& convention) {
  Metadata metadata;
  metadata.camera.convention = convention;
  const double flip = convention == "opencv" ? -1 : 1;  // OpenCV's Y is down and its Z forward
  metadata.camera.cameraToWorld =
      glm::dmat4(glm::dvec4(0, 0, -1, 0), glm::dvec4(0, flip, 0, 0), glm::dvec4(flip, 0, 0, 0), glm::dvec4(1, 2, 3, 1));
  metadata.camera.intrinsics = {200, 0, 40, 0, 100 * -flip, 25, 0, 0, -flip};
  if (convention == "opengl") metadata.camera.intrinsics = {200, 0, -40, 0, -100, -25, 0, 0, -1};
  return metadata;
}

TEST_F(Exr, HasOpenExrsCameraMatrices) {
  for (const char* convention : {"opencv", "opengl"}) {
    write({makeAovImage(Aov::Depth, 80, 50)}, sidewaysCamera(convention));
    // 4 m ahead, 1 m up, 2 m to the right, which is -Z.
    const Imath::V3f point(1 - 4, 2 + 1, 3 - 2);
    Imath::V3f inCamera, inNdc;
    Imf::worldToCamera(header()).multVecMatrix(point, inCamera);
    Imf::worldToNDC(header()).multVecMatrix(point, inNdc);
    EXPECT_NEAR((inCamera - Imath::V3f(2, 1, 4)).length(), 0, 1e-5) << convention;
    // 200 * 2 / 4 + 40 = 140 of 80 pixels; 25 - 100 / 4 = 0.
    EXPECT_NEAR(inNdc.x, 140.0 / 80, 1e-5) << convention;
    EXPECT_NEAR(inNdc.y, 0, 1e-5) << convention;
  }
}

TEST_F(Exr, HasOpenExrsMatricesOfAnOrthographicCamera) {
  Metadata metadata;
  metadata.camera.orthographic = true;
  metadata.camera.intrinsics = {10, 0, 40, 0, 10, 25, 0, 0, 1};
  write({makeAovImage(Aov::Depth, 80, 50)}, metadata);
  Imath::V3f ndc;
  Imf::worldToNDC(header()).multVecMatrix(Imath::V3f(2, 1, 9), ndc);
  EXPECT_NEAR(ndc.x, 60.0 / 80, 1e-6);
  EXPECT_NEAR(ndc.y, 35.0 / 50, 1e-6);
}

TEST_F(Exr, IsTheSameEveryTime) {
  const std::vector<AovImage> images = allImages(300, 200);
  write(images, someMetadata());
  const std::vector<std::byte> first = readFile(at("f.exr"));
  for (int i = 0; i < 3; ++i) {
    write(images, someMetadata());
    EXPECT_EQ(readFile(at("f.exr")), first);
  }
}

// Another program reads the file: the tool of Debian's package openexr.
TEST_F(Exr, IsReadByExrheader) {
  if (!std::filesystem::exists("/usr/bin/exrheader")) GTEST_SKIP() << "there is no exrheader: install openexr";
  write(allImages(20, 10), someMetadata());
  FILE* pipe = popen(("/usr/bin/exrheader " + at("f.exr")).c_str(), "r");
  ASSERT_TRUE(pipe);
  std::string text;
  char buffer[4096];
  while (const size_t got = fread(buffer, 1, sizeof(buffer), pipe)) text.append(buffer, got);
  EXPECT_EQ(pclose(pipe), 0);
  EXPECT_THAT(text, HasSubstr("Z, 32-bit floating-point"));
  EXPECT_THAT(text, HasSubstr("albedo.R, 16-bit floating-point"));
  EXPECT_THAT(text, HasSubstr("id, 32-bit unsigned integer"));
}

}  // namespace
}  // namespace latelight::output
