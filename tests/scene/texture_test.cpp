// Codecs and mip levels.
#include "scene/textures/texture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spng.h>
#include <turbojpeg.h>
#include <webp/encode.h>

#include <cmath>
#include <cstring>
#include <random>

#include "base/error.h"
#ifdef LATELIGHT_AVIF
#include <avif/avif.h>
#endif

namespace latelight::scene {
namespace {

using testing::HasSubstr;
using Encoded = std::vector<std::byte>;

struct Picture {
  uint32_t width, height;
  std::vector<uint8_t> rgba;
};

Picture smoothPicture(uint32_t width, uint32_t height) {
  Picture p{width, height, {}};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      for (double v : {x * 255.0 / width, y * 255.0 / height, 128 + 100 * std::sin(x * .1 + y * .07), 255.0})
        p.rgba.push_back(uint8_t(v));
  return p;
}

Picture noise(uint32_t width, uint32_t height) {
  Picture p{width, height, std::vector<uint8_t>(size_t(width) * height * 4)};
  std::mt19937 random(width * 1000 + height);
  for (uint8_t& v : p.rgba) v = uint8_t(random());
  return p;
}

Encoded toPng(const Picture& p, int bits = 8, int colorType = SPNG_COLOR_TYPE_TRUECOLOR_ALPHA,
              int interlace = SPNG_INTERLACE_NONE) {
  spng_ctx* context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  spng_ihdr header{p.width, p.height, uint8_t(bits), uint8_t(colorType), 0, 0, uint8_t(interlace)};
  spng_set_ihdr(context, &header);
  EXPECT_EQ(spng_encode_image(context, p.rgba.data(), p.rgba.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
  size_t size = 0;
  int error = 0;
  auto* bytes = static_cast<std::byte*>(spng_get_png_buffer(context, &size, &error));
  Encoded out(bytes, bytes + size);
  std::free(bytes);
  spng_ctx_free(context);
  return out;
}

Encoded toJpeg(const std::vector<uint8_t>& pixels, uint32_t width, uint32_t height, TJPF format, TJSAMP sampling,
               int flags = 0) {
  tjhandle encoder = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(encoder, pixels.data(), int(width), 0, int(height), format, &bytes, &size, sampling, 95, flags),
            0);
  Encoded out(reinterpret_cast<std::byte*>(bytes), reinterpret_cast<std::byte*>(bytes) + size);
  tjFree(bytes);
  tjDestroy(encoder);
  return out;
}

std::string errorOf(std::span<const std::byte> encoded) {
  try {
    decodeTexture(encoded, false, "images[7] (rust.png)");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::BadInput);
    EXPECT_THAT(error.what(), HasSubstr("images[7] (rust.png)"));
    return error.what();
  }
  ADD_FAILURE() << "decoded without an error";
  return {};
}

int largestDifference(const Texture& texture, const std::vector<uint8_t>& wanted) {
  int most = 0;
  for (size_t i = 0; i < wanted.size(); ++i) most = std::max(most, std::abs(int(texture.pixels[i]) - int(wanted[i])));
  return most;
}

TEST(TextureCodecs, PngIsExact) {
  Picture p = noise(37, 21);
  Texture texture = decodeTexture(toPng(p), false, "p");
  EXPECT_EQ(texture.width, 37u);
  EXPECT_EQ(texture.height, 21u);
  EXPECT_EQ(texture.levels, 6u);
  EXPECT_EQ(texture.bytes(), 4u * (37 * 21 + 18 * 10 + 9 * 5 + 4 * 2 + 2 * 1 + 1));
  EXPECT_EQ(largestDifference(texture, p.rgba), 0);
}

// The inputs are all values of 16 bits, in images whose sizes are no multiples of the blocks of interlaced files.
TEST(TextureCodecs, PngOfSixteenBitsIsRoundedToEight) {
  for (const int interlace : {SPNG_INTERLACE_NONE, SPNG_INTERLACE_ADAM7})
    for (const uint32_t width : {1u, 3u, 13u, 100u}) {
      const uint32_t height = (16384 + width - 1) / width;  // 4 channels per pixel
      Picture wide{width, height, {}};
      std::vector<uint8_t> expected;
      for (uint32_t i = 0; i < 4 * width * height; ++i) {
        const auto value = uint16_t(i * 40503);  // an odd factor permutes the values
        wide.rgba.insert(wide.rgba.end(),
                         {uint8_t(value & 255), uint8_t(value >> 8)});  // libspng expects the host's order
        expected.push_back(uint8_t(std::lround(value / 257.0)));
      }
      const Encoded png = toPng(wide, 16, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, interlace);
      EXPECT_EQ(largestDifference(decodeTexture(png, false, "p"), expected), 0) << width << " " << interlace;
    }
}

TEST(TextureCodecs, GrayPngOfSixteenBitsIsRounded) {
  const Picture gray{2, 1, {0xff, 0xfe, 0x00, 0x01}};  // 65279 / 257 = 254.004 and 256 / 257 = 0.996
  EXPECT_EQ(largestDifference(decodeTexture(toPng(gray, 16, SPNG_COLOR_TYPE_GRAYSCALE), false, "p"),
                              {254, 254, 254, 255, 1, 1, 1, 255}),
            0);
}

TEST(TextureCodecs, GreyPng) {
  Picture grey{3, 1, {0, 100, 255}};
  Texture texture = decodeTexture(toPng(grey, 8, SPNG_COLOR_TYPE_GRAYSCALE), false, "p");
  EXPECT_EQ(largestDifference(texture, {0, 0, 0, 255, 100, 100, 100, 255, 255, 255, 255, 255}), 0);
}

TEST(TextureCodecs, JpegOfEveryKind) {
  Picture p = smoothPicture(67, 45);
  for (TJSAMP sampling : {TJSAMP_444, TJSAMP_422, TJSAMP_420})
    for (int flags : {0, TJFLAG_PROGRESSIVE})
      EXPECT_LE(
          largestDifference(decodeTexture(toJpeg(p.rgba, 67, 45, TJPF_RGBX, sampling, flags), false, "p"), p.rgba), 12);
  Picture grey = p;
  for (size_t i = 0; i < grey.rgba.size(); i += 4) grey.rgba[i + 1] = grey.rgba[i + 2] = grey.rgba[i];
  EXPECT_LE(largestDifference(decodeTexture(toJpeg(grey.rgba, 67, 45, TJPF_RGBX, TJSAMP_GRAY), false, "p"), grey.rgba),
            12);
}

TEST(TextureCodecs, JpegOfFourInks) {
  // Adobe's inverted inks: 255 is no ink. Half black over cyan.
  std::vector<uint8_t> inks;
  for (int i = 0; i < 64; ++i) inks.insert(inks.end(), {0, 255, 255, 128});
  Texture texture = decodeTexture(toJpeg(inks, 8, 8, TJPF_CMYK, TJSAMP_444), false, "p");
  EXPECT_LE(largestDifference(texture, {0, 128, 128, 255}), 3);
}

TEST(TextureCodecs, Webp) {
  Picture p = noise(20, 30);
  uint8_t* bytes = nullptr;
  size_t size = WebPEncodeLosslessRGBA(p.rgba.data(), 20, 30, 80, &bytes);
  Encoded encoded(reinterpret_cast<std::byte*>(bytes), reinterpret_cast<std::byte*>(bytes) + size);
  WebPFree(bytes);
  Texture texture = decodeTexture(encoded, false, "p");
  // Lossless encoders drop the color of invisible pixels.
  for (size_t i = 0; i < p.rgba.size(); i += 4)
    if (p.rgba[i + 3] == 0) std::memset(&p.rgba[i], 0, 4), std::memset(&texture.pixels[i], 0, 4);
  EXPECT_EQ(largestDifference(texture, p.rgba), 0);
  encoded.resize(encoded.size() / 2);
  EXPECT_THAT(errorOf(encoded), HasSubstr("WebP"));
}

#ifdef LATELIGHT_AVIF
// Lossless, as red, green and blue, whose texels are all kept.
Encoded toAvif(const Picture& p) {
  avifImage* image = avifImageCreate(int(p.width), int(p.height), 8, AVIF_PIXEL_FORMAT_YUV444);
  image->matrixCoefficients = AVIF_MATRIX_COEFFICIENTS_IDENTITY;
  avifRGBImage rgb;
  avifRGBImageSetDefaults(&rgb, image);
  rgb.pixels = const_cast<uint8_t*>(p.rgba.data());
  rgb.rowBytes = 4 * p.width;
  EXPECT_EQ(avifImageRGBToYUV(image, &rgb), AVIF_RESULT_OK);
  avifEncoder* encoder = avifEncoderCreate();
  encoder->minQuantizer = encoder->maxQuantizer = encoder->minQuantizerAlpha = encoder->maxQuantizerAlpha = 0;
  encoder->speed = AVIF_SPEED_FASTEST;
  avifRWData out = AVIF_DATA_EMPTY;
  EXPECT_EQ(avifEncoderWrite(encoder, image, &out), AVIF_RESULT_OK);
  const auto* bytes = reinterpret_cast<const std::byte*>(out.data);
  Encoded encoded(bytes, bytes + out.size);
  avifRWDataFree(&out);
  avifEncoderDestroy(encoder);
  avifImageDestroy(image);
  return encoded;
}

TEST(TextureCodecs, Avif) {
  const Picture p = noise(20, 30);
  Encoded encoded = toAvif(p);
  EXPECT_EQ(largestDifference(decodeTexture(encoded, false, "p"), p.rgba), 0);
  encoded.resize(encoded.size() / 2);
  EXPECT_THAT(errorOf(encoded), HasSubstr("AVIF"));
}
#endif

TEST(TextureCodecs, UncompressedTga) {
  std::vector<uint8_t> tga = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 32, 0x28, 3, 2, 1, 200};
  EXPECT_EQ(largestDifference(decodeTexture(std::as_bytes(std::span(tga)), false, "p"), {1, 2, 3, 200}), 0);
}

// Bits 4 and 5 of the descriptor: columns from the right, rows from the top (Truevision TGA 2.0, field 5.6). The image
// has the rows 1 2 3 and 4 5 6.
TEST(TextureCodecs, TgaOfEveryOrder) {
  const std::vector<uint8_t> header = {0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 2, 0, 8};
  const std::vector<std::pair<uint8_t, std::vector<uint8_t>>> orders = {
      {0x20, {1, 2, 3, 4, 5, 6}}, {0x30, {3, 2, 1, 6, 5, 4}}, {0x00, {4, 5, 6, 1, 2, 3}}, {0x10, {6, 5, 4, 3, 2, 1}}};
  for (const auto& [descriptor, pixels] : orders) {
    std::vector<uint8_t> tga = header;
    tga.push_back(descriptor);
    tga.insert(tga.end(), pixels.begin(), pixels.end());
    EXPECT_EQ(largestDifference(decodeTexture(std::as_bytes(std::span(tga)), false, "p"),
                                {1, 1, 1, 255, 2, 2, 2, 255, 3, 3, 3, 255, 4, 4, 4, 255, 5, 5, 5, 255, 6, 6, 6, 255}),
              0)
        << int(descriptor);
  }
}

// A negative height states that rows are stored from the top (BITMAPINFOHEADER).
TEST(TextureCodecs, BmpFromTheTop) {
  for (const bool fromTop : {false, true}) {
    const uint8_t sign = fromTop ? 0xff : 0, height = fromTop ? 0xfe : 2;
    std::vector<uint8_t> bmp = {'B', 'M', 70, 0, 0, 0, 0, 0,      0,    0,    54,   0, 0, 0,  40,
                                0,   0,   0,  1, 0, 0, 0, height, sign, sign, sign, 1, 0, 24, 0};
    bmp.resize(54);
    const std::vector<uint8_t> top = {30, 20, 10, 0}, bottom = {60, 50, 40, 0};  // blue, green, red, padding
    for (const auto& row : fromTop ? std::array{top, bottom} : std::array{bottom, top})
      bmp.insert(bmp.end(), row.begin(), row.end());
    EXPECT_EQ(
        largestDifference(decodeTexture(std::as_bytes(std::span(bmp)), false, "p"), {10, 20, 30, 255, 40, 50, 60, 255}),
        0)
        << fromTop;
  }
}

// The smallest BMP, TGA and GIF images whose pixels end at the end of the file, each with its texels.
struct TinyImage {
  const char* format;
  std::vector<uint8_t> encoded, texels;
  size_t endOfHeader = 0;  // in bytes
};

std::vector<TinyImage> tinyImages() {
  // 2 x 1 pixels of 24 bits without the two bytes that pad the row.
  TinyImage bmp{"BMP",
                {'B', 'M', 60, 0, 0, 0, 0, 0, 0, 0, 54, 0, 0, 0, 40, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 24, 0}};
  bmp.encoded.resize(54);
  bmp.encoded.insert(bmp.encoded.end(), {30, 20, 10, 60, 50, 40});
  bmp.texels = {10, 20, 30, 255, 40, 50, 60, 255};
  bmp.endOfHeader = 54;
  const std::vector<uint8_t> rgba = {1, 2, 3, 200, 1, 2, 3, 200};
  const TinyImage tga{
      "TGA", {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 32, 0x28, 3, 2, 1, 200, 3, 2, 1, 200}, rgba, 18};
  const TinyImage packed{
      "TGA", {0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 32, 0x28, 0x81, 3, 2, 1, 200}, rgba, 18};
  // A GIF of 2 x 1 pixels, with the codes clear (4), 1, 1 and end (5) of 3 bits, and no trailer.
  TinyImage gif{"GIF", {'G', 'I', 'F', '8', '9', 'a', 2, 0, 1, 0, 0x80, 0, 0, 1, 2, 3, 7, 8, 9}};
  gif.encoded.insert(gif.encoded.end(), {0x2c, 0, 0, 0, 0, 2, 0, 1, 0, 0, 2, 2, 0x4c, 0x0a, 0});
  gif.texels = {7, 8, 9, 255, 7, 8, 9, 255};
  gif.endOfHeader = 19;
  return {bmp, tga, packed, gif};
}

TEST(TextureCodecs, BmpTgaAndGifEndAfterTheirLastPixel) {
  for (const TinyImage& image : tinyImages()) {
    SCOPED_TRACE(image.format);
    std::vector<uint8_t> bytes = image.encoded;
    EXPECT_EQ(largestDifference(decodeTexture(std::as_bytes(std::span(bytes)), false, "p"), image.texels), 0);
    bytes.insert(bytes.end(), 200, 0xff);
    EXPECT_EQ(largestDifference(decodeTexture(std::as_bytes(std::span(bytes)), false, "p"), image.texels), 0);
    for (size_t size = image.endOfHeader; size < image.encoded.size(); ++size)
      EXPECT_THAT(errorOf(std::as_bytes(std::span(image.encoded).first(size))), HasSubstr("is truncated")) << size;
  }
}

TEST(TextureCodecs, BrokenPictures) {
  Encoded png = toPng(noise(64, 64));
  png.resize(png.size() / 2);
  EXPECT_THAT(errorOf(png), HasSubstr("PNG"));
  Encoded wide = toPng({32, 64, noise(64, 64).rgba}, 16);
  wide.resize(wide.size() / 2);
  EXPECT_THAT(errorOf(wide), HasSubstr("PNG"));
  Picture p = smoothPicture(64, 64);
  Encoded jpeg = toJpeg(p.rgba, 64, 64, TJPF_RGBX, TJSAMP_420);
  jpeg.resize(jpeg.size() / 2);
  EXPECT_THAT(errorOf(jpeg), HasSubstr("JPEG"));
  for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
    const Encoded whole = toJpeg(p.rgba, 64, 64, TJPF_RGBX, TJSAMP_420, flags);
    for (size_t size = 0; size < whole.size(); ++size)
      EXPECT_NE(errorOf(std::span(whole).first(size)), "") << flags << " " << size;
  }
  EXPECT_THAT(errorOf({}), HasSubstr("is not a"));
  const char ktx[] = "\xabKTX 20\xbb\r\n\x1a\n";
  EXPECT_THAT(errorOf(std::as_bytes(std::span(ktx))), HasSubstr("KTX"));
}

