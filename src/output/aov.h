// The outputs that a frame can be asked for (arbitrary output variables, AOVs), from outputs.def.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::output {

// In the order of outputs.def, which says what each is.
enum class Aov : uint8_t {
#define OUTPUT(aov, ...) aov,
#include "output/outputs.def"
};
inline constexpr size_t kAovCount = 0
#define OUTPUT(...) +1
#include "output/outputs.def"
    ;

// How an OpenEXR file stores a channel. Half: 11 bits of precision, finite values beyond 65504 are stored as 65504.
enum class ExrType : uint8_t { Half, Float, Uint };

// How a PNG file stores an AOV. Clamped means to the range of the coding; NaN is stored as 0.
enum class PngCoding : uint8_t {
  None,        // not offered: the range of the values is not known beforehand
  Display,     // 8 bit RGBA, sRGB, straight alpha, tonemapped: for viewing
  Srgb,        // 8 bit RGB, sRGB, clamped to [0, 1]
  Unit,        // 16 bit, [0, 1] as 0..65535, clamped
  Signed,      // 16 bit, [-1, 1] as n * 0.5 + 0.5, clamped; background is 0, a code that no unit normal has
  Millimetre,  // 16 bit grey, rounded; 65535 stands for 65.535 m and beyond, 0 for background
  Fraction,    // 16 bit RGB: the fraction, u - floor(u), of u and v; blue is 0
  Count,       // 16 bit grey; 65535 stands for that many or more
  IdBytes,     // 8 bit RGBA: the id's bytes, R the lowest (alpha is the highest byte, not coverage)
};

struct AovInfo {
  Aov aov;
  std::string_view name;                        // as in --aov and in file names
  uint32_t channels;                            // values a pixel
  std::array<std::string_view, 4> exrChannels;  // names in an OpenEXR file, the first `channels` of them
  ExrType exr;
  PngCoding png;
  float background;              // every channel of a pixel where nothing is drawn (and no background is asked for)
  std::string_view unit;         // "m", "1", ...
  std::string_view description;  // one line
};

// In the order of the enum.
std::span<const AovInfo> aovs();
const AovInfo& info(Aov aov);

// What an OpenEXR file calls a channel of an output.
using ChannelNames = std::string (*)(const AovInfo& aov, uint32_t channel);
std::string ownNames(const AovInfo& aov, uint32_t channel);  // exrChannels

bool contains(std::span<const Aov> aovs, Aov aov);

// id, part and material: what the id manifest lists.
bool holdsIds(Aov aov);

// raster-...: what the raster compute did, rather than what the scene is.
bool tellsOfRaster(Aov aov);

// Null where there is none of that name.
const AovInfo* findAov(std::string_view name);

// "depth,normal,id" in that order, without repeats. Throws Error(Usage) that lists the names.
std::vector<Aov> parseAovs(std::string_view list);

// One AOV of one view. Rows from the top, channels interleaved.
struct AovImage {
  Aov aov = Aov::Color;
  uint32_t width = 0, height = 0;
  std::vector<float> values;  // width * height * channels; empty where holdsIds()
  std::vector<uint32_t> ids;  // width * height, where holdsIds()
};

// All values are background.
AovImage makeAovImage(Aov aov, uint32_t width, uint32_t height);

// RGBA, 8 bits a channel, sRGB, straight alpha, rows from the top: pictures for viewing.
struct Picture {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba;
};

}  // namespace latelight::output
