#include "data/format.h"

#include "data/formats/formats.h"

namespace latelight::data {

std::span<const FormatInfo> formats() {
  static constexpr FormatInfo kFormats[] = {
      {"exr", "all outputs of a frame in one OpenEXR file, channels named by Latelight or as Blender does", makeExr},
      {"npz", "all outputs of a frame in one NPZ file, as numpy.load reads it", makeNpz},
      {"depth-png", "depth as PNG of 16 bits: millimetres, KITTI's 256 a metre, or any scale", makeDepthPng},
      {"flow", "optical flow to the next or the previous frame: .flo, or KITTI's PNG", makeFlow},
      {"coco", "COCO's instances: boxes, masks and categories of visible objects", makeCoco},
  };
  return kFormats;
}

}  // namespace latelight::data
