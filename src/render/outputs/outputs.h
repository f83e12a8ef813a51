// Packs outputs on the device into arrays, in the units and axes of docs/conventions.md, and reads them back into
// pictures. output/outputs.def states the source of each output.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "graph/graph.h"
#include "output/files.h"
#include "render/base/pass.h"
#include "render/base/readback.h"
#include "render/outputs/exported.h"
#include "render/outputs/surface_outputs.h"
#include "render/settings/settings.h"

namespace latelight::render {

// The part of a request that an output is packed from.
enum class Origin {
  Picture,       // the lit picture
  LightCounts,   // a frame that counts lights
  SampleCounts,  // the picture's own frame, lit or unlit
  Surface,       // the values of the layout `exact`, at pixel centers
  Motion,
  Coordinates,  // coordinates on the visible surface (surface_coordinates/surface_coordinates.h)
  Sensor,       // the host computes it from the picture (render/sensor)
  Raster,       // statistics of the raster compute, whichever raster renders the rest
};
Origin originOf(output::Aov aov);
bool requestsOutput(const Settings& settings, Origin origin);
bool requestsSurfaces(const Settings& settings);  // outputs of the visible surfaces: Surface, Motion or Coordinates
bool showsPicture(const Settings& settings);      // for display or as an output
// The texture slots of materials that the requested outputs depend on: scene::LoadOptions::textureSlots.
uint32_t textureSlots(const Settings& settings);
uint64_t bytesPerPixel(const Settings& settings);  // of all requested outputs

// The location of a submission's results until they are read.
enum class Results {
  ToHost,    // copied to the host as soon as they are complete
  OnDevice,  // in device memory
  Exported,  // in device memory, in arrays of all pictures that other APIs may import
};

// The arrays that results are written to, and the position of these results in them.
struct ResultArrays {
  std::span<const ExportedArray> arrays;
  size_t firstView = 0;
  uint32_t firstRow = 0;
  bool rowsAreViews = false;  // each view is the next row of the arrays, from the row `firstView` of all pictures on
};

class PackedOutputs {
 public:
  // `yUp`: world positions and directions are output in glTF's axes. `lens`: FrameConfig::lens. `arrays`: for
  // Results::Exported, otherwise empty.
  PackedOutputs(const Settings& settings, bool yUp, bool lens, const ResultArrays& arrays)
      : settings_(settings), yUp_(yUp), lens_(lens), arrays_(arrays) {}

  // Adds the passes that pack the requested outputs of an origin other than Surface. `image` returns a target by its
  // name in outputs.def. `frame`: FrameConstants of the same views, required for Coordinates. `scale`: factor for
  // values.
  void add(const Builder& b, Origin origin, const std::function<graph::ImageId(std::string_view)>& image,
           VkDeviceAddress frame = 0, float scale = 1);

  // Returns the requested outputs of Surface, which addGbuffer() of visibility/visibility.h packs.
  SurfaceOutputs addSurfaces(const Builder& b, glm::uvec3 size);

  // Returns where a pass writes the display picture, RGBA8, with `size` texels and views.
  ResultTarget addDisplay(const Builder& b, glm::uvec3 size) { return place(b, std::nullopt, 4, size); }
  // Makes the results available as `results` states. Call it after all requested outputs have been added.
  void exportResults(const Builder& b, Results results);

  // Reads these outputs into one picture per view. Call it after the graph has run.
  void read(vk::Device& device, graph::Executor& executor, const graph::Submission& done,
            std::vector<output::FrameOutput>& pictures) const;

 private:
  struct Result {
    std::optional<output::Aov> aov;  // none: the display picture
    graph::BufferId buffer;
  };
  ResultTarget place(const Builder& b, std::optional<output::Aov> aov, uint32_t texelBytes, glm::uvec3 size);
  uint32_t axesOf(uint32_t packing) const;
  std::vector<graph::BufferId> buffers() const;
  void unpack(const graph::Submission& done, std::span<const graph::BufferId> buffers,
              std::vector<output::FrameOutput>& pictures) const;
  const Settings& settings_;
  bool yUp_, lens_;
  ResultArrays arrays_;
  std::vector<Result> results_;
  // Outputs that are packed to memory of their own, and then converted to the format of their arrays.
  struct Conversion {
    const ExportedArray* array;
    ResultTarget packed;
    glm::uvec3 size;
  };
  void addConversion(const Builder& b, const Conversion& conversion);
  // The bytes between two views in an array.
  uint64_t viewBytesOf(const ExportedArray& array) const {
    return arrays_.rowsAreViews ? array.rowBytes() : array.viewBytes();
  }
  std::vector<Conversion> conversions_;
  bool onHost_ = true;
};

// Counts of how often the pixels of pictures were shaded.
struct ShadingCounts {
  uint64_t pixels = 0;    // of all pictures
  uint64_t drawn = 0;     // pixels with at least one surface
  uint64_t several = 0;   // pixels with several surfaces, which are shaded more than once
  uint64_t shadings = 0;  // of all pixels
};

// Adds the counts of `surfaces`, which holds the surfaces of the pixels of each view (kSurfacesFormat), to `counts`.
void countShadings(ShadingCounts& counts, const vk::Buffer& surfaces, size_t pixels, size_t views, uint32_t samples);

}  // namespace latelight::render
