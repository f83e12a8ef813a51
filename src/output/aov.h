// The outputs that can be requested of a frame (arbitrary output variables, AOVs), from outputs.def.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::output {

// In the order of outputs.def, which describes each output.
enum class Aov : uint8_t {
#define OUTPUT(aov, ...) aov,
#include "output/outputs.def"
};
inline constexpr size_t kAovCount = 0
#define OUTPUT(...) +1
#include "output/outputs.def"
    ;

// How an OpenEXR file stores a channel. Half has 11 bits of precision; finite values beyond 65504 are stored as 65504.
enum class ExrType : uint8_t { Half, Float, Uint };

// How a PNG file stores an AOV. "Clamped" means to the range of the coding. NaN is stored as 0.
enum class PngCoding : uint8_t {
  None,        // not supported: the range of the values is unknown in advance
  Display,     // 8 bit RGBA, sRGB, straight alpha, tone mapped: for viewing
  Srgb,        // 8 bit RGB, sRGB, clamped to [0, 1]
  Unit,        // 16 bit, [0, 1] as 0..65535, clamped
  Signed,      // 16 bit, [-1, 1] as n * 0.5 + 0.5, clamped; background is 0, the code of no unit normal
  Millimetre,  // 16 bit gray, rounded; 65535 stands for 65.535 m and beyond, 0 for background
  Fraction,    // 16 bit RGB: the fraction, u - floor(u), of u and v; blue is 0
  Count,       // 16 bit gray; 65535 stands for that many or more
  IdBytes,     // 8 bit RGBA: the id's bytes, R the lowest (alpha is the highest byte, not coverage)
};

struct AovInfo {
  Aov aov;
  std::string_view name;                        // as in --aov and in file names
  uint32_t channels;                            // values per pixel
  std::array<std::string_view, 4> exrChannels;  // names in an OpenEXR file, the first `channels` of them
  ExrType exr;
  PngCoding png;
  float background;              // every channel of a pixel where nothing is drawn (and no background is requested)
  std::string_view unit;         // "m", "1", ...
  std::string_view description;  // one line
};

// In the order of the enum.
std::span<const AovInfo> aovs();
const AovInfo& info(Aov aov);

std::string_view nameOf(ExrType type);  // "half", "float" or "uint"
// Returns one line that states what the numbers of a PNG file mean.
std::string_view describe(PngCoding coding);

// Returns the name of an output's channel in an OpenEXR file.
using ChannelNames = std::string (*)(const AovInfo& aov, uint32_t channel);
std::string ownNames(const AovInfo& aov, uint32_t channel);  // exrChannels

bool contains(std::span<const Aov> aovs, Aov aov);

// Returns true if the values are integers: AovImage::ids.
bool holdsIntegers(Aov aov);

// Returns true for id, part and material, whose values the id manifest lists.
bool holdsIds(Aov aov);

// Returns true for motion and scene-flow, which depend on the neighboring frames.
bool dependsOnNeighbors(Aov aov);

// Returns true for raster-...: outputs that describe the work of the raster `compute`, not the scene.
bool tellsOfRaster(Aov aov);

// Returns null if no AOV has that name.
const AovInfo* findAov(std::string_view name);

// Parses "depth,normal,id" and returns the AOVs in that order, without repeats. Throws Error(Usage) that lists the
// names.
std::vector<Aov> parseAovs(std::string_view list);

// One AOV of one view. Rows start at the top; channels are interleaved.
struct AovImage {
  Aov aov = Aov::Color;
  uint32_t width = 0, height = 0;
  std::vector<float> values;  // width * height * channels; empty if holdsIntegers()
  std::vector<uint32_t> ids;  // width * height if holdsIntegers(), else empty
};

// Returns an image whose values are all background.
AovImage makeAovImage(Aov aov, uint32_t width, uint32_t height);

// An image for viewing: RGBA, 8 bits per channel, sRGB, straight alpha, rows from the top.
struct Picture {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba;
};

}  // namespace latelight::output
