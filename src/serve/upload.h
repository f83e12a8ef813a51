// A file that a page uploads in several messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/memory.h"
#include "serve/messages.h"

namespace latelight::serve {

class Upload {
 public:
  // Claims the memory for the complete file. If there is not enough, the pieces are dropped as they arrive.
  Upload(SendFile announced, uint64_t serial);

  void add(std::span<const std::byte> piece);  // throws BadMessage if the pieces exceed what was announced
  bool isComplete() const { return received_ >= announced_.bytes; }
  // Call it when the file is complete. Returns the file, whose memory remains claimed while the order exists, or the
  // reason for its rejection.
  Order order();

 private:
  struct Contents {
    MemoryClaim memory;
    std::vector<std::byte> bytes;
  };
  const SendFile announced_;
  const uint64_t serial_;
  std::shared_ptr<Contents> contents_;
  std::string refusal_;
  size_t received_ = 0;
};

}  // namespace latelight::serve
