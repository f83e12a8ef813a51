// Compression to deflate (RFC 1951), by ISA-L's fastest dynamic level.
//
// Writing data sets is bound by compression. For 640x480 images of a model (1.2 MB raw), ISA-L requires a quarter of
// the time of libdeflate's level 1 and a sixtieth for images of ids, and its files are 4 % larger. Its output is the
// same on all x86 processors with SSE4.2, which the level 3 of ISA-L is not.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace latelight::output {

enum class DeflateForm {
  Zlib,      // a whole zlib stream (RFC 1950)
  Part,      // raw deflate that ends on a byte boundary, after which another part follows, as in pigz
  LastPart,  // raw deflate that ends the stream
};

// Memory that the compressor uses, aligned as by malloc. It need not be initialized.
constexpr size_t kDeflateWorkspace = size_t{1} << 20;

// The result depends on `bytes` and `form` alone, not on the workspace or its address.
std::vector<std::byte> deflate(std::span<const std::byte> bytes, DeflateForm form);
std::vector<std::byte> deflate(std::span<const std::byte> bytes, DeflateForm form,
                               std::span<std::byte, kDeflateWorkspace> workspace);

}  // namespace latelight::output
