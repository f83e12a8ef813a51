// Parses MTL files.
#include "scene/mesh_files/mtl.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "base/log.h"
#include "base/lowercase.h"
#include "base/utf8.h"
#include "scene/mesh_files/text.h"

namespace latelight::scene::mesh_files {
namespace {

class MtlParser {
 public:
  MtlParser(std::string_view text, const std::string& name, std::map<std::string, MtlMaterial, std::less<>>& materials)
      : text_(text), name_(name), folder_(std::filesystem::path(name).parent_path().string()), materials_(materials) {}

  void run() {
    for (size_t at = 0; at < text_.size();) {
      const size_t end = std::min(text_.find('\n', at), text_.size());
      line_ = text_.substr(at, end - at);
      read();
      at = end + 1;
    }
  }

 private:
  [[noreturn]] void wrong(std::string_view problem) const {
    badInput("{}: line {} {}: \"{}\"", name_, lineAt(text_, static_cast<size_t>(line_.data() - text_.data())), problem,
             printable(line_.substr(0, 60)));
  }

  void read() {
    Words words(line_);
    const std::string_view key = words.word();
    if (key.empty() || key[0] == '#') return;
    if (equalsIgnoringCase(key, "newmtl")) {
      const std::string material = utf8OrLatin1(words.rest());
      current_ = &(materials_[material] = {.name = material, .folder = folder_});
      return;
    }
    if (!current_) return;  // a statement before the first material
    const std::string lower = lowercase(std::string(key));
    if (lower.starts_with("map_"))
      readMap(lower.substr(4), words);
    else if (lower == "bump" || lower == "norm")
      readMap(lower, words);
    else
      readValue(lower, words);
  }

  void readValue(std::string_view key, Words& words) {
    MtlMaterial& m = *current_;
    if (key == "kd") m.diffuse = color(words);
    if (key == "ks") m.specular = color(words);
    if (key == "ke") m.emissive = color(words);
    if (key == "ns") m.exponent = std::max(number(words), 0.0f);
    if (key == "d") m.alpha = readDissolve(words);
    if (key == "tr") m.alpha = 1 - unit(words);
    if (key == "illum") m.illumination = int(std::clamp(number(words), 0.0f, 10.0f));
    if (key == "pr") m.roughness = unit(words);
    if (key == "pm") m.metallic = unit(words);
    if (key == "ps") m.sheen = unit(words);
    if (key == "pc") m.clearcoat = unit(words);
    if (key == "pcr") m.clearcoatRoughness = unit(words);
    if (key == "aniso") m.anisotropy = unit(words);
    if (key == "anisor") m.anisotropyRotation = number(words);
  }

  float number(Words& words) const {
    float value = 0;
    if (!words.number(value) || !std::isfinite(value)) wrong("requires a number");
    return value;
  }
  float unit(Words& words) const { return std::clamp(number(words), 0.0f, 1.0f); }

  // "d -halo" depends on the view; the factor that follows is that of a surface seen frontally.
  float readDissolve(Words& words) const {
    Words after = words;
    if (after.word() == "-halo") words = after;
    return unit(words);
  }

  // One number is that of all channels. Spectral curves and CIE XYZ are not supported, and leave the default.
  std::optional<vec3> color(Words& words) const {
    vec3 value(0);
    if (!words.number(value.x)) {
      const std::string_view word = words.word();
      if (word != "spectral" && word != "xyz") wrong("requires three numbers");
      warn("{}: colors given as \"{}\" are not supported, and are left out", name_, word);
      return std::nullopt;
    }
    if (!words.number(value.y))
      value = vec3(value.x);
    else if (!words.number(value.z))
      wrong("requires three numbers");
    for (int i = 0; i < 3; ++i)
      if (!std::isfinite(value[i])) wrong("requires finite numbers");
    return glm::max(value, vec3(0));
  }

  // --- maps ---------------------------------------------------------------------------------------------------------

  void readMap(const std::string& key, Words& words) {
    MtlMap map;
    if (key == "d") map.image.channel = ImageUse::kOpacity;
    while (true) {
      Words after = words;
      const std::string_view option = after.word();
      if (option.size() < 2 || option[0] != '-' || !readOption(option, after, map)) break;
      words = after;
    }
    map.image.file = std::string(unquoted(words.rest()));
    std::ranges::replace(map.image.file, '\\', '/');
    if (map.image.file.empty()) wrong("names no image file");
    current_->maps[key] = std::move(map);
  }

  // Returns false if the word is not an option, but the beginning of a file's name.
  bool readOption(std::string_view option, Words& words, MtlMap& map) const {
    if (option == "-o") return readUvw(words, map.offset);
    if (option == "-s") return readUvw(words, map.scale);
    if (option == "-t") {
      std::array<double, 2> turbulence{};
      return readUvw(words, turbulence);
    }
    if (option == "-bm") return map.bump = number(words), true;
    if (option == "-mm") return map.image.base = number(words), map.image.gain = number(words), true;
    if (option == "-clamp") return map.clamp = words.word() == "on", true;
    if (option == "-imfchan") {
      const std::string_view channel = words.word();
      if (channel.size() != 1 || std::string_view("rgbmlz").find(channel[0]) == std::string_view::npos)
        wrong("requires r, g, b, m, l or z after -imfchan");
      return map.image.channel = channel[0], true;
    }
    constexpr std::array<std::string_view, 6> kIgnored = {"-blendu", "-blendv", "-cc", "-texres", "-boost", "-type"};
    if (std::ranges::find(kIgnored, option) == kIgnored.end()) return false;
    words.word();
    return true;
  }

  // One to three numbers. The third one, w, is that of solid textures.
  bool readUvw(Words& words, std::array<double, 2>& uv) const {
    uv[0] = number(words);
    float value = 0;
    if (words.number(value)) uv[1] = value;
    if (!std::isfinite(uv[1])) wrong("requires finite numbers");
    words.number(value);
    return true;
  }

  const std::string_view text_;
  const std::string& name_;
  const std::string folder_;
  std::map<std::string, MtlMaterial, std::less<>>& materials_;
  MtlMaterial* current_ = nullptr;
  std::string_view line_;
};

}  // namespace

void readMtl(std::string_view text, const std::string& name,
             std::map<std::string, MtlMaterial, std::less<>>& materials) {
  MtlParser(withoutByteOrderMark(text), name, materials).run();
}

}  // namespace latelight::scene::mesh_files
