// What the parts of a KTX 2.0 texture's decoder share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

namespace latelight::scene {

// What is wrong with a texture's bytes. Whoever knows the texture's name makes the message of it.
struct BrokenTexture : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A stream of bits, each byte's least significant one first.
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
