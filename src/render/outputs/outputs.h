// Outputs on their way out: packed on the device into arrays as programs and files have them, in the units and axes of
// docs/conventions.md, and copied from there to pictures. Where each comes from stands in output/outputs.def.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "graph/graph.h"
#include "output/files.h"
#include "render/outputs/exported.h"
#include "render/outputs/surface_outputs.h"
#include "render/pass.h"
#include "render/readback.h"
#include "render/settings.h"

namespace latelight::render {

// What has to be rendered for an output.
enum class Origin {
  Picture,       // the lit picture
  LightCounts,   // a frame that counts lights
  SampleCounts,  // the picture's own frame, whether it is lit or not
  Surface,       // a G-buffer in the layout `exact`, at pixel centres
  Motion,
  Raster,  // what the raster compute did, whichever raster the rest has
};
Origin originOf(output::Aov aov);
bool asksFor(const Settings& settings, Origin origin);
bool showsPicture(const Settings& settings);  // to look at, or as an output
// The slots of materials whose textures matter to what is asked for: scene::LoadOptions::textureSlots.
uint32_t textureSlots(const Settings& settings);
uint64_t bytesAPixel(const Settings& settings);  // of what leaves

// The targets of the layout `exact` that these outputs lie in, a bit each.
uint32_t exactTargets(std::span<const output::Aov> aovs);

// Where the results of a submission are, until they are asked for.
enum class Results {
  ToHost,    // on their way to the host from the moment they are there
  OnDevice,  // in device memory
  Exported,  // the same, in arrays of all pictures that other APIs may have
};

// Arrays that results go to, and which part of theirs these are.
struct ResultArrays {
  std::span<const ExportedArray> arrays;
  size_t firstView = 0;
  uint32_t firstRow = 0;
};

class PackedOutputs {
 public:
  // `yUp`: positions and directions of the world leave in glTF's frame. `lens`: FrameSetup::lens. `arrays`: of
  // Results::Exported, else none.
  PackedOutputs(const Settings& settings, bool yUp, bool lens, const ResultArrays& arrays)
      : settings_(settings), yUp_(yUp), lens_(lens), arrays_(arrays) {}

  // Adds the passes that pack those of an origin that are asked for. `image`: of a target, by its name in outputs.def.
  // `frame`: FrameConstants of the same views, for Surface. `scale`: of values.
  void add(const Builder& b, Origin origin, const std::function<graph::ImageId(std::string_view)>& image,
           VkDeviceAddress frame = 0, float scale = 1);

  // The same of Surface, by a pass that resolves surfaces (Visibility::addGbuffer).
  SurfaceOutputs addSurfaces(const Builder& b, glm::uvec3 size);

  // Where a pass is to write the picture to look at, RGBA8, of so many texels and views.
  ResultPlace addDisplay(const Builder& b, glm::uvec3 size) { return place(b, std::nullopt, 4, size); }
  // After all that are asked for have been added.
  void leave(const Builder& b, Results results);

  // After the graph has run: fills these outputs of as many pictures as there are views.
  void read(vk::Device& device, graph::Executor& executor, const graph::Submission& done,
            std::vector<output::FrameOutput>& pictures) const;

 private:
  struct Result {
    std::optional<output::Aov> aov;  // none: the picture to look at
    graph::BufferId buffer;
  };
  ResultPlace place(const Builder& b, std::optional<output::Aov> aov, uint32_t texelBytes, glm::uvec3 size);
  uint32_t axesOf(uint32_t packing) const;
  std::vector<graph::BufferId> buffers() const;
  void unpack(const graph::Submission& done, std::span<const graph::BufferId> buffers,
              std::vector<output::FrameOutput>& pictures) const;
  const Settings& settings_;
  bool yUp_, lens_;
  ResultArrays arrays_;
  std::vector<Result> results_;
  bool onHost_ = true;
};

// How often the pixels of pictures were shaded.
struct ShadingCounts {
  uint64_t pixels = 0;    // of the pictures
  uint64_t drawn = 0;     // of them, those that show anything
  uint64_t several = 0;   // and those that show several surfaces, so that they are shaded more than once
  uint64_t shadings = 0;  // of all pixels
};

// Of surfaces of the pixels of each view (kSurfacesFormat), added to `counts`.
void countShadings(ShadingCounts& counts, const vk::Buffer& surfaces, size_t pixels, size_t views, uint32_t samples);

}  // namespace latelight::render