TEST(TextureCodecs, HugePicturesAreRefusedByTheirHeader) {
  Encoded png = toPng(noise(1, 1));
  png[16] = std::byte{0x00}, png[17] = std::byte{0x01};  // width 65537; the chunk's checksum is wrong now, too
  EXPECT_FALSE(errorOf(png).empty());
}

// --- mip levels
// -------------------------------------------------------------------------------------------------------

Texture textureOf(const Picture& p, bool srgb) {
  Texture texture = makeTexture({p.width, p.height}, srgb, "t");
  std::memcpy(texture.pixels.get(), p.rgba.data(), p.rgba.size());
  buildMips(texture);
  return texture;
}

double toLinear(double c) {
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}
double toSrgb(double l) {
  return l <= 0.0031308 ? l * 12.92 : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
}

// The mean over the area that pixel (x, y) of the next level covers, in double precision.
double areaMean(const uint8_t* level, ImageSize from, ImageSize to, uint32_t x, uint32_t y, int channel, bool srgb) {
  double sum = 0, area = 0;
  double x0 = double(x) * from.width / to.width, x1 = double(x + 1) * from.width / to.width;
  double y0 = double(y) * from.height / to.height, y1 = double(y + 1) * from.height / to.height;
  for (uint32_t j = uint32_t(y0); j < std::min(from.height, uint32_t(std::ceil(y1))); ++j)
    for (uint32_t i = uint32_t(x0); i < std::min(from.width, uint32_t(std::ceil(x1))); ++i) {
      double w = (std::min(x1, i + 1.0) - std::max(x0, double(i))) * (std::min(y1, j + 1.0) - std::max(y0, double(j)));
      double v = level[(size_t(j) * from.width + i) * 4 + size_t(channel)] / 255.0;
      sum += w * (srgb && channel < 3 ? toLinear(v) : v);
      area += w;
    }
  double mean = sum / area;
  return 255 * (srgb && channel < 3 ? toSrgb(mean) : mean);
}

