// An OpenEXR input stream over bytes in memory.
#pragma once

#include <OpenEXR/ImfIO.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>

namespace latelight::scene {

// `bytes` must outlive the stream. OpenEXR puts `name` into its messages.
class ExrStream : public Imf::IStream {
 public:
  ExrStream(std::span<const std::byte> bytes, const std::string& name) : IStream(name.c_str()), bytes_(bytes) {}

  bool read(char to[], int count) override {
    std::memcpy(to, advance(count), static_cast<size_t>(count));
    return next_ < bytes_.size();
  }
  uint64_t tellg() override { return next_; }
  void seekg(uint64_t position) override { next_ = position; }

 private:
  const char* advance(int count) {
    if (count < 0 || next_ > bytes_.size() || static_cast<uint64_t>(count) > bytes_.size() - next_)
      throw std::runtime_error("it ends early");
    const char* from = reinterpret_cast<const char*>(bytes_.data()) + next_;
    next_ += static_cast<uint64_t>(count);
    return from;
  }

  std::span<const std::byte> bytes_;
  uint64_t next_ = 0;
};

}  // namespace latelight::scene
