// Reading .hdr and .exr files: every variant, and damaged files.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "base/error.h"
#include "base/files.h"
#include "scene/environment_support.h"

namespace latelight::scene {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::byte>;

void append(Bytes& bytes, std::string_view text) {
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
}
void append(Bytes& bytes, std::initializer_list<int> values) {
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
}

Bytes hdrHeader(std::string_view resolution) {
  Bytes bytes;
  append(bytes, "#?RADIANCE\n# a comment\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n");
  append(bytes, resolution);
  append(bytes, "\n");
  return bytes;
}

std::string failure(const Bytes& bytes) {
  try {
    decodePicture(bytes, "some.picture");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::BadInput);
    EXPECT_THAT(error.what(), HasSubstr("some.picture"));
    return error.what();
  }
  return "";
}

TEST(Half, EveryHalfThereAndBack) {
  std::vector<uint16_t> all, back(65536);
  for (uint32_t i = 0; i < 65536; ++i) all.push_back(static_cast<uint16_t>(i));
  std::vector<float> floats(65536);
  floatsFromHalves(all.data(), floats.data(), all.size());
  halvesFromFloats(floats.data(), back.data(), floats.size());
  for (uint32_t i = 0; i < 65536; ++i) {
    if (std::isnan(floats[i])) continue;
    ASSERT_EQ(back[i], i);
    ASSERT_EQ(floats[i], floatFromHalf(static_cast<uint16_t>(i)));
    ASSERT_EQ(halfFromFloat(floats[i]), i);
  }
}

// Between two half floats: rounds to the nearer one, and ties to even, on the processor and in Imath alike.
TEST(Half, RoundsToNearestEven) {
  for (uint32_t i = 0; i < 0x7bff; ++i) {
    const float low = floatFromHalf(static_cast<uint16_t>(i)), high = floatFromHalf(static_cast<uint16_t>(i + 1));
    const float middle = (low + high) * 0.5f;
    std::vector<float> in(8);
    in[0] = middle, in[1] = std::nextafter(middle, 0.0f), in[2] = std::nextafter(middle, 1e9f), in[3] = -middle;
    std::vector<uint16_t> out(8);
    halvesFromFloats(in.data(), out.data(), 8);
    ASSERT_EQ(out[0], (i & 1) ? i + 1 : i);
    ASSERT_EQ(out[1], i);
    ASSERT_EQ(out[2], i + 1);
    ASSERT_EQ(out[3], out[0] | 0x8000);
    for (size_t k = 0; k < 4; ++k) ASSERT_EQ(halfFromFloat(in[k]), out[k]);
  }
}

TEST(Radiance, FlatPixels) {
  Bytes bytes = hdrHeader("-Y 1 +X 3");
  append(bytes, {128, 64, 0, 129, 255, 1, 2, 136, 9, 9, 9, 0});
  const FloatImage image = decodePicture(bytes, "flat");
  ASSERT_EQ(image.width, 3u);
  ASSERT_EQ(image.height, 1u);
  EXPECT_THAT(image.pixels,
              testing::ElementsAre(1.0f, 0.5f, 0.0f, 1.0f, 255.0f, 1.0f, 2.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f));
}

TEST(Radiance, OldRunLengths) {
  Bytes bytes = hdrHeader("-Y 2 +X 300");
  append(bytes, {200, 100, 50, 136, 1, 1, 1, 43, 1, 1, 1, 1});  // 1 + 43 + (1 << 8) pixels
  for (int i = 0; i < 300; ++i) append(bytes, {128, i % 100, 0, 136});
  const FloatImage image = decodePicture(bytes, "old");
  for (size_t x = 0; x < 300; ++x) {
    EXPECT_EQ(image.at(x, 0)[0], 200.0f);
    EXPECT_EQ(image.at(x, 0)[2], 50.0f);
    EXPECT_EQ(image.at(x, 1)[1], static_cast<float>(x % 100));
  }
}

