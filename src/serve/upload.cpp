#include "serve/upload.h"

#include <fmt/format.h>

#include <new>
#include <utility>

#include "base/error.h"

namespace latelight::serve {

Upload::Upload(SendFile announced, uint64_t serial)
    : announced_(std::move(announced)), serial_(serial), contents_(std::make_shared<Contents>()) {
  const std::string what = fmt::format("the file '{}'", shortened(announced_.name));
  try {
    contents_->memory.grow(announced_.bytes, what);
    contents_->bytes.reserve(announced_.bytes);
  } catch (const Error& error) {
    refusal_ = error.what();
  } catch (const std::bad_alloc&) {
    refusal_ = fmt::format("the machine has no memory left for {}", what);
  }
}

void Upload::add(std::span<const std::byte> piece) {
  received_ += piece.size();
  if (received_ > announced_.bytes) throw BadMessage("a file is longer than its page announced");
  if (refusal_.empty()) contents_->bytes.insert(contents_->bytes.end(), piece.begin(), piece.end());
}

Order Upload::order() {
  if (!refusal_.empty()) return {Refused{refusal_}, serial_};
  std::shared_ptr<const std::vector<std::byte>> bytes(contents_, &contents_->bytes);
  return {view::UploadEnvironment{announced_.name, std::move(bytes)}, serial_};
}

}  // namespace latelight::serve
