// Images that `latelight compare` reads back: PNG, OpenEXR and NPY.
#include "fuzz/fuzz.h"
#include "output/read.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  const std::filesystem::path path = fuzz::writeInput("image", fuzz::bytesOf(data, size));
  fuzz::expectErrors({ExitCode::BadInput}, [&] {
    const output::ReadImage image = output::readImage(path);
    for (const output::Channel& channel : image.channels)
      if (channel.values.size() != size_t{image.width} * image.height) fuzz::report("a channel of another size");
  });
  return 0;
}
