// The format "cryptomatte" (Friedman and Jones 2015, "Fully Automatic ID Mattes with Support for Motion Blur and
// Transparency"). For each pixel it counts the samples of every object and material, and writes ranked pairs of name
// hash and coverage to an OpenEXR file, together with a manifest of the names.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "base/error.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/names.h"
#include "data/formats/options.h"
#include "data/json_text.h"
#include "output/exr.h"
#include "render/options/options.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

// MurmurHash3_x86_32 (Appleby), with the initial value 0.
uint32_t murmurHash3(std::string_view text) {
  const auto scramble = [](uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
  uint32_t hash = 0;
  size_t at = 0;
  for (; at + 4 <= text.size(); at += 4) {
    uint32_t word;
    std::memcpy(&word, text.data() + at, 4);
    hash = std::rotl(hash ^ scramble(word), 13) * 5 + 0xe6546b64u;
  }
  uint32_t rest = 0;
  for (size_t i = text.size(); i > at; --i) rest = rest << 8 | static_cast<uint8_t>(text[i - 1]);
  hash ^= scramble(rest);
  hash ^= static_cast<uint32_t>(text.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return hash ^ hash >> 16;
}

// Returns the bits of the float that identifies a name. It is never zero, subnormal, infinite or NaN.
uint32_t floatBitsOf(std::string_view name) {
  const uint32_t hash = murmurHash3(name), exponent = hash >> 23 & 255;
  return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

// The names of one Cryptomatte layer, either of objects or of materials.
struct MatteNames {
  std::string layer;
  output::Aov aov;
  std::unordered_map<uint32_t, uint32_t> bits;  // floatBitsOf() by id
  Json manifest = Json::object();

  void add(uint32_t id, const std::string& name) {
    bits[id] = floatBitsOf(name);
    manifest[name] = fmt::format("{:08x}", bits[id]);
  }
};

// The ids that are visible in the samples. Each frame's file lists only these, because a scene may have far more.
using VisibleIds = std::unordered_set<uint32_t>;

VisibleIds visibleIdsOf(const output::AovImage& samples) {
  VisibleIds ids;
  uint32_t last = 0;
  for (const uint32_t id : samples.ids)
    if (id != std::exchange(last, id)) ids.insert(id);
  return ids;
}

MatteNames objectNames(const output::IdManifest& ids, const VisibleIds& shown) {
  MatteNames names{"CryptoObject", output::Aov::Id};
  for (const output::IdEntry& entry : ids.ids)
    if (shown.contains(entry.id)) names.add(entry.id, nameOf(entry));
  return names;
}

MatteNames materialNames(const output::IdManifest& ids, const VisibleIds& shown) {
  MatteNames names{"CryptoMaterial", output::Aov::Material};
  for (const output::IdMaterial& material : ids.materials)
    if (shown.contains(material.id))
      names.add(material.id, material.name.empty() ? fmt::format("material{}", material.index) : material.name);
  return names;
}

// Returns the bits of each sample's name, or 0, which identifies no name, for samples without one.
std::vector<uint32_t> bitsOf(const MatteNames& names, const std::vector<uint32_t>& ids) {
  std::vector<uint32_t> bits(ids.size());
  for (size_t i = 0; i < ids.size(); ++i) {
    if (i > 0 && ids[i] == ids[i - 1]) {
      bits[i] = bits[i - 1];
    } else if (const auto name = names.bits.find(ids[i]); name != names.bits.end()) {
      bits[i] = name->second;
    }
  }
  return bits;
}

// The number of a pixel's samples that a name covers. Coverages are sorted by descending number, then by bits.
struct Coverage {
  uint32_t bits;
  uint32_t samples;
};
void findCoverages(const uint32_t* samples, size_t stride, uint32_t side, std::vector<Coverage>& found) {
  found.clear();
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      const uint32_t bits = samples[y * stride + x];
      if (bits == 0) continue;
      const auto same = std::ranges::find(found, bits, &Coverage::bits);
      if (same == found.end())
        found.push_back({bits, 1});
      else
        ++same->samples;
    }
  std::ranges::sort(found, [](const Coverage& a, const Coverage& b) {
    return a.samples != b.samples ? a.samples > b.samples : a.bits < b.bits;
  });
}

using Plane = std::vector<float>;

// Returns two planes per rank, one of ids and one of coverages.
std::vector<Plane> ranksOf(const MatteNames& names, const output::AovImage& samples, uint32_t width, uint32_t height,
                           uint32_t ranks) {
  const uint32_t side = samples.width / width;
  const std::vector<uint32_t> bits = bitsOf(names, samples.ids);
  std::vector<Coverage> found;
  std::vector<Plane> planes(2 * ranks, Plane(size_t{width} * height, 0));
  for (size_t pixel = 0; pixel < planes[0].size(); ++pixel) {
    findCoverages(&bits[pixel / width * side * samples.width + pixel % width * side], samples.width, side, found);
    for (size_t rank = 0; rank < std::min<size_t>(ranks, found.size()); ++rank) {
      planes[2 * rank][pixel] = std::bit_cast<float>(found[rank].bits);
      planes[2 * rank + 1][pixel] = static_cast<float>(found[rank].samples) / static_cast<float>(side * side);
    }
  }
  return planes;
}

class Cryptomatte : public Format {
 public:
  explicit Cryptomatte(const Json& json) {
    FormatOptions options("cryptomatte", json);
    file_ = options.frameFile("file", "cryptomatte/{name}.exr", ".exr");
    samples_ = static_cast<uint32_t>(options.number("samples", 4, 1, 16));
    ranks_ = 2 * static_cast<uint32_t>(options.number("levels", 3, 1, 8));
    options.finish();
  }

  std::vector<output::Aov> needs() const override { return {output::Aov::Color}; }
  Extras needsExtras() const override { return {.samples = samples_}; }
  std::vector<FormatFile> files(const DataFrame& frame) const override { return {{frameFile(file_, frame)}}; }

  // The samples are rendered as an image N times as wide and high.
  void check(const DataFrame& frame) const override {
    render::Settings fine;
    fine.width = frame.picture.width * samples_;
    fine.height = frame.picture.height * samples_;
    try {
      render::checkSettings(fine);
    } catch (const Error& error) {
      badUsage("samples of the format cryptomatte: {}", error.what());
    }
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    const output::AovImage* color = &imageOf(frame.picture, output::Aov::Color);
    output::ExrExtras extras;
    std::vector<std::vector<Plane>> planes;  // must live until the file is encoded
    const output::IdManifest& ids = *frame.metadata.ids;
    for (const MatteNames& names : {objectNames(ids, visibleIdsOf(imageOf(frame.samples, output::Aov::Id))),
                                    materialNames(ids, visibleIdsOf(imageOf(frame.samples, output::Aov::Material)))}) {
      planes.push_back(ranksOf(names, imageOf(frame.samples, names.aov), color->width, color->height, ranks_));
      for (size_t i = 0; i < planes.back().size(); ++i)
        extras.channels.push_back({fmt::format("{}{:02}.{}", names.layer, i / 4, "RGBA"[i % 4]), planes.back()[i]});
      describe(names, extras);
    }
    writeOf(record, folder, frameFile(file_, frame), output::encodeExr({&color, 1}, frame.metadata, extras));
  }

 private:
  static void describe(const MatteNames& names, output::ExrExtras& extras) {
    const std::string key = "cryptomatte/" + fmt::format("{:08x}", murmurHash3(names.layer)).substr(0, 7) + "/";
    extras.attributes.emplace_back(key + "name", names.layer);
    extras.attributes.emplace_back(key + "hash", "MurmurHash3_32");
    extras.attributes.emplace_back(key + "conversion", "uint32_to_float32");
    extras.attributes.emplace_back(key + "manifest", dumped(names.manifest));
  }

  std::string file_;
  uint32_t samples_, ranks_;
};

}  // namespace

std::unique_ptr<Format> makeCryptomatte(const Json& options) {
  return std::make_unique<Cryptomatte>(options);
}

}  // namespace latelight::data
