#include "output/deflate.h"

#include <isa-l/crc.h>
#include <isa-l/igzip_lib.h>

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <memory>

namespace latelight::output {

namespace {

// The output of ISA-L 2.30 depends on the address of its stream. When it begins (igzip_icf_body.asm, write_first_byte),
// it enters the third position of the data into the slot of its hash table that belongs to `address >> 16`, not to the
// four bytes there. The entry is harmless unless the first, second or third position hashes to the same slot, where it
// hides or adds a match: about one file in a thousand would have other bytes in another process. Addresses 64 KiB apart
// have different slots, and the stream takes the first that is harmless.
constexpr size_t kAddressStep = size_t{1} << 16;
constexpr size_t kAddresses = 8;

constexpr size_t kStreamBytes = (kAddresses - 1) * kAddressStep + sizeof(isal_zstream);
constexpr size_t kWorkspaceAlignment = alignof(std::max_align_t);
static_assert(kStreamBytes % kWorkspaceAlignment == 0 && alignof(isal_zstream) <= kWorkspaceAlignment);
static_assert(kStreamBytes + ISAL_DEF_LVL1_DEFAULT <= kDeflateWorkspace);

// The hash of ISA-L is the CRC-32C of four bytes. Its table shrinks with the data.
uint32_t hashSlot(uint32_t word, size_t bytes) {
  constexpr uint32_t kLargestMask = 0x1fff;
  const uint32_t mask = 2 * bytes < kLargestMask ? (1u << std::bit_width(bytes)) - 1 : kLargestMask;
  unsigned char buffer[4];
  std::memcpy(buffer, &word, 4);
  return crc32_iscsi(buffer, 4, 0) & mask;
}

bool isHarmless(const void* address, std::span<const std::byte> bytes) {
  const uint32_t wrong = hashSlot(static_cast<uint32_t>(reinterpret_cast<uintptr_t>(address) >> 16), bytes.size());
  for (size_t i = 0; i < 3 && i + 4 <= bytes.size(); ++i) {
    uint32_t word;
    std::memcpy(&word, bytes.data() + i, 4);
    if (hashSlot(word, bytes.size()) == wrong) return false;
  }
  return true;
}

isal_zstream* placeStream(std::byte* memory, std::span<const std::byte> bytes) {
  for (size_t i = 0; i + 1 < kAddresses && !isHarmless(memory, bytes); ++i) memory += kAddressStep;
  return reinterpret_cast<isal_zstream*>(memory);
}

// Incompressible bytes are stored, in blocks of at most 65,535 bytes with a header of 5 bytes. The rest is for the
// header and the checksum of zlib, and for the end of a part.
size_t bound(size_t bytes) {
  return bytes + 5 * (bytes / 65535 + 1) + 64;
}

}  // namespace

std::vector<std::byte> deflate(std::span<const std::byte> bytes, DeflateForm form) {
  const auto workspace = std::make_unique_for_overwrite<std::byte[]>(kDeflateWorkspace);
  return deflate(bytes, form, std::span<std::byte, kDeflateWorkspace>(workspace.get(), kDeflateWorkspace));
}

std::vector<std::byte> deflate(std::span<const std::byte> bytes, DeflateForm form,
                               std::span<std::byte, kDeflateWorkspace> workspace) {
  assert(reinterpret_cast<uintptr_t>(workspace.data()) % kWorkspaceAlignment == 0);
  isal_zstream& stream = *placeStream(workspace.data(), bytes);
  isal_deflate_init(&stream);
  stream.level = 1;
  stream.level_buf = reinterpret_cast<uint8_t*>(workspace.data() + kStreamBytes);
  stream.level_buf_size = ISAL_DEF_LVL1_DEFAULT;
  stream.gzip_flag = form == DeflateForm::Zlib ? IGZIP_ZLIB : IGZIP_DEFLATE;
  stream.flush = form == DeflateForm::Part ? FULL_FLUSH : NO_FLUSH;
  stream.end_of_stream = form == DeflateForm::Part ? 0 : 1;
  const size_t capacity = bound(bytes.size());
  const auto deflated = std::make_unique_for_overwrite<std::byte[]>(capacity);
  stream.next_in = reinterpret_cast<uint8_t*>(const_cast<std::byte*>(bytes.data()));
  stream.avail_in = static_cast<uint32_t>(bytes.size());
  stream.next_out = reinterpret_cast<uint8_t*>(deflated.get());
  stream.avail_out = static_cast<uint32_t>(capacity);
  [[maybe_unused]] const int result = isal_deflate_stateless(&stream);
  assert(result == COMP_OK && stream.avail_in == 0);
  return {deflated.get(), deflated.get() + stream.total_out};
}

}  // namespace latelight::output
