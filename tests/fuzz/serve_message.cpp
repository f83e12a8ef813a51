// Messages of a page of `latelight serve` as a sequence: texts of JSON and pieces of a file. A byte gives the kind of a
// message and two bytes its length.
#include <memory>

#include "fuzz/fuzz.h"
#include "serve/messages.h"
#include "serve/upload.h"

using namespace latelight;

namespace {

// A page's connection, as in src/serve/socket.cpp.
class Page {
 public:
  void takeText(std::string_view text) {
    const serve::Order order = serve::readOrder(text, start_);
    if (const auto* sent = std::get_if<serve::SendFile>(&order.what))
      upload_ = std::make_unique<serve::Upload>(*sent, order.serial);
  }
  void takePiece(std::span<const std::byte> piece) {
    if (!upload_) return;
    upload_->add(piece);
    if (upload_->isComplete()) serve::isFile(upload_->order()), upload_.reset();
  }

 private:
  view::Start start_;
  std::unique_ptr<serve::Upload> upload_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  Page page;
  try {
    for (std::span<const uint8_t> rest(data, size); rest.size() >= 3;) {
      const bool isText = rest[0] % 4 != 0;
      const size_t length = std::min(rest[1] + (size_t{rest[2]} << 8), rest.size() - 3);
      const std::span<const uint8_t> message = rest.subspan(3, length);
      rest = rest.subspan(3 + length);
      if (isText)
        page.takeText(fuzz::textOf(message.data(), message.size()));
      else
        page.takePiece(std::as_bytes(message));
    }
  } catch (const serve::BadMessage&) {
  }
  return 0;
}