TEST(Radiance, NewRunLengths) {
  Bytes bytes = hdrHeader("-Y 1 +X 10");
  append(bytes, {2, 2, 0, 10});
  append(bytes, {138, 77});                           // red: a run of ten times 77
  append(bytes, {10, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9});  // green: ten literals
  append(bytes, {132, 5, 2, 6, 7, 132, 8});           // blue: a run of four 5, literals 6 and 7, a run of four 8
  append(bytes, {138, 136});                          // exponent: a run of ten
  const FloatImage image = decodePicture(bytes, "new");
  const float blue[] = {5, 5, 5, 5, 6, 7, 8, 8, 8, 8};
  for (size_t x = 0; x < 10; ++x) {
    EXPECT_EQ(image.at(x, 0)[0], 77.0f);
    EXPECT_EQ(image.at(x, 0)[1], static_cast<float>(x));
    EXPECT_EQ(image.at(x, 0)[2], blue[x]);
  }
}

TEST(Radiance, RowsInAnyOrder) {
  for (const char* resolution : {"-Y 2 +X 2", "+Y 2 +X 2", "-Y 2 -X 2", "+Y 2 -X 2"}) {
    Bytes bytes = hdrHeader(resolution);
    append(bytes, {1, 0, 0, 136, 2, 0, 0, 136, 3, 0, 0, 136, 4, 0, 0, 136});
    const FloatImage image = decodePicture(bytes, "order");
    const size_t top = resolution[0] == '-' ? 0 : 1, left = resolution[5] == '+' ? 0 : 1;
    EXPECT_EQ(image.at(left, top)[0], 1.0f) << resolution;
    EXPECT_EQ(image.at(1 - left, top)[0], 2.0f) << resolution;
    EXPECT_EQ(image.at(left, 1 - top)[0], 3.0f) << resolution;
  }
}

