// Decodes ETC1S slices compressed by BasisLZ: Huffman-coded endpoint and selector indices per 4x4 block, which are
// expanded to RGBA through the codebooks.
#include "scene/textures/etc1s.h"

#include <algorithm>

namespace latelight::scene {

// Decodes the codebook indices of a slice's blocks in row order.
class Etc1sBlocks {
 public:
  Etc1sBlocks(const Etc1sCodebooks& books, std::span<const std::byte> slice, uint32_t blocksAcross)
      : books_(books),
        reader_(slice),
        above_(blocksAcross),
        predictions_((blocksAcross + 1) / 2),
        history_(books.historySize_),
        rover_(books.historySize_ / 2) {}

  struct Indices {
    uint32_t endpoint, selectors;
  };
  Indices next(uint32_t x, uint32_t y) {
    const uint32_t endpoint = nextEndpoint(x, y);
    return {endpoint, nextSelectors()};
  }

 private:
  // Returns the two prediction bits of a block. One symbol holds those of a square of four blocks; the bits of its
  // lower two blocks are stored until their row is decoded.
  uint32_t prediction(uint32_t x, uint32_t y) {
    uint8_t& square = predictions_[x / 2];
    if (x % 2 == 0 && y % 2 == 0) square = uint8_t(nextPredictions());
    const uint32_t place = y % 2 * 2 + x % 2;
    return square >> (2 * place) & 3;
  }

  uint32_t nextPredictions() {
    constexpr uint32_t kRepeat = 256, kMinRepeats = 3;
    if (predictionRepeats_ > 0) {
      --predictionRepeats_;
      return lastPredictions_;
    }
    const uint32_t symbol = books_.endpointPrediction_.decode(reader_);
    if (symbol > kRepeat) throw BrokenTexture("it has an endpoint prediction that does not exist");
    if (symbol == kRepeat)
      predictionRepeats_ = variableLength(4) + kMinRepeats - 1;
    else
      lastPredictions_ = symbol;
    return lastPredictions_;
  }

  uint32_t nextEndpoint(uint32_t x, uint32_t y) {
    const uint32_t aboveLeft = aboveLeft_;
    aboveLeft_ = above_[x];
    switch (prediction(x, y)) {
      case 0:
        if (x == 0) throw BrokenTexture("a block repeats one left of the picture");
        break;
      case 1:
        if (y == 0) throw BrokenTexture("a block repeats one above the picture");
        endpoint_ = above_[x];
        break;
      case 2:
        if (x == 0 || y == 0) throw BrokenTexture("a block repeats one outside of the picture");
        endpoint_ = aboveLeft;
        break;
      default:
        endpoint_ += books_.endpointDelta_.decode(reader_);
        if (endpoint_ >= books_.endpoints_.size()) endpoint_ -= uint32_t(books_.endpoints_.size());
    }
    if (endpoint_ >= books_.endpoints_.size()) throw BrokenTexture("a block has an endpoint that does not exist");
    return above_[x] = endpoint_;
  }

  // Symbols are the codebook's entries, followed by those of the history and a run of the history's first entry.
  uint32_t nextSelectors() {
    const auto entries = uint32_t(books_.selectors_.size());
    uint32_t symbol = entries;
    if (selectorRepeats_ > 0) {
      --selectorRepeats_;
    } else {
      symbol = books_.selectorSymbol_.decode(reader_);
      if (symbol == entries + historySize()) {
        selectorRepeats_ = selectorRun() - 1;
        symbol = entries;
      }
    }
    if (symbol < entries) return remember(symbol);
    const uint32_t place = symbol - entries;
    if (place >= historySize()) throw BrokenTexture("a block has selectors that do not exist");
    const uint32_t selectors = history_[place];
    if (place > 0) std::swap(history_[place / 2], history_[place]);
    return selectors;
  }

  uint32_t selectorRun() {
    constexpr uint32_t kLong = 63, kFewest = 3;
    const uint32_t symbol = books_.selectorRun_.decode(reader_);
    return kFewest + (symbol == kLong ? variableLength(7) : symbol);
  }

  // New entries are inserted in the second half and move up when they are used: an approximate move-to-front list.
  uint32_t remember(uint32_t selectors) {
    if (history_.empty()) return selectors;
    history_[rover_++] = selectors;
    if (rover_ == historySize()) rover_ = historySize() / 2;
    return selectors;
  }

  uint32_t variableLength(uint32_t bits) {
    uint32_t value = 0;
    for (uint32_t shift = 0; shift < 28; shift += bits) {
      value |= reader_.bits(bits) << shift;
      if (reader_.bit() == 0) return value;
    }
    throw BrokenTexture("a run is longer than the picture");
  }

  uint32_t historySize() const { return uint32_t(history_.size()); }

