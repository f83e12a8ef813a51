#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>

#include <algorithm>
#include <bit>
#include <mutex>
#include <stdexcept>

#include "base/error.h"
#include "output/decode.h"
#include "output/exr.h"
#include "scene/exr_stream.h"

namespace latelight::output {
namespace {

// The pixels of one channel with 32 bits each: unsigned integers, or floats (which represent any half exactly).
using Plane = std::vector<uint32_t>;

// Reads all channels at once, because each pass over the file decompresses all of it.
std::vector<Plane> readPlanes(Imf::InputFile& file, const ReadImage& image) {
  const Imath::Box2i window = file.header().dataWindow();
  std::vector<Plane> planes(image.channels.size(), Plane(size_t{image.width} * image.height));
  Imf::FrameBuffer buffer;
  for (size_t c = 0; c < planes.size(); ++c) {
    const Channel& channel = image.channels[c];
    const Imf::PixelType type = channel.type == ChannelType::Integer ? Imf::UINT : Imf::FLOAT;
    buffer.insert(channel.name, Imf::Slice::Make(type, planes[c].data(), window));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return planes;
}

ChannelType channelType(Imf::PixelType type) {
  switch (type) {
    case Imf::HALF:
      return ChannelType::Half;
    case Imf::UINT:
      return ChannelType::Integer;
    default:
      return ChannelType::Float;
  }
}

ReadImage readAll(Imf::InputFile& file, const std::filesystem::path& path) {
  const Imath::Box2i window = file.header().dataWindow();
  std::vector<std::string> names;
  for (auto it = file.header().channels().begin(); it != file.header().channels().end(); ++it) {
    names.emplace_back(it.name());
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
      throw std::runtime_error(fmt::format("its channel \"{}\" is subsampled", it.name()));
    }
  }
  if (names.empty()) throw std::runtime_error("it has no channels");
  ReadImage image =
      makeReadImage(static_cast<uint64_t>(int64_t{window.max.x} - window.min.x + 1),
                    static_cast<uint64_t>(int64_t{window.max.y} - window.min.y + 1), names, ChannelType::Float, path);
  for (Channel& channel : image.channels)
    channel.type = channelType(file.header().channels().findChannel(channel.name)->type);
  const std::vector<Plane> planes = readPlanes(file, image);
  for (size_t c = 0; c < planes.size(); ++c) {
    Channel& channel = image.channels[c];
    const bool integers = channel.type == ChannelType::Integer;
    std::transform(planes[c].begin(), planes[c].end(), channel.values.begin(), [&](uint32_t bits) {
      return integers ? static_cast<double>(bits) : static_cast<double>(std::bit_cast<float>(bits));
    });
  }
  return image;
}

}  // namespace

ReadImage decodeExr(std::span<const std::byte> bytes, const std::filesystem::path& path) {
  // A broken header can request a table of 2^31 lines before any pixel is read.
  constexpr int kMax = 1 << 20;
  static std::once_flag limits;
  std::call_once(limits, [] { Imf::Header::setMaxImageSize(kMax, kMax); });
  try {
    scene::ExrStream stream(bytes, path.string());
    Imf::InputFile file(stream);
    return readAll(file, path);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    badInput("can't read '{}' as OpenEXR: {}; create or download it again", path.string(), error.what());
  }
}

}  // namespace latelight::output
