// Writes a data set in every format, and the rendered values next to it, as .npy. read_set.py reads it.
#include <algorithm>
#include <cstdlib>
#include <set>

#include "data_formats/support.h"
#include "output/npy.h"

namespace latelight::data::test {
namespace {

using output::Aov;

class SetTest : public FormatsTest {
 protected:
  struct Written {
    std::unique_ptr<Format> format;
    std::string name, folder;
    std::vector<Json> entries;
    size_t files = 0;  // of all frames
    std::set<std::string> stated = {}, written = {};
  };

  void add(std::string_view name, const Json& options = Json::object()) {
    const auto same = static_cast<size_t>(
        std::ranges::count_if(formats_, [&](const Written& written) { return written.name == name; }));
    const std::string folder = same == 0 ? std::string(name) : fmt::format("{}-{}", name, same + 1);
    formats_.push_back({make(name, options), std::string(name), folder, {}, 0});
  }

  // A frame in all formats, each in a folder of its own: "exr", "exr-2", ...
  void write(DataFrame frame, const std::filesystem::path& set) {
    writeRaw(frame.picture, set / "raw" / frame.name);
    writeRaw(frame.samples, set / "raw" / frame.name / "samples");
    for (Written& written : formats_) {
      for (FormatFile& file : written.format->files(frame)) written.stated.insert(std::move(file.name));
      FrameRecord record = written.format->writeFrame(frame, set / written.folder);
      written.entries.push_back(std::move(record.entry));
      expectFiles(set / written.folder, record.files);
      written.written.insert(record.files.begin(), record.files.end());
      written.files += record.files.size();
    }
  }

  void finish(const std::filesystem::path& set) {
    for (Written& written : formats_) {
      const std::vector<std::string> files = written.format->writeSet({written.entries}, set / written.folder);
      expectFiles(set / written.folder, files);
      written.written.insert(files.begin(), files.end());
      expectStated(written);
      EXPECT_GT(written.files + files.size(), 0u) << written.folder;
    }
  }

  static void expectFiles(const std::filesystem::path& folder, const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      std::error_code error;
      EXPECT_GT(std::filesystem::file_size(folder / name, error), 0u) << folder / name;
      EXPECT_FALSE(error) << folder / name << ": " << error.message();
    }
  }

  // Formats state their files before they write them: by name, or by a folder.
  static void expectStated(const Written& written) {
    std::set<std::string> expected;
    for (const std::string& file : written.written) {
      const std::string folder = file.substr(0, file.rfind('/') + 1);
      expected.insert(written.stated.contains(folder) ? folder : file);
    }
    EXPECT_EQ(written.stated, expected) << written.folder;
  }

  static void writeRaw(const output::FrameOutput& picture, const std::filesystem::path& raw) {
    std::filesystem::create_directories(raw);
    for (const output::AovImage& image : picture.aovs)
      writeFile(raw / fmt::format("{}.npy", output::info(image.aov).name), output::encodeNpy(image));
  }

  std::vector<Written> formats_;
};

TEST_F(SetTest, HasTheFilesThatItsRecordsName) {
  const char* kept = std::getenv("LATELIGHT_TEST_SET");  // set by read_set, which compares their contents
  const std::filesystem::path set = kept ? kept : folder;
  const Json all{"color", "depth", "distance", "normal", "position", "albedo", "id", "material", "uv", "motion"};
  add("files", {{"outputs", {"depth", "id", "normal"}}, {"pattern", "{name}.npy"}, {"side-file", false}});
  add("files", {{"outputs", {"depth", "id", "normal"}}, {"pattern", "{name}.exr"}, {"side-file", false}});
  add("exr", {{"outputs", all}});
  add("exr", {{"outputs", all}, {"names", "blender"}, {"id-manifest", false}});
  add("npz", {{"outputs", all}});
  add("depth-png");
  add("depth-png", {{"unit", "kitti"}});
  add("flow");
  add("flow", {{"as", "kitti"}});
  add("coco", {{"categories", "node"}});
  add("yolo", {{"categories", "node"}});
  add("voc", {{"categories", "node"}});
  add("kitti", {{"categories", "node"}});
  add("boxes", {{"masks", true}});
  add("bop", {{"depth-scale", 0.5}});
  add("transforms");
  add("cryptomatte", {{"samples", 3}});
  add("ply");
  try {
    add("video", {{"fps", 12}});
  } catch (const Error& error) {
    fmt::print("no film is made: {}\n", error.what());
  }
  try {
    add("hdf5", {{"keys",
                  {"colors", "depth", "distance", "normals", "diffuse", "nocs", "instance_segmaps",
                   "category_id_segmaps", "forward_flow", "backward_flow"}},
                 {"categories", "material"}});
  } catch (const Error& error) {
    fmt::print("no HDF5 files are written: {}\n", error.what());
  }
  add("scannet", {{"categories", "material"}});
  add("colmap", {{"points", 4}});
  add("colmap", {{"points", 4}, {"as", "text"}});
  add("transforms", {{"points", 4}});
  add("webdataset", {{"outputs", {"color", "depth", "id"}}, {"frames", 2}});
  add("webdataset", {{"outputs", {"depth"}}, {"arrays", "exr"}});

  const scene::Scene& scene = render::test::hall();
  Studio studio(device(), scene);
  std::vector<const Format*> formats;
  for (const Written& written : formats_) formats.push_back(written.format.get());
  scene::Camera camera = render::test::cameraOf(scene, 96, 64);
  for (uint64_t i = 0; i < 3; ++i) {
    render::SceneState moment;
    moment.previousCameras = {camera};
    camera.toWorld[3] += glm::vec4(0.125f, 0.25f, 0, 0);
    moment.nextCameras = {camera};
    moment.nextCameras[0].toWorld[3] += glm::vec4(0.125f, 0.25f, 0, 0);
    write(studio.frame(camera, 96, 64, formats, i, moment), set);
  }
  finish(set);
}

}  // namespace
}  // namespace latelight::data::test