TEST(Radiance, SaysWhatIsWrong) {
  EXPECT_THAT(failure(hdrHeader("-Y 512 +X 1024")), HasSubstr("truncated"));
  EXPECT_THAT(failure(hdrHeader("-Y 100000000 +X 100000000")), HasSubstr("million"));
  EXPECT_THAT(failure(hdrHeader("-Y 4294967296 +X 2")), HasSubstr("valid size"));
  EXPECT_THAT(failure(hdrHeader("-Y 0 +X 2")), HasSubstr("valid size"));
  EXPECT_THAT(failure(hdrHeader("-Y -5 +X 2")), HasSubstr("valid size"));
  EXPECT_THAT(failure(hdrHeader("nonsense")), HasSubstr("valid size"));
  EXPECT_THAT(failure(hdrHeader("+X 2 -Y 2")), HasSubstr("columns"));
  Bytes xyz;
  append(xyz, "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd");
  EXPECT_THAT(failure(xyz), HasSubstr("32-bit_rle_xyze"));
  Bytes unbounded;
  append(unbounded, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n");
  EXPECT_THAT(failure(unbounded), HasSubstr("header"));
  Bytes run = hdrHeader("-Y 1 +X 10");
  append(run, {2, 2, 0, 10, 255, 77, 0, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_THAT(failure(run), HasSubstr("longer than the row"));
  Bytes first = hdrHeader("-Y 1 +X 10");
  append(first, {1, 1, 1, 5, 0, 0, 0, 0});
  EXPECT_THAT(failure(first), HasSubstr("longer than the row"));
}

// --- OpenEXR
// ----------------------------------------------------------------------------------------------------------

using Box = Imath::Box2i;

struct ExrOptions {
  Box display{{0, 0}, {15, 7}}, data{{0, 0}, {15, 7}};
  std::vector<std::string> channels{"R", "G", "B"};
  Imf::PixelType type = Imf::HALF;
  bool tiled = false;
  int parts = 1;
  int depthParts = 0;  // parts in front of these, which have only the channel Z, with the values of the first channel
};

// The value of channel c at (x, y): small integers, exact in every type.
float exrValue(size_t c, int x, int y) {
  return static_cast<float>(1 + c * 300 + static_cast<size_t>(x + 20) + 40 * static_cast<size_t>(y + 10) % 200);
}

Imf::Header exrHeader(const ExrOptions& options) {
  Imf::Header header(options.display, options.data);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const std::string& name : options.channels) header.channels().insert(name, Imf::Channel(options.type));
  if (options.tiled) header.setTileDescription(Imf::TileDescription(8, 4, Imf::ONE_LEVEL));
  return header;
}

Bytes makeExr(const ExrOptions& options) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "a.exr").string();
  const int width = options.data.max.x - options.data.min.x + 1, height = options.data.max.y - options.data.min.y + 1;
  const size_t bytes = options.type == Imf::HALF ? 2 : 4;
  std::vector<std::vector<std::byte>> planes;
  Imf::FrameBuffer buffer;
  for (size_t c = 0; c < options.channels.size(); ++c) {
    planes.emplace_back(bytes * static_cast<size_t>(width * height));
    for (int i = 0; i < width * height; ++i) {
      const float value = exrValue(c, options.data.min.x + i % width, options.data.min.y + i / width);
      const uint16_t half = halfFromFloat(value);
      const auto whole = static_cast<uint32_t>(value);
      const void* from = options.type == Imf::HALF   ? static_cast<const void*>(&half)
                         : options.type == Imf::UINT ? static_cast<const void*>(&whole)
                                                     : &value;
      std::memcpy(planes[c].data() + bytes * static_cast<size_t>(i), from, bytes);
    }
    buffer.insert(options.channels[c], Imf::Slice::Make(options.type, planes[c].data(), options.data));
  }
  const Imf::Header header = exrHeader(options);
  if (options.tiled) {
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  } else {
    Imf::Header depthHeader = header;
    depthHeader.channels() = {};
    depthHeader.channels().insert("Z", Imf::Channel(options.type));
    Imf::FrameBuffer depth;
    depth.insert("Z", Imf::Slice::Make(options.type, planes[0].data(), options.data));
    std::vector<Imf::Header> headers(static_cast<size_t>(options.depthParts), depthHeader);
    headers.resize(static_cast<size_t>(options.depthParts + options.parts), header);
    for (size_t i = 0; i < headers.size(); ++i) {
      headers[i].setName("part" + std::to_string(i));
      headers[i].setType(Imf::SCANLINEIMAGE);
    }
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
    for (int i = 0; i < file.parts(); ++i) {
      Imf::OutputPart part(file, i);
      part.setFrameBuffer(i < options.depthParts ? depth : buffer);
      part.writePixels(height);
    }
  }
  return readFile(path);
}

void expectPixels(const FloatImage& image, const ExrOptions& options, const std::array<int, 3>& channels) {
  const Box& display = options.display;
  ASSERT_EQ(static_cast<int>(image.width), display.max.x - display.min.x + 1);
  ASSERT_EQ(static_cast<int>(image.height), display.max.y - display.min.y + 1);
  for (int y = display.min.y; y <= display.max.y; ++y) {
    for (int x = display.min.x; x <= display.max.x; ++x) {
      const float* p = image.at(static_cast<size_t>(x - display.min.x), static_cast<size_t>(y - display.min.y));
      const bool inside = options.data.intersects(Imath::V2i(x, y));
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(p[c], inside ? exrValue(static_cast<size_t>(channels[c]), x, y) : 0.0f) << x << ", " << y;
      }
    }
  }
}

TEST(Exr, EveryTypeOfChannel) {
  for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT, Imf::UINT}) {
    ExrOptions options;
    options.type = type;
    expectPixels(decodePicture(makeExr(options), "type"), options, {0, 1, 2});
  }
}

TEST(Exr, AlphaIsReadOrOne) {
  ExrOptions options;
  EXPECT_EQ(decodePicture(makeExr(options), "no alpha").at(3, 3)[3], 1.0f);
  options.channels = {"R", "G", "B", "A"};
  EXPECT_EQ(decodePicture(makeExr(options), "alpha").at(3, 4)[3], exrValue(3, 3, 4));
}

