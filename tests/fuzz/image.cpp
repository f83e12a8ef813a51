// Images of textures: JPEG, PNG, WebP, AVIF, BMP, TGA and GIF, recognized by their first bytes.
#include "fuzz/texture.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  fuzz::decodeSmallTexture(fuzz::bytesOf(data, size));
  return 0;
}
