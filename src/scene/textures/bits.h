// Code that the parts of the KTX 2.0 decoder share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

namespace latelight::scene {

// Describes a defect of a texture's bytes. Callers that know the texture's name add it to the message.
struct BrokenTexture : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A stream of bits, from the least significant bit of each byte.
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  uint32_t bit() {
    if (at_ >= 8 * bytes_.size()) throw BrokenTexture("its data ends too early");
    const uint32_t byte = std::to_integer<uint32_t>(bytes_[at_ / 8]);
    return byte >> (at_++ % 8) & 1;
  }
  uint32_t bits(uint32_t count) {
    uint32_t value = 0;
    for (uint32_t i = 0; i < count; ++i) value |= bit() << i;
    return value;
  }

 private:
  std::span<const std::byte> bytes_;
  size_t at_ = 0;
};

}  // namespace latelight::scene