TEST(Exr, GreyAndLayersAndTilesAndParts) {
  ExrOptions grey;
  grey.channels = {"Y"};
  expectPixels(decodePicture(makeExr(grey), "grey"), grey, {0, 0, 0});
  ExrOptions layers;
  layers.channels = {"Depth.Z", "View.B", "View.G", "View.R"};
  expectPixels(decodePicture(makeExr(layers), "layers"), layers, {3, 2, 1});
  ExrOptions tiles;
  tiles.tiled = true;
  tiles.data = tiles.display = Box({0, 0}, {20, 10});
  expectPixels(decodePicture(makeExr(tiles), "tiles"), tiles, {0, 1, 2});
  ExrOptions parts;
  parts.parts = 3;
  expectPixels(decodePicture(makeExr(parts), "parts"), parts, {0, 1, 2});
}

TEST(Exr, TheFirstPartWithColorsIsRead) {
  for (const int depthParts : {1, 2}) {
    ExrOptions options;
    options.depthParts = depthParts;
    expectPixels(decodePicture(makeExr(options), "colors"), options, {0, 1, 2});
    options.channels = {"Y"};
    options.parts = 2;
    expectPixels(decodePicture(makeExr(options), "gray"), options, {0, 0, 0});
    options.channels = {"N.X"};
    EXPECT_THAT(failure(makeExr(options)), HasSubstr("nor Y, but: Z"));
  }
}

TEST(Exr, ThePictureIsTheDisplayWindow) {
  ExrOptions options;
  options.display = Box({-4, -2}, {11, 5});
  for (const Box& data : {Box({-4, -2}, {11, 5}), Box({0, 0}, {3, 3}), Box({-9, -5}, {15, 9}), Box({-9, 3}, {-1, 9})}) {
    options.data = data;
    expectPixels(decodePicture(makeExr(options), "windows"), options, {0, 1, 2});
  }
}

TEST(Exr, SaysWhatIsWrong) {
  ExrOptions options;
  options.channels = {"Z"};
  EXPECT_THAT(failure(makeExr(options)), HasSubstr("neither the channels R G B nor Y"));
  options.channels = {"R", "G"};
  EXPECT_THAT(failure(makeExr(options)), HasSubstr("neither the channels R G B nor Y"));
}

// --- broken files
// -----------------------------------------------------------------------------------------------------

Bytes makeHdr() {
  Bytes bytes = hdrHeader("-Y 4 +X 12");
  for (int row = 0; row < 4; ++row) {
    append(bytes, {2, 2, 0, 12});
    for (int channel = 0; channel < 4; ++channel) append(bytes, {134, 130 + row, 6, 128, 129, 130, 131, 132, 133});
  }
  return bytes;
}

TEST(BrokenPictures, EveryTruncationIsAnError) {
  ExrOptions tiles;
  tiles.tiled = true;
  for (const Bytes& whole : {makeHdr(), makeExr({}), makeExr(tiles)}) {
    ASSERT_EQ(failure(whole), "");
    for (size_t length = 0; length < whole.size(); ++length) {
      EXPECT_NE(failure(Bytes(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(length))), "") << length;
    }
  }
}

// A file with a flipped byte may still be an image; anything other than an image or an Error fails the test.
TEST(BrokenPictures, FlippedBytesAreErrorsOrPictures) {
  ExrOptions tiles;
  tiles.tiled = true;
  std::mt19937 random(11);
  size_t errors = 0;
  for (const Bytes& whole : {makeHdr(), makeExr({}), makeExr(tiles)}) {
    for (int i = 0; i < 600; ++i) {
      Bytes bytes = whole;
      for (int flips = 0; flips < 1 + i % 3; ++flips) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
      errors += failure(bytes).empty() ? 0 : 1;
    }
  }
  EXPECT_GT(errors, 100u);
}

}  // namespace
}  // namespace latelight::scene
