#include "output/targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <string_view>

#include "output/range.h"
#include "output/srgb.h"

namespace latelight::output {
namespace {

constexpr std::array<uint8_t, 4> kEmptyColor{28, 28, 31, 255};

// --- "rgb: diffuse color; a: power" ----------------------------------------------------------------------------------

struct Described {
  std::string_view letters, text;
};

std::vector<Described> parseChannels(std::string_view channels) {
  std::vector<Described> parts;
  while (!channels.empty()) {
    const size_t end = std::min(channels.find("; "), channels.size());
    const std::string_view part = channels.substr(0, end);
    const size_t colon = part.find(": ");
    parts.push_back(colon == part.npos ? Described{"", part}
                                       : Described{part.substr(0, colon), part.substr(colon + 2)});
    channels.remove_prefix(std::min(end + 2, channels.size()));
  }
  return parts;
}

bool isAlpha(const Described& part) {
  return part.letters == "a" || part.letters == "w";
}

// --- mapping of one channel to [0, 1] --------------------------------------------------------------------------------

struct Scale {
  std::function<float(float)> apply;
  std::string note;  // how the values were scaled, for the label
};

Scale floatScale(const std::vector<float>& values, bool color) {
  if (values.empty()) return {[](float) { return 0.0f; }, ""};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (*least >= 0 && *most <= 1.001f) {
    if (color) return {srgbFromLinear, ""};
    return {[](float x) { return x; }, ""};
  }
  if (*least >= -1.001f && *most <= 1.001f) return {[](float x) { return x * 0.5f + 0.5f; }, "x * 0.5 + 0.5"};
  const Range range = rangeOf(values);
  if (range.low >= 0 && range.high > 1000 * (range.low + 1)) {
    const Range logs{std::log2(1 + range.low), std::log2(1 + range.high)};
    return {[logs](float x) { return logs.at(std::log2(1 + x)); },
            fmt::format("{:.3g} to {:.3g}, log scale", range.low, range.high)};
  }
  return {[range](float x) { return range.at(x); }, fmt::format("{:.3g} to {:.3g}", range.low, range.high)};
}

Scale scaleOf(TargetKind kind, const std::vector<float>& values, bool alpha) {
  switch (kind) {
    case TargetKind::Light:
      return {[](float x) { return srgbFromLinear(std::clamp(x, 0.0f, 1.0f)); }, ""};
    case TargetKind::Float:
      return floatScale(values, !alpha);
    case TargetKind::Srgb:
      if (!alpha) return {srgbFromLinear, ""};
      break;
    default:
      break;
  }
  // Small codes, such as ids, would all look black, so they are stretched.
  const float most = values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  if (alpha && most > 0 && most <= 16 / 255.0f)
    return {[most](float x) { return x / most; }, fmt::format("white is {:.0f} / 255", most * 255)};
  return {[](float x) { return x; }, ""};
}

// --- images ----------------------------------------------------------------------------------------------------------

// ColorOf maps a pixel index to three bytes.
template <typename ColorOf>
Picture paint(const RawGbuffer& gbuffer, ColorOf&& colorOf) {
  Picture picture{gbuffer.width, gbuffer.height, std::vector<uint8_t>(gbuffer.depth.size() * 4)};
  for (size_t i = 0; i < gbuffer.depth.size(); ++i) {
    std::array<uint8_t, 4> color = kEmptyColor;
    if (std::isfinite(gbuffer.depth[i])) {
      const std::array<uint8_t, 3> rgb = colorOf(i);
      color = {rgb[0], rgb[1], rgb[2], 255};
    }
    std::copy(color.begin(), color.end(), &picture.rgba[4 * i]);
  }
  return picture;
}

std::vector<float> drawn(const RawGbuffer& gbuffer, const RawTarget& target, uint32_t channel) {
  std::vector<float> values;
  for (size_t i = 0; i < gbuffer.depth.size(); ++i)
    if (std::isfinite(gbuffer.depth[i])) values.push_back(target.values[4 * i + channel]);
  return values;
}

std::string labelOf(const RawTarget& target, std::string_view letters, std::string_view text, std::string note) {
  return fmt::format("{}.{} {}{}", target.name, letters, text, note.empty() ? "" : " [" + note + "]");
}

// Paints the first three channels. Each has its own scale if a float is outside [-1, 1]; otherwise they share one.
Labelled colorPicture(const RawGbuffer& gbuffer, const RawTarget& target, const std::vector<Described>& parts) {
  std::string text, note;
  for (const Described& part : parts) {
    if (isAlpha(part)) continue;
    const bool alone = part.letters.empty() || parts.front().letters.size() >= std::min(target.count, 3u);
    text += (text.empty() ? "" : ", ") + (alone ? "" : std::string(part.letters) + ": ") + std::string(part.text);
  }
  std::vector<float> all;
  std::array<std::vector<float>, 3> channels;
  const uint32_t count = std::min(target.count, 3u);
  for (uint32_t c = 0; c < count; ++c) {
    channels[c] = drawn(gbuffer, target, c);
    all.insert(all.end(), channels[c].begin(), channels[c].end());
  }
  const Scale together = scaleOf(target.kind, all, false);
  std::array<Scale, 3> scales{together, together, together};
  note = together.note;
  const auto beyond = [](float x) { return std::abs(x) > 1.001f; };
  if (target.kind == TargetKind::Float && std::any_of(all.begin(), all.end(), beyond)) {
    note = "";
    for (uint32_t c = 0; c < count; ++c) {
      const Range range = rangeOf(channels[c]);
      scales[c].apply = [range](float x) { return range.at(x); };
      note += fmt::format("{}{:.3g} to {:.3g}", c ? ", " : "", range.low, range.high);
    }
  }
  const std::string_view first = parts.front().letters;
  const std::string_view letters = first.size() == count ? first : std::string_view("rgb").substr(0, count);
  return {labelOf(target, letters, text, note), paint(gbuffer, [&](size_t i) {
            std::array<uint8_t, 3> rgb{};
            for (uint32_t c = 0; c < count; ++c) rgb[c] = unorm8(scales[c].apply(target.values[4 * i + c]));
            return rgb;
          })};
}

Labelled alphaPicture(const RawGbuffer& gbuffer, const RawTarget& target, const Described& part) {
  const Scale scale = scaleOf(target.kind, drawn(gbuffer, target, 3), true);
  return {labelOf(target, part.letters, part.text, scale.note), paint(gbuffer, [&](size_t i) {
            const uint8_t gray = unorm8(scale.apply(target.values[4 * i + 3]));
            return std::array<uint8_t, 3>{gray, gray, gray};
          })};
}

Picture idPicture(const RawGbuffer& gbuffer, const RawTarget& target, uint32_t channel) {
  AovImage ids = makeAovImage(Aov::Id, gbuffer.width, gbuffer.height);
  for (size_t i = 0; i < ids.ids.size(); ++i) ids.ids[i] = target.words[4 * i + channel];
  return debugPicture(ids);
}

void addWords(std::vector<Labelled>& pictures, const RawGbuffer& gbuffer, const RawTarget& target) {
  constexpr std::string_view kLetters = "rgba";
  for (const Described& part : parseChannels(target.channels))
    for (const char letter : part.letters) {
      const auto channel = static_cast<uint32_t>(kLetters.find(letter));
      assert(channel < target.count);
      const std::string_view name = kLetters.substr(channel, 1);
      if (part.text.starts_with("id")) {
        pictures.push_back({labelOf(target, name, part.text, ""), idPicture(gbuffer, target, channel)});
        continue;
      }
      const auto byte = [&target, channel](size_t i, uint32_t b) {
        return static_cast<uint8_t>(target.words[4 * i + channel] >> (8 * b));
      };
      pictures.push_back({labelOf(target, name, part.text, "bytes 0 to 2"), paint(gbuffer, [&](size_t i) {
                            return std::array<uint8_t, 3>{byte(i, 0), byte(i, 1), byte(i, 2)};
                          })});
      pictures.push_back({labelOf(target, name, "its highest byte", ""), paint(gbuffer, [&](size_t i) {
                            return std::array<uint8_t, 3>{byte(i, 3), byte(i, 3), byte(i, 3)};
                          })});
    }
}

}  // namespace

std::vector<Labelled> targetPictures(const RawGbuffer& gbuffer) {
  std::vector<Labelled> pictures;
  for (const RawTarget& target : gbuffer.targets) {
    if (target.kind == TargetKind::Words) {
      addWords(pictures, gbuffer, target);
      continue;
    }
    const std::vector<Described> parts = parseChannels(target.channels);
    pictures.push_back(colorPicture(gbuffer, target, parts));
    for (const Described& part : parts)
      if (isAlpha(part) && target.count == 4 && part.text != "unused")
        pictures.push_back(alphaPicture(gbuffer, target, part));
  }
  AovImage depth = makeAovImage(Aov::Depth, gbuffer.width, gbuffer.height);
  depth.values = gbuffer.depth;
  pictures.push_back({"depth", debugPicture(depth)});
  return pictures;
}

}  // namespace latelight::output
