// The image files of a mesh file, and the textures that are made from them.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/mesh_files/source.h"

namespace latelight::scene::mesh_files {

// An image file, and how MTL's options change its values: base + gain * value, and the channel that a scalar is read
// from ('r', 'g', 'b', 'm' for alpha, 'l' for luminance).
struct ImageUse {
  static constexpr char kOpacity = 'd';  // alpha, or luminance if alpha is 255 everywhere

  std::string file;  // empty: no image
  char channel = 'l';
  float base = 0, gain = 1;
  auto operator<=>(const ImageUse&) const = default;
};

// A texture that is made from up to two images.
struct ImageRequest {
  enum class Make {
    Plain,               // `first` unchanged; sRGB if `srgb`
    ColorWithAlpha,      // the color of `first` (white if absent), the scalar of `second` as alpha
    RoughnessMetallic,   // green: the scalar of `first`, blue: that of `second`; 1 if absent
    ScalarInRed,         // the scalar of `first`, in red and green, as glTF's factors of coats read it
    ScalarInAlpha,       // the scalar of `first` in alpha
    NormalsFromHeights,  // tangent-space normals of the height map `first`; ScaledNormals if it holds normals
    ScaledNormals,       // the normal map `first`, with x and y multiplied by `bump`
  };
  Make make = Make::Plain;
  ImageUse first, second;
  bool srgb = false;
  float bump = 1;  // -bm: the strength of a height map or normal map
  auto operator<=>(const ImageRequest&) const = default;
};

class Images {
 public:
  explicit Images(Source& source) : source_(source) {}
  // Returns the name of the image `file` relative to the scene's folder. The name starts from `folder`, which is
  // relative to the scene's folder too, or from the scene's folder if there is no such file.
  std::string locate(const std::string& file, const std::string& folder) const;
  // Returns true if the file exists; otherwise prints a warning. Throws Error(BadInput) if the scene may not read it.
  bool isReadable(const std::string& file);
  // Returns the index of the texture in the scene, which decode() fills.
  int request(const ImageRequest& request);
  // Decodes all textures on all threads.
  void decode();

 private:
  const std::vector<std::byte>& encoded(const std::string& file) const { return *files_.at(file); }
  Texture make(const ImageRequest& request) const;
  Texture pack(ImageRequest request) const;
  size_t bytesOf(const ImageRequest& request) const;

  Source& source_;
  std::map<std::string, std::optional<std::vector<std::byte>>> files_;
  std::map<ImageRequest, int> known_;
  std::vector<ImageRequest> requests_;
};

}  // namespace latelight::scene::mesh_files
