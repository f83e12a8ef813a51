// Every header in src/shared, and every header that the build generates from them, compiles by itself as GLSL and as
// C++, and includes only others of these. Headers for arbitrary engines also compile as HLSL.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "architecture/command.h"
#include "base/error.h"
#include "base/files.h"
#include "base/parallel.h"

namespace latelight {
namespace {

namespace fs = std::filesystem;

std::string includePaths() {
  return fmt::format("-I'{}/shared' -I'{}'", LATELIGHT_INCLUDE_PATHS, LATELIGHT_GENERATED_DIR);
}

class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "latelight-headers-XXXXXX").string();
    if (!mkdtemp(name.data())) fail(ExitCode::Internal, "no temporary folder");
    path_ = name;
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  // Creates a file that is named after the header and contains `text`.
  std::string write(std::string header, const char* ending, const std::string& text) const {
    for (char& c : header) c = c == '/' ? '_' : c;
    const fs::path path = path_ / (header + ending);
    writeFile(path, std::as_bytes(std::span(text)));
    return path.string();
  }

 private:
  fs::path path_;
};

Result compileAsGlsl(const Folder& folder, const std::string& header) {
  const std::string text = fmt::format(
      "#version 460\n"
      "#extension GL_EXT_scalar_block_layout : require\n"
      "#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require\n"
      "#extension GL_GOOGLE_include_directive : require\n"
      "#include \"{}\"\n"
      "layout(local_size_x = 1) in;\n"
      "void main() {{}}\n",
      header);
  const std::string file = folder.write(header, ".comp", text);
  return runCommand(fmt::format("'{}' --quiet --target-env vulkan1.3 {} -o '{}.spv' '{}'", LATELIGHT_GLSLANG,
                                includePaths(), file, file));
}

Result compileAsHlsl(const Folder& folder, const std::string& header) {
  const std::string text =
      fmt::format("#define SH_HLSL\n#include \"{}\"\n[numthreads(1, 1, 1)] void main() {{}}\n", header);
  const std::string file = folder.write(header, ".hlsl", text);
  return runCommand(fmt::format("'{}' --quiet -D -S comp -e main --target-env vulkan1.1 {} -o '{}.spv' '{}'",
                                LATELIGHT_GLSLANG, includePaths(), file, file));
}

Result compileAsCpp(const Folder& folder, const std::string& header) {
  const std::string file = folder.write(header, ".cpp", fmt::format("#include \"{}\"\n", header));
  return runCommand(
      fmt::format("'{}' -std=c++20 -fsyntax-only -Wall -Wextra -Werror {} '{}'", LATELIGHT_CXX, includePaths(), file));
}

std::vector<std::string> sharedHeaders() {
  std::vector<std::string> headers;
  const fs::path source = fs::path(LATELIGHT_SOURCE_DIR) / "src";
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(source / "shared")) {
    if (entry.path().extension() == ".h") headers.push_back(fs::relative(entry.path(), source).string());
  }
  headers.push_back("normals.h");
  return headers;
}

// The headers for arbitrary engines (docs/shared-headers.md).
std::vector<std::string> portableHeaders() {
  std::vector<std::string> headers = sharedHeaders();
  std::erase_if(headers, [](const std::string& header) {
    static const std::set<std::string> single = {"shared/lang.h", "shared/unorm.h", "shared/projection.h",
                                                 "shared/depth_packing.h", "normals.h"};
    return !single.contains(header) && !header.starts_with("shared/normal/");
  });
  return headers;
}

void expectAllToCompile(const std::vector<std::string>& headers, Result compile(const Folder&, const std::string&)) {
  const Folder folder;
  ASSERT_GE(headers.size(), 10u);
  parallelFor(headers.size(), 1, [&](size_t i, size_t) {
    const Result result = compile(folder, headers[i]);
    EXPECT_TRUE(result.good) << headers[i] << " does not compile alone:\n" << result.output;
  });
}

TEST(SharedHeaders, CompileAloneAsGlsl) {
  expectAllToCompile(sharedHeaders(), compileAsGlsl);
}

TEST(SharedHeaders, PortableOnesCompileAloneAsHlsl) {
  expectAllToCompile(portableHeaders(), compileAsHlsl);
}

TEST(SharedHeaders, CompileAloneAsCpp) {
  expectAllToCompile(sharedHeaders(), compileAsCpp);
}

TEST(SharedHeaders, ThatDoNotCompileAreNoticed) {
  const Folder folder;
  EXPECT_TRUE(compileAsGlsl(folder, "shared/lang.h").good);
  EXPECT_TRUE(compileAsCpp(folder, "shared/lang.h").good);
  EXPECT_TRUE(compileAsHlsl(folder, "shared/lang.h").good);
  EXPECT_FALSE(compileAsGlsl(folder, "shared/no_such_header.h").good);
  EXPECT_FALSE(compileAsCpp(folder, "shared/no_such_header.h").good);
  EXPECT_FALSE(compileAsHlsl(folder, "shared/no_such_header.h").good);
}

}  // namespace
}  // namespace latelight