TEST(TextureMips, EveryLevelIsTheMeanOfTheOneBefore) {
  for (auto [width, height] : {std::pair{64u, 64u}, {63u, 31u}, {1u, 9u}, {100u, 1u}, {30u, 17u}, {5u, 3u}})
    for (bool srgb : {false, true}) {
      Texture texture = textureOf(noise(width, height), srgb);
      auto* level = reinterpret_cast<const uint8_t*>(texture.pixels.get());
      ImageSize from{width, height};
      for (uint32_t l = 1; l < texture.levels; ++l) {
        ImageSize to{std::max(1u, from.width / 2), std::max(1u, from.height / 2)};
        const uint8_t* next = level + size_t(from.width) * from.height * 4;
        for (uint32_t y = 0; y < to.height; ++y)
          for (uint32_t x = 0; x < to.width; ++x)
            for (int c = 0; c < 4; ++c)
              // Half a step of rounding, and the table's 14 bits.
              ASSERT_NEAR(next[(size_t(y) * to.width + x) * 4 + size_t(c)], areaMean(level, from, to, x, y, c, srgb),
                          0.65)
                  << width << 'x' << height << " level " << l << (srgb ? " srgb" : "");
        level = next;
        from = to;
      }
      EXPECT_EQ(reinterpret_cast<const std::byte*>(level) + 4, texture.pixels.get() + texture.bytes());
    }
}