  const Etc1sCodebooks& books_;
  BitReader reader_;
  std::vector<uint32_t> above_;       // endpoints of the row above, and of this row up to the current block
  std::vector<uint8_t> predictions_;  // per square of four blocks
  std::vector<uint32_t> history_;     // recently used selectors
  uint32_t rover_;
  uint32_t endpoint_ = 0, aboveLeft_ = 0;
  uint32_t lastPredictions_ = 0, predictionRepeats_ = 0, selectorRepeats_ = 0;
};

Etc1sCodebooks::Etc1sCodebooks(const Source& source) {
  if (source.endpointCount == 0 || source.selectorCount == 0) throw BrokenTexture("a codebook is empty");
  readEndpoints(source);
  readSelectors(source);
  BitReader reader(source.tables);
  endpointPrediction_ = readHuffmanTable(reader);
  endpointDelta_ = readHuffmanTable(reader);
  selectorSymbol_ = readHuffmanTable(reader);
  selectorRun_ = readHuffmanTable(reader);
  historySize_ = reader.bits(13);
}

void Etc1sCodebooks::readEndpoints(const Source& source) {
  BitReader reader(source.endpoints);
  std::array<HuffmanTable, 3> colorDelta;  // for a previous value up to 9, up to 21, and above
  for (HuffmanTable& table : colorDelta) table = readHuffmanTable(reader);
  const HuffmanTable intensityDelta = readHuffmanTable(reader);
  const size_t channels = reader.bit() ? 1 : 3;
  Endpoint endpoint{{16, 16, 16}, 0};
  for (uint32_t i = 0; i < source.endpointCount; ++i) {
    endpoint.intensity = (endpoint.intensity + intensityDelta.decode(reader)) & 7;
    for (size_t c = 0; c < channels; ++c) {
      uint8_t& value = endpoint.color5[c];
      value = (value + colorDelta[value <= 9 ? 0 : value <= 21 ? 1 : 2].decode(reader)) & 31;
    }
    if (channels == 1) endpoint.color5.fill(endpoint.color5[0]);
    endpoints_.push_back(endpoint);
  }
}

void Etc1sCodebooks::readSelectors(const Source& source) {
  BitReader reader(source.selectors);
  if (reader.bits(2) != 0) throw BrokenTexture("its selectors are coded in an unknown way");
  const bool plain = reader.bit();
  const HuffmanTable delta = plain ? HuffmanTable() : readHuffmanTable(reader);
  Selectors selectors{};
  for (uint32_t i = 0; i < source.selectorCount; ++i) {
    for (uint8_t& row : selectors)
      row = plain || i == 0 ? uint8_t(reader.bits(8)) : uint8_t(row ^ delta.decode(reader));
    selectors_.push_back(selectors);
  }
}

void Etc1sCodebooks::decode(std::span<const std::byte> slice, ImageSize size, Channels channels,
                            std::byte* rgba) const {
  Etc1sBlocks blocks(*this, slice, (size.width + 3) / 4);
  const size_t pitch = size_t{4} * size.width;
  for (uint32_t y = 0; y < size.height; y += 4) {
    for (uint32_t x = 0; x < size.width; x += 4) {
      const auto [endpoint, selectors] = blocks.next(x / 4, y / 4);
      const ImageSize block{std::min(4u, size.width - x), std::min(4u, size.height - y)};
      write(endpoints_[endpoint], selectors_[selectors], block, channels, pitch, rgba + y * pitch + size_t{4} * x);
    }
  }
}

void Etc1sCodebooks::write(const Endpoint& endpoint, const Selectors& selectors, ImageSize block, Channels channels,
                           size_t pitch, std::byte* rgba) const {
  // The modifier table of ETC1, in the order of ETC1S's selectors.
  constexpr int kModifiers[8][4] = {{-8, -2, 2, 8},     {-17, -5, 5, 17},   {-29, -9, 9, 29},     {-42, -13, 13, 42},
                                    {-60, -18, 18, 60}, {-80, -24, 24, 80}, {-106, -33, 33, 106}, {-183, -47, 47, 183}};
  std::byte colors[4][4];
  for (size_t selector = 0; selector < 4; ++selector) {
    for (size_t c = 0; c < 3; ++c) {
      const int base = endpoint.color5[c] << 3 | endpoint.color5[c] >> 2;
      colors[selector][c] = std::byte(std::clamp(base + kModifiers[endpoint.intensity][selector], 0, 255));
    }
    colors[selector][3] = std::byte{255};
  }
  for (uint32_t y = 0; y < block.height; ++y) {
    for (uint32_t x = 0; x < block.width; ++x) {
      const std::byte* color = colors[selectors[y] >> (2 * x) & 3];
      std::byte* texel = rgba + y * pitch + size_t{4} * x;
      if (channels == Channels::Color)
        std::copy_n(color, 4, texel);
      else
        texel[3] = color[1];  // alpha is stored as gray: use green
    }
  }
}

}  // namespace latelight::scene
