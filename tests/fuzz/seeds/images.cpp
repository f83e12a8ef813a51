#include <ImfRgbaFile.h>
#include <ImfTiledRgbaFile.h>
#include <turbojpeg.h>
#include <webp/encode.h>
#ifdef LATELIGHT_AVIF
#include <avif/avif.h>
#endif

#include <string>

#include "base/files.h"
#include "fuzz/fuzz.h"
#include "fuzz/seeds/seeds.h"
#include "output/png.h"
#include "scene/environment/environment_cache.h"

namespace latelight::fuzz {

namespace {

constexpr uint32_t kWidth = 13, kHeight = 9;

std::vector<uint8_t> makePixels(size_t bytesPerPixel) {
  std::vector<uint8_t> pixels(kWidth * kHeight * bytesPerPixel);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = uint8_t(i * i / 3 + i);
  return pixels;
}

void addJpegs(Seeds& seeds) {
  const std::vector<uint8_t> pixels = makePixels(3);
  for (const int sampling : {TJSAMP_444, TJSAMP_420, TJSAMP_GRAY})
    for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
      tjhandle encoder = tjInitCompress();
      unsigned char* bytes = nullptr;
      unsigned long size = 0;
      tjCompress2(encoder, pixels.data(), int(kWidth), 0, int(kHeight), TJPF_RGB, &bytes, &size, sampling, 80, flags);
      seeds.add("image", bytesOf(bytes, size));
      tjFree(bytes);
      tjDestroy(encoder);
    }
}

void addPngs(Seeds& seeds) {
  for (const uint32_t channels : {1u, 2u, 3u, 4u})
    for (const uint32_t bits : {8u, 16u}) {
      const std::vector<uint8_t> pixels = makePixels(channels * bits / 8);
      const std::vector<std::byte> png = output::encodePng(
          kWidth, kHeight, channels, bits, bytesOf(pixels.data(), pixels.size()).data(), output::PngLight::Srgb);
      seeds.add("image", png);
      seeds.add("compared_image", png);
    }
}

void addWebps(Seeds& seeds) {
  const std::vector<uint8_t> pixels = makePixels(4);
  uint8_t* bytes = nullptr;
  size_t size = WebPEncodeRGBA(pixels.data(), kWidth, kHeight, kWidth * 4, 70, &bytes);
  seeds.add("image", bytesOf(bytes, size));
  WebPFree(bytes);
  size = WebPEncodeLosslessRGBA(pixels.data(), kWidth, kHeight, kWidth * 4, &bytes);
  seeds.add("image", bytesOf(bytes, size));
  WebPFree(bytes);
}

#ifdef LATELIGHT_AVIF
void addAvif(Seeds& seeds) {
  std::vector<uint8_t> pixels = makePixels(4);
  avifImage* image = avifImageCreate(int(kWidth), int(kHeight), 8, AVIF_PIXEL_FORMAT_YUV420);
  avifRGBImage rgb;
  avifRGBImageSetDefaults(&rgb, image);
  rgb.pixels = pixels.data(), rgb.rowBytes = kWidth * 4;
  avifImageRGBToYUV(image, &rgb);
  avifEncoder* encoder = avifEncoderCreate();
  encoder->speed = AVIF_SPEED_FASTEST;
  avifRWData out = AVIF_DATA_EMPTY;
  if (avifEncoderWrite(encoder, image, &out) == AVIF_RESULT_OK) seeds.add("image", bytesOf(out.data, out.size));
  avifRWDataFree(&out);
  avifEncoderDestroy(encoder);
  avifImageDestroy(image);
}
#endif

// Images by hand: a BMP and TGAs of 2x2 pixels (plain and run-length encoded), and a GIF of one pixel.
void addSimpleImages(Seeds& seeds) {
  using namespace std::string_view_literals;
  const std::string_view files[] = {
      "BM\x46\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\2\0\0\0\1\0\x18\0\0\0\0\0\x10\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
      "\0\0"
      "abcdef\0\0ghijkl\0\0"sv,
      "\0\0\2\0\0\0\0\0\0\0\0\0\2\0\2\0\x18\0abcdefghijkl"sv, "\0\0\xa\0\0\0\0\0\0\0\0\0\2\0\2\0\x20\0\x83zzzz"sv,
      "\0\1\1\0\0\2\0\x18\0\0\0\0\2\0\2\0\x8\0abcdef\0\1\1\0"sv,
      "GIF89a\1\0\1\0\x80\0\0\0\0\0\xff\xff\xff!\xf9\4\1\0\0\0\0,\0\0\0\0\1\0\1\0\0\2\2\x44\1\0;"sv};
  for (const std::string_view file : files) seeds.add("image", file);
}

void addKtx2(Seeds& seeds) {
  const std::filesystem::path folder = std::filesystem::path(LATELIGHT_SOURCE_DIR) / "tests/scene/ktx2";
  for (const char* name : {"etc1s", "etc1s_alpha", "etc1s_one_level", "uastc", "uastc_zstd", "uastc_modes"})
    seeds.add("ktx2", readFile(folder / (std::string(name) + ".ktx2")));
}

void addExrs(Seeds& seeds) {
  const std::string path = (folder() / "seed.exr").string();
  std::vector<Imf::Rgba> pixels;
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) pixels.emplace_back(float(i) / 7, 1.5f, float(i % 5), float(i % 2));
  const auto add = [&] {
    for (const char* target : {"environment", "compared_image"}) seeds.add(target, readFile(path));
  };
  for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression) {
    const Imf::Header header(int(kWidth), int(kHeight), 1, Imath::V2f(0, 0), 1, Imf::INCREASING_Y,
                             Imf::Compression(compression));
    {
      Imf::RgbaOutputFile file(path.c_str(), header, compression % 2 ? Imf::WRITE_RGBA : Imf::WRITE_RGB);
      file.setFrameBuffer(pixels.data(), 1, kWidth);
      file.writePixels(int(kHeight));
    }
    add();
  }
  {
    Imf::TiledRgbaOutputFile file(path.c_str(), int(kWidth), int(kHeight), 8, 8, Imf::ONE_LEVEL);
    file.setFrameBuffer(pixels.data(), 1, kWidth);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  }
  add();
}

