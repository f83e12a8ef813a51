// The format "npz": all outputs of a frame in one NPZ file, a ZIP archive of NPY arrays as numpy.savez writes it.
#include <string>

#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "output/npy.h"
#include "output/zip_archive.h"

namespace latelight::data {

namespace {

class Npz : public Format {
 public:
  explicit Npz(const nlohmann::ordered_json& json) {
    FormatOptions options("npz", json);
    using output::Aov;
    outputs_ = options.outputs("outputs", {Aov::Color, Aov::Depth, Aov::Normal, Aov::Id});
    file_ = options.frameFile("file", "{name}.npz", ".npz");
    options.finish();
  }

  std::vector<output::Aov> needs() const override { return outputs_; }
  std::vector<FormatFile> files(const DataFrame& frame) const override { return {{frameFile(file_, frame)}}; }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    output::ZipArchive archive;
    for (const output::Aov aov : outputs_)
      archive.add(std::string(output::info(aov).name) + ".npy", output::encodeNpy(imageOf(frame.picture, aov)));
    writeOf(record, folder, frameFile(file_, frame), archive.finish());
  }

 private:
  std::vector<output::Aov> outputs_;
  std::string file_;
};

}  // namespace

std::unique_ptr<Format> makeNpz(const nlohmann::ordered_json& options) {
  return std::make_unique<Npz>(options);
}

}  // namespace latelight::data
