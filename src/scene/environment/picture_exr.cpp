// Decodes OpenEXR images.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "scene/environment/picture_io.h"
#include "scene/exr_stream.h"

namespace latelight::scene {
namespace {

// The names of the image's four channels in the file. One name may be used for several channels.
using ChannelNames = std::array<std::string, 4>;

std::optional<ChannelNames> channelsOf(const Imf::ChannelList& list, const std::string& layer) {
  const auto has = [&](const char* channel) { return list.findChannel(layer + channel) != nullptr; };
  const std::string alpha = layer + "A";
  if (has("R") && has("G") && has("B")) return ChannelNames{layer + "R", layer + "G", layer + "B", alpha};
  if (has("Y") && !has("RY") && !has("BY")) return ChannelNames{layer + "Y", layer + "Y", layer + "Y", alpha};
  return std::nullopt;
}

std::optional<ChannelNames> findChannels(const Imf::ChannelList& list) {
  std::optional<ChannelNames> found = channelsOf(list, "");
  for (auto i = list.begin(); i != list.end() && !found; ++i) {
    const std::string channel = i.name();
    if (channel.ends_with(".R")) found = channelsOf(list, channel.substr(0, channel.size() - 1));
  }
  return found;
}

void checkSampling(const Imf::ChannelList& list, const ChannelNames& names, const std::string& name) {
  for (const std::string& channel : names) {
    const Imf::Channel* c = list.findChannel(channel);
    if (c && (c->xSampling != 1 || c->ySampling != 1)) {
      badInput("'{}' has the subsampled channel {}, which is not supported; save it at full size", name, channel);
    }
  }
}

// The part of a file that is read, and its channels.
struct Selection {
  int part;
  ChannelNames channels;
};

// Returns the first part that is an image with usable channels. Programs write depths, masks and other data as parts of
// their own, in any order.
Selection choosePart(const Imf::MultiPartInputFile& file, const std::string& name) {
  std::string all;
  bool anyDeep = false, anyFlat = false;
  for (int part = 0; part < file.parts(); ++part) {
    const Imf::Header& header = file.header(part);
    if (header.hasType() && !Imf::isSupportedType(header.type())) continue;
    if (header.hasType() && Imf::isDeepData(header.type())) {
      anyDeep = true;
      continue;
    }
    anyFlat = true;
    const Imf::ChannelList& list = header.channels();
    if (auto found = findChannels(list)) return {part, *std::move(found)};
    for (auto i = list.begin(); i != list.end(); ++i) {
      if (!all.empty()) all += ' ';
      all += i.name();
    }
  }
  if (anyFlat) badInput("'{}' has neither the channels R G B nor Y, but: {}; save it as RGB", name, all);
  if (anyDeep) badInput("'{}' contains deep data; flatten it first", name);
  badInput("'{}' has a part of unknown type", name);
}

struct Window {
  int64_t x, y, width, height;
  explicit Window(const Imath::Box2i& box)
      : x(box.min.x),
        y(box.min.y),
        width(int64_t{box.max.x} - box.min.x + 1),
        height(int64_t{box.max.y} - box.min.y + 1) {}
  bool operator==(const Window&) const = default;
};

void checkWindow(const Window& window, const std::string& name) {
  if (window.width < 1 || window.height < 1) badInput("'{}' is damaged: it has no pixels; download it again", name);
  checkPictureSize(window.width, window.height, name);
}

void readRows(Imf::InputPart& part, const Window& window, const ChannelNames& channels, FloatImage& rows) {
  const size_t pixelBytes = 4 * sizeof(float), rowBytes = pixelBytes * rows.width;
  const bool gray = channels[0] == channels[1];
  const Imath::V2i origin(static_cast<int>(window.x), static_cast<int>(window.y));
  Imf::FrameBuffer buffer;
  for (size_t i = 0; i < channels.size(); ++i) {
    if (gray && (i == 1 || i == 2)) continue;
    // OpenEXR adds the window's origin; Slice::Make subtracts it again. Absent channels (alpha) are filled with 1.
    buffer.insert(channels[i], Imf::Slice::Make(Imf::FLOAT, rows.pixels.data() + i, origin, rows.width, rows.height,
                                                pixelBytes, rowBytes, 1, 1, 1.0));
  }
  part.setFrameBuffer(buffer);
  part.readPixels(origin.y, origin.y + static_cast<int>(rows.height) - 1);
  if (gray) {
    for (size_t i = 0; i < rows.pixels.size(); i += 4) rows.pixels[i + 1] = rows.pixels[i + 2] = rows.pixels[i];
  }
}

FloatImage readData(Imf::InputPart& part, const Window& window, const ChannelNames& channels) {
  // Read one row first, so that an invalid width fails before the image is allocated.
  FloatImage row(static_cast<uint32_t>(window.width), 1);
  readRows(part, window, channels, row);
  FloatImage image(static_cast<uint32_t>(window.width), static_cast<uint32_t>(window.height));
  readRows(part, window, channels, image);
  return image;
}

// The data window may be a part of the display window (the rest is black) or exceed it.
FloatImage placeInDisplay(FloatImage data, const Window& from, const Window& to) {
  if (from == to) return data;
  FloatImage image(static_cast<uint32_t>(to.width), static_cast<uint32_t>(to.height));
  const int64_t left = std::max(from.x, to.x), right = std::min(from.x + from.width, to.x + to.width);
  const int64_t top = std::max(from.y, to.y), bottom = std::min(from.y + from.height, to.y + to.height);
  if (left >= right) return image;
  for (int64_t y = top; y < bottom; ++y) {
    const float* row = data.at(static_cast<size_t>(left - from.x), static_cast<size_t>(y - from.y));
    std::copy_n(row, 4 * (right - left), image.at(static_cast<size_t>(left - to.x), static_cast<size_t>(y - to.y)));
  }
  return image;
}

void checkColours(const Imf::Header& header, const std::string& name) {
  if (!Imf::hasChromaticities(header)) return;
  const Imf::Chromaticities found = Imf::chromaticities(header), rec709;
  // Files created through ICC profiles state Rec.709's primaries adapted to D50, up to 0.023 off.
  const auto far = [](Imath::V2f a, Imath::V2f b) { return std::abs(a.x - b.x) + std::abs(a.y - b.y) > 0.04f; };
  if (far(found.red, rec709.red) || far(found.green, rec709.green) || far(found.blue, rec709.blue)) {
    warn("'{}' has primaries other than Rec.709's; its colors are interpreted as Rec.709 and will be wrong", name);
  }
}

FloatImage decode(std::span<const std::byte> bytes, const std::string& name) {
  ExrStream stream(bytes, name);
  Imf::MultiPartInputFile file(stream, static_cast<int>(threadCount()));
  const Selection selection = choosePart(file, name);
  const Imf::Header& header = file.header(selection.part);
  const Window data(header.dataWindow()), display(header.displayWindow());
  checkWindow(data, name);
  checkWindow(display, name);
  if (!file.partComplete(selection.part))
    badInput("'{}' is truncated: some of its pixels are missing; download it again", name);
  checkSampling(header.channels(), selection.channels, name);
  checkColours(header, name);
  Imf::InputPart part(file, selection.part);
  return placeInDisplay(readData(part, data, selection.channels), data, display);
}

}  // namespace

FloatImage decodeExr(std::span<const std::byte> bytes, const std::string& name) {
  static const bool threads = [] {
    if (Imf::globalThreadCount() == 0 && threadCount() > 1) Imf::setGlobalThreadCount(static_cast<int>(threadCount()));
    return true;
  }();
  (void)threads;
  try {
    return decode(bytes, name);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;  // decodePicture reports it
  } catch (const std::exception& error) {
    std::string why = error.what();
    std::replace(why.begin(), why.end(), '\n', ' ');
    badInput("cannot read '{}' as OpenEXR: {}; download it again", name, why);
  }
}

}  // namespace latelight::scene
