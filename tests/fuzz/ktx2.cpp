// KTX2 textures: ETC1S, UASTC and Zstandard. Every input begins with the identifier of the format.
#include <string>

#include "fuzz/texture.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  constexpr std::string_view kIdentifier = "\xabKTX 20\xbb\r\n\x1a\n";
  std::string file(fuzz::textOf(data, size));
  if (file.size() < kIdentifier.size()) return 0;
  file.replace(0, kIdentifier.size(), kIdentifier);
  fuzz::decodeSmallTexture(std::as_bytes(std::span(file)));
  return 0;
}