// Radiance files: flat, and with the new run-length encoding, whose rows have at least 8 pixels.
void addRadiance(Seeds& seeds) {
  const std::string head = "#?RADIANCE\nEXPOSURE=1.5\nFORMAT=32-bit_rle_rgbe\n\n";
  seeds.add("environment", head +
                               "-Y 2 +X 2\nabc\x80"
                               "def\x81ghi\x7fjkl\x80");
  seeds.add("environment", head + "+Y 2 -X 3\nabc\x80\1\1\1\2def\x81\1\1\1\2");
  std::string rows;
  for (int row = 0; row < 2; ++row)
    rows += std::string("\2\2\0\x8", 4) +
            "\x88R\x88G\x84"
            "B\4bbbb\x88\x80";
  seeds.add("environment", head + "-Y 2 +X 8\n" + rows);
}

void addNpys(Seeds& seeds) {
  const auto add = [&](std::string header, size_t bytes) {
    header.resize(118 - 1, ' ');
    seeds.add("compared_image", std::string("\x93NUMPY\1\0v\0", 10) + header + "\n" + std::string(bytes, 'x'));
  };
  add("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", 24);
  add("{'descr': '<u4', 'fortran_order': False, 'shape': (2, 2, 4), }", 64);
  add("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2, 1), }", 16);
  add("{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2, 3), }", 6);
}

// An environment with the smallest levels that the cache accepts, and a table.
void addCacheEntries(Seeds& seeds) {
  constexpr uint64_t kKey = 0x0123456789abcdef;
  scene::Environment environment;
  const auto map = [](uint32_t size) { return scene::makeRadianceMap(scene::FloatImage(size, size), false); };
  environment.radiance = map(2), environment.diffuse = map(2);
  for (size_t i = 0; i < scene::kSpecularRoughness.size(); ++i) environment.specular.push_back(map(32u >> i));
  scene::storeEnvironment(kKey, environment);
  const auto entry = loadCache(scene::environmentCacheName(kKey));
  if (entry) seeds.add("cache", {"\0", 1}, *entry);
  seeds.add("cache", "\1" + std::string(32, 'f'));
  seeds.add("cache", "\2" + std::string(32, 'f'));
}

}  // namespace

void addImages(Seeds& seeds) {
  start();
  addJpegs(seeds);
  addPngs(seeds);
  addWebps(seeds);
#ifdef LATELIGHT_AVIF
  addAvif(seeds);
#endif
  addSimpleImages(seeds);
  addKtx2(seeds);
  addExrs(seeds);
  addRadiance(seeds);
  addNpys(seeds);
  addCacheEntries(seeds);
}

}  // namespace latelight::fuzz