TEST(TextureMips, FlatColorsSurvive) {
  for (auto [width, height] : {std::pair{32u, 32u}, {31u, 7u}})
    for (bool srgb : {false, true})
      for (int value = 0; value < 256; ++value) {
        Texture texture =
            textureOf({width, height, std::vector<uint8_t>(size_t(width) * height * 4, uint8_t(value))}, srgb);
        for (size_t i = 0; i < texture.bytes(); ++i)
          ASSERT_EQ(int(texture.pixels[i]), value) << (srgb ? "srgb" : "linear");
      }
}

// As long as one of them exists, and only for the same decoding.
TEST(SharedPixels, AreThoseOfPicturesWithTheSameBytes) {
  const Encoded first = toPng(noise(16, 16)), second = toPng(noise(16, 17));
  Texture one = decodeTexture(first, true, "one");
  const std::weak_ptr<std::byte[]> pixels = one.pixels;
  const std::vector<std::byte> before(one.pixels.get(), one.pixels.get() + one.bytes());
  Texture two = decodeTexture(first, true, "two");
  EXPECT_EQ(two.pixels, one.pixels);
  EXPECT_EQ(two.name, "two");
  EXPECT_EQ(two.levels, one.levels);
  EXPECT_NE(decodeTexture(first, false, "linear").pixels, one.pixels);
  EXPECT_NE(decodeTexture(second, true, "other").pixels, one.pixels);
  one = {}, two = {};
  EXPECT_TRUE(pixels.expired());
  const Texture again = decodeTexture(first, true, "again");
  EXPECT_EQ(std::memcmp(again.pixels.get(), before.data(), before.size()), 0);
}

}  // namespace
}  // namespace latelight::scene
