#include "output/read.h"

#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfTiledRgbaFile.h>
#include <spng.h>

#include "output/exr.h"
#include "output/npy.h"
#include "output/png.h"
#include "support.h"

namespace latelight::output {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Reading : public InFolder {
 protected:
  // Encoded by libspng, for the kinds of PNG that Latelight reads but does not write.
  void writePng(uint8_t colorType, uint8_t bits, const std::vector<uint8_t>& rows, const spng_plte* palette = nullptr,
                const spng_trns* transparent = nullptr) {
    spng_ctx* context = spng_ctx_new(SPNG_CTX_ENCODER);
    spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
    spng_ihdr header{2, 1, bits, colorType, 0, 0, 0};
    spng_set_ihdr(context, &header);
    if (palette) spng_set_plte(context, const_cast<spng_plte*>(palette));
    if (transparent) spng_set_trns(context, const_cast<spng_trns*>(transparent));
    ASSERT_EQ(spng_encode_image(context, rows.data(), rows.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
    size_t size = 0;
    int error = 0;
    void* png = spng_get_png_buffer(context, &size, &error);
    writeFile(at("x.png"), {static_cast<const std::byte*>(png), size});
    free(png);
    spng_ctx_free(context);
  }
  std::vector<double> bytes(const char* channel) const {
    const ReadImage image = readImage(at("x.png"));
    std::vector<double> values = image.find(channel)->values;
    for (double& value : values) value = std::round(value * 255);
    return values;
  }
};

TEST_F(Reading, ExpandsPalettes) {
  const spng_plte palette{2, {{1, 2, 3, 0}, {4, 5, 6, 0}}};
  writePng(SPNG_COLOR_TYPE_INDEXED, 8, {1, 0}, &palette);
  EXPECT_EQ(bytes("R"), (std::vector<double>{4, 1}));
  EXPECT_EQ(bytes("B"), (std::vector<double>{6, 3}));
  const spng_trns transparent{0, 0, 0, 0, 2, {0, 128}};
  writePng(SPNG_COLOR_TYPE_INDEXED, 8, {1, 0}, &palette, &transparent);
  EXPECT_EQ(bytes("G"), (std::vector<double>{5, 2}));
  EXPECT_EQ(bytes("A"), (std::vector<double>{128, 0}));
}

TEST_F(Reading, ExpandsFewBits) {
  writePng(SPNG_COLOR_TYPE_GRAYSCALE, 1, {0x80});
  EXPECT_EQ(bytes("Y"), (std::vector<double>{255, 0}));
  writePng(SPNG_COLOR_TYPE_GRAYSCALE, 4, {0x1f});
  EXPECT_EQ(bytes("Y"), (std::vector<double>{17, 255}));
}

TEST_F(Reading, TakesTiledExrWithAnOffsetWindow) {
  std::vector<Imf::Rgba> pixels(40 * 30, Imf::Rgba(0.5f, 2, 0, 1));
  pixels[3] = Imf::Rgba(7, 0, 0, 0);
  {
    const Imath::Box2i window({10, 20}, {49, 49});
    Imf::TiledRgbaOutputFile file(at("t.exr").c_str(), 16, 16, Imf::ONE_LEVEL, Imf::ROUND_DOWN, window, window);
    file.setFrameBuffer(pixels.data() - 20 * 40 - 10, 1, 40);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  }
  const ReadImage image = readImage(at("t.exr"));
  ASSERT_EQ(image.width, 40u);
  ASSERT_EQ(image.height, 30u);
  EXPECT_EQ(image.find("R")->values[3], 7);
  EXPECT_EQ(image.find("G")->values[40 * 30 - 1], 2);
  EXPECT_EQ(image.find("R")->type, ChannelType::Half);
}

TEST_F(Reading, RefusesSubSampledExr) {
  {
    Imf::RgbaOutputFile file(at("l.exr").c_str(), 4, 4, Imf::WRITE_YC);
    const std::vector<Imf::Rgba> pixels(16);
    file.setFrameBuffer(pixels.data(), 1, 4);
    file.writePixels(4);
  }
  EXPECT_THAT(errorOf([&] { readImage(at("l.exr")); }, ExitCode::BadInput),
              AllOf(HasSubstr("l.exr"), HasSubstr("subsampled")));
}

TEST_F(Reading, KnowsFormatsByTheirFirstBytes) {
  writeFile(at("x.exr"), encodePng(numbers(Aov::Ao, 3, 3)));
  EXPECT_EQ(readImage(at("x.exr")).channels[0].type, ChannelType::Unorm16);
  writeFile(at("x.png"), std::as_bytes(std::span("GIF89a")));
  EXPECT_THAT(errorOf([&] { readImage(at("x.png")); }, ExitCode::BadInput), HasSubstr("not a PNG, OpenEXR or NPY"));
  writeFile(at("x.png"), {});
  EXPECT_THAT(errorOf([&] { readImage(at("x.png")); }, ExitCode::BadInput), HasSubstr("x.png"));
  EXPECT_THAT(errorOf([&] { readImage(at("missing.png")); }, ExitCode::BadInput), HasSubstr("missing.png"));
}

std::vector<std::byte> goodFile(Format format) {
  const AovImage color = numbers(Aov::Color, 23, 19), id = numbers(Aov::Id, 23, 19);
  const AovImage* images[] = {&color, &id};
  Metadata metadata;
  metadata.ids = std::make_shared<IdManifest>(IdManifest{.ids = {{.id = 1, .node = "/a", .mesh = "b"}}});
  if (format == Format::Png) return encodePng(color);
  if (format == Format::Npy) return encodeNpy(color);
  return encodeExr(images, metadata);
}

class Broken : public testing::TestWithParam<Format> {
 protected:
  // Returns true if the bytes are read as an image. Otherwise expects an error that names the file.
  static bool reads(const std::vector<std::byte>& bytes, const std::string& what) {
    try {
      if (GetParam() == Format::Png) decodePng(bytes, "the/file");
      if (GetParam() == Format::Exr) decodeExr(bytes, "the/file");
      if (GetParam() == Format::Npy) decodeNpy(bytes, "the/file");
      return true;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::BadInput) << what;
      EXPECT_THAT(error.what(), HasSubstr("the/file")) << what;
      return false;
    }
  }
};

TEST_P(Broken, FilesCutShortAreAnError) {
  const std::vector<std::byte> good = goodFile(GetParam());
  for (size_t size = 8; size < good.size(); size += 1 + good.size() / 200) {
    std::vector<std::byte> bytes(good.begin(), good.begin() + static_cast<ptrdiff_t>(size));
    EXPECT_THROW(
        {
          if (GetParam() == Format::Png) decodePng(bytes, "x");
          if (GetParam() == Format::Exr) decodeExr(bytes, "x");
          if (GetParam() == Format::Npy) decodeNpy(bytes, "x");
        },
        Error)
        << "cut to " << size;
  }
}

// PNG has a checksum over everything that is decoded; the other formats have bytes of which any value is valid.
TEST_P(Broken, FilesAreReadOrRejectedByName) {
  const std::vector<std::byte> good = goodFile(GetParam());
  ASSERT_TRUE(reads(good, "the good file"));
  std::mt19937 random(11);
  int read = 0, rejected = 0;
  for (int i = 0; i < 600; ++i) {
    std::vector<std::byte> bytes = good;
    // Headers are short and matter most, so every other flip changes one.
    const size_t range = i % 2 ? std::min<size_t>(bytes.size(), 400) : bytes.size();
    const size_t at = random() % range;
    bytes[at] ^= static_cast<std::byte>(1 + random() % 255);
    ++(reads(bytes, "byte " + std::to_string(at)) ? read : rejected);
  }
  EXPECT_GE(rejected, GetParam() == Format::Png ? 590 : 20) << read << " read";
  if (GetParam() != Format::Png) {
    EXPECT_GE(read, 20);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Formats, Broken, testing::Values(Format::Png, Format::Exr, Format::Npy), [](const auto& param) {
      return std::string(param.param == Format::Png ? "Png" : param.param == Format::Exr ? "Exr" : "Npy");
    });

}  // namespace
}  // namespace latelight::output
