// Decoder of ETC1S, a subset of ETC1 that BasisLZ compresses with codebooks (KTX 2.0, "BasisLZ/ETC1S Bitstream
// Specification"; blocks: Khronos Data Format 1.3, 21.1).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/textures/huffman.h"
#include "scene/textures/texture.h"

namespace latelight::scene {

// The codebooks that all slices of a texture share. Its functions throw BrokenTexture.
class Etc1sCodebooks {
 public:
  struct Source {
    uint32_t endpointCount, selectorCount;
    std::span<const std::byte> endpoints, selectors, tables;
  };
  explicit Etc1sCodebooks(const Source& source);

  // Decodes a slice of an image's colors, with alpha 1, or a slice of its alpha, which preserves the colors.
  enum class Channels { Color, Alpha };
  void decode(std::span<const std::byte> slice, ImageSize size, Channels channels, std::byte* rgba) const;

 private:
  friend class Etc1sBlocks;
  struct Endpoint {
    std::array<uint8_t, 3> color5;
    uint8_t intensity;
  };
  using Selectors = std::array<uint8_t, 4>;  // per row, two bits per texel

  void readEndpoints(const Source& source);
  void readSelectors(const Source& source);
  void write(const Endpoint& endpoint, const Selectors& selectors, ImageSize block, Channels channels, size_t pitch,
             std::byte* rgba) const;

  std::vector<Endpoint> endpoints_;
  std::vector<Selectors> selectors_;
  HuffmanTable endpointPrediction_, endpointDelta_, selectorSymbol_, selectorRun_;
  uint32_t historySize_ = 0;
};

}  // namespace latelight::scene
