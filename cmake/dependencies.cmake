# Finds the dependencies, all of which are Debian 12 packages; `./dev setup` installs them.
find_package(Threads REQUIRED)
find_package(fmt REQUIRED)
find_package(glm REQUIRED)
find_package(Vulkan REQUIRED)
find_package(SPIRV-Headers REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(meshoptimizer REQUIRED)
# Debian's libimath-dev also declares Imath's Python library, which is in another package, and prints long messages if
# that is not installed. Latelight does not use it.
set(log_level "${CMAKE_MESSAGE_LOG_LEVEL}")
set(CMAKE_MESSAGE_LOG_LEVEL ERROR)
find_package(OpenEXR REQUIRED)
set(CMAKE_MESSAGE_LOG_LEVEL "${log_level}")
find_package(ZLIB REQUIRED)
find_package(Boost CONFIG REQUIRED)  # only Beast, which is header-only
find_package(PkgConfig REQUIRED)
find_package(draco CONFIG REQUIRED)
pkg_check_modules(webp REQUIRED IMPORTED_TARGET libwebp)
pkg_check_modules(turbojpeg REQUIRED IMPORTED_TARGET libturbojpeg)
pkg_check_modules(spng REQUIRED IMPORTED_TARGET spng)
pkg_check_modules(isal REQUIRED IMPORTED_TARGET libisal)
pkg_check_modules(zstd REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(re2 REQUIRED IMPORTED_TARGET re2)
option(LATELIGHT_AVIF "Read pictures in AVIF, where libavif is installed" ON)
if(LATELIGHT_AVIF)
  pkg_check_modules(avif IMPORTED_TARGET libavif)
endif()
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
find_program(GLSLANG glslangValidator REQUIRED)

# The windows of `latelight view`. A build for machines without a display may omit them.
option(LATELIGHT_VIEWER "Build latelight view" ON)
if(LATELIGHT_VIEWER)
  find_package(glfw3 3.3 REQUIRED)
  find_package(X11 REQUIRED)  # GLFW opens windows with it
  pkg_check_modules(imgui REQUIRED IMPORTED_TARGET imgui)
endif()

# volk loads Vulkan at run time, so no target links libvulkan.
add_compile_definitions(VK_NO_PROTOTYPES)

add_library(latelight_scene_dependencies INTERFACE)
target_link_libraries(latelight_scene_dependencies INTERFACE
  meshoptimizer::meshoptimizer draco::draco PkgConfig::webp PkgConfig::turbojpeg PkgConfig::spng
  PkgConfig::zstd OpenEXR::OpenEXR nlohmann_json::nlohmann_json)
add_library(latelight_output_dependencies INTERFACE)
target_link_libraries(latelight_output_dependencies INTERFACE
  PkgConfig::spng PkgConfig::isal OpenEXR::OpenEXR ZLIB::ZLIB nlohmann_json::nlohmann_json)
add_library(latelight_data_dependencies INTERFACE)
target_link_libraries(latelight_data_dependencies INTERFACE
  PkgConfig::re2 PkgConfig::turbojpeg nlohmann_json::nlohmann_json yaml-cpp ${CMAKE_DL_LIBS})
