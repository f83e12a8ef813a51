#include "output/deflate.h"

#include <isa-l/igzip_lib.h>

#include <cassert>
#include <memory>

namespace latelight::output {

namespace {

struct Compressor {
  isal_zstream stream;
  uint8_t buffer[ISAL_DEF_LVL1_DEFAULT];
};

// Incompressible bytes are stored, in blocks of at most 65,535 bytes with a header of 5 bytes. The rest is for the
// header and the checksum of zlib, and for the end of a part.
size_t bound(size_t bytes) {
  return bytes + 5 * (bytes / 65535 + 1) + 64;
}

}  // namespace

std::vector<std::byte> deflate(std::span<const std::byte> bytes, DeflateForm form) {
  // Cleared, because matches, and so the bytes, can depend on what the buffer held.
  const auto compressor = std::make_unique<Compressor>();
  isal_zstream& stream = compressor->stream;
  isal_deflate_init(&stream);
  stream.level = 1;
  stream.level_buf = compressor->buffer;
  stream.level_buf_size = sizeof(compressor->buffer);
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
