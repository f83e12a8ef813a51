// All outputs of a frame in one NPZ file: NPY arrays in a ZIP archive, as numpy.savez writes it.
#include <zip.h>

#include <memory>

#include "base/error.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "output/npy.h"

namespace latelight::data {

namespace {

constexpr uint16_t kFirstDay = (0 << 9) | (1 << 5) | 1;  // of a ZIP archive's calendar: 1 January 1980

struct KeptEntry {
  std::string name;
  std::vector<std::byte> bytes;
};

[[noreturn]] void cantPack(zip_error_t* error) {
  fail(ExitCode::Internal, "the arrays can't be packed: {}", zip_error_strerror(error));
}

// Throws what libzip says went wrong.
void check(bool done, zip_t* archive) {
  if (!done) cantPack(zip_get_error(archive));
}

std::vector<std::byte> contentsOf(zip_source_t* source) {
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_source_stat(source, &stat) != 0 || zip_source_open(source) != 0) cantPack(zip_source_error(source));
  std::vector<std::byte> bytes(stat.size);
  const zip_int64_t got = zip_source_read(source, bytes.data(), bytes.size());
  zip_source_close(source);
  if (got != static_cast<zip_int64_t>(bytes.size())) cantPack(zip_source_error(source));
  return bytes;
}

// An archive of these, not compressed. The same entries give the same bytes.
std::vector<std::byte> zipOf(const std::vector<KeptEntry>& entries) {
  zip_error_t error;
  zip_error_init(&error);
  const std::unique_ptr<zip_source_t, decltype(&zip_source_free)> out(zip_source_buffer_create(nullptr, 0, 0, &error),
                                                                      zip_source_free);
  if (!out) cantPack(&error);
  zip_source_keep(out.get());  // for after the archive is closed, which frees one reference
  std::unique_ptr<zip_t, decltype(&zip_discard)> archive(zip_open_from_source(out.get(), ZIP_TRUNCATE, &error),
                                                         zip_discard);
  if (!archive) cantPack(&error);
  for (const KeptEntry& entry : entries) {
    zip_source_t* source = zip_source_buffer(archive.get(), entry.bytes.data(), entry.bytes.size(), 0);
    check(source != nullptr, archive.get());
    const zip_int64_t at = zip_file_add(archive.get(), entry.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    check(at >= 0, archive.get());
    const auto index = static_cast<zip_uint64_t>(at);
    check(zip_set_file_compression(archive.get(), index, ZIP_CM_STORE, 0) == 0, archive.get());
    check(zip_file_set_dostime(archive.get(), index, 0, kFirstDay, 0) == 0, archive.get());
  }
  check(zip_close(archive.get()) == 0, archive.get());
  (void)archive.release();
  return contentsOf(out.get());
}

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

  FrameRecord writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const override {
    std::vector<KeptEntry> entries;
    for (const output::Aov aov : outputs_)
      entries.push_back({std::string(output::info(aov).name) + ".npy", output::encodeNpy(imageOf(frame.picture, aov))});
    FrameRecord record;
    writeOf(record, folder, frameFile(file_, frame), zipOf(entries));
    return record;
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
