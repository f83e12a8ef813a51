// Functions that the fuzz targets share. A target is one file of this folder with LLVMFuzzerTestOneInput(), which
// passes any bytes to one parser (docs/quality.md, "Fuzzing"). The parser may return a result or throw the Error that
// its header promises; everything else ends the process, and libFuzzer reports the input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"

namespace latelight::fuzz {

// Sets the process up: one thread, no warnings, and a memory limit below that of libFuzzer. Every target calls it
// first; calls after the first do nothing.
void start();

inline std::span<const std::byte> bytesOf(const uint8_t* data, size_t size) {
  return std::as_bytes(std::span(data, size));
}
inline std::string_view textOf(const uint8_t* data, size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// A folder in memory, if the machine has one, that is removed when the process ends.
const std::filesystem::path& folder();

// Overwrites a file of folder() and returns its path.
std::filesystem::path writeInput(const char* name, std::span<const std::byte> bytes);

// Ends the process with a message that libFuzzer reports with the input.
[[noreturn]] void report(std::string_view what);

// Calls the parser. An Error with one of these codes, or without memory, is a proper answer if its sentence is
// complete.
template <typename Call>
void expectErrors(std::initializer_list<ExitCode> codes, Call call) {
  try {
    call();
  } catch (const Error& error) {
    const std::string_view sentence = error.what();
    bool expected = error.code() == ExitCode::OutOfMemory;
    for (const ExitCode code : codes) expected |= error.code() == code;
    if (!expected || sentence.empty() || sentence.find('\n') != sentence.npos) report(sentence);
  } catch (const std::exception& error) {
    report(error.what());
  }
}

}  // namespace latelight::fuzz
