#include "serve/viewer.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <new>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/fatal_signals.h"
#include "serve/pace.h"
#include "serve/picture.h"

namespace latelight::serve {

namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr size_t kMaxOrdersWaiting = 4096;  // number of orders; pages send a few hundred per second at most

constexpr std::string_view kPicture = "an image that is sent to the page";

// Bytes per pixel of a screenshot while it is encoded: the pixels, the filtered rows, and the file.
constexpr uint64_t kScreenshotBytesPerPixel = 12;

// A picture encoded with the highest quality that Pace allows, and its header for the page. `fine`: it is a final
// picture at rest.
struct Encoded {
  Json header;
  std::vector<Strip> strips;
  MemoryClaim stripsMemory, messageMemory;
};
Encoded encode(const view::SessionFrame& frame, const Pace& pace, bool fine) {
  const auto begin = Clock::now();
  MemoryClaim memory(encodingBytes(frame), kPicture);
  int quality = pace.quality(fine);
  std::vector<Strip> strips = encodeStrips(frame, quality);
  while (fine) {
    const int coarser = pace.coarser(quality, bytesOf(strips));
    if (coarser == quality) break;
    strips = encodeStrips(frame, quality = coarser);
  }
  const size_t bytes = bytesOf(strips);
  memory = {};
  Encoded encoded{{{"width", frame.width},
                   {"height", frame.height},
                   {"final", fine},
                   {"quality", quality},
                   {"milliseconds", frame.milliseconds},
                   {"encoding", 1000 * std::chrono::duration<double>(Clock::now() - begin).count()},
                   {"passes", Json::array()},
                   {"strips", Json::array()}},
                  std::move(strips),
                  MemoryClaim(bytes, kPicture),
                  MemoryClaim(bytes, kPicture)};
  for (const graph::PassTime& pass : frame.passes) encoded.header["passes"].push_back({pass.name, pass.milliseconds});
  for (const Strip& strip : encoded.strips)
    encoded.header["strips"].push_back({{"y", strip.y}, {"bytes", strip.jpeg.size()}});
  return encoded;
}

// Runs `act`, and returns the error sentence if there is not enough memory for it, or an empty string.
template <typename Act>
std::string refusalOf(const Act& act) {
  try {
    act();
    return "";
  } catch (const Error& error) {
    return error.what();
  } catch (const std::bad_alloc&) {
    return "the machine has no memory left for the picture; use a smaller one";
  }
}

}  // namespace

struct Viewer::Impl {
  Impl(std::unique_ptr<view::ViewSession> ready, const view::Start& start, Calls calls)
      : start(start), calls(std::move(calls)), session(std::move(ready)) {}

  void run();
  bool mayFollow() const;
  std::deque<Order> takeOrders();
  bool waitForWork();
  void follow(const Order& order);
  void sendNews();
  void sendScreenshot(view::Side side);
  void send(Json header, const std::vector<std::string_view>& payload, MemoryClaim memory = {});
  Pace paceNow() {
    std::lock_guard lock(mutex);
    return pace;
  }
  void notePicture(size_t bytes) {
    std::lock_guard lock(mutex);
    pace.made(bytes);
  }

  const view::Start start;
  const Calls calls;
  std::unique_ptr<view::ViewSession> session;
  std::vector<std::string> validationMessages;
  Json told = Json::object();  // session state that the page has
  uint64_t messages = 0, pictures = 0, serial = 0, serialTold = 0;
  bool showsLights = false;
  bool isFine = false, restsTold = false;  // `isFine`: the last picture was sent at final quality
  std::string refusal;                     // the reason if it was not sent

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Order> waiting;
  Pace pace;
  bool stops = false, hasBegun = false;
  std::thread thread;
};

// Orders are executed in sequence. An order that requires an answer waits until Pace permits a message, and so do all
// after it: a page that does not read receives at most what Pace allows.
bool Viewer::Impl::mayFollow() const {
  return !waiting.empty() && (!isAnswered(waiting.front()) || pace.maySend());
}

// Takes the orders up to and including the first one that requires an answer, if Pace permits the answer.
std::deque<Order> Viewer::Impl::takeOrders() {
  std::deque<Order> orders;
  for (bool answered = false; !answered && mayFollow(); waiting.pop_front()) {
    answered = isAnswered(waiting.front());
    orders.push_back(std::move(waiting.front()));
  }
  return orders;
}

// Waits for work and executes orders. No pictures are rendered while Pace does not permit a message, or before the
// first order, which states the size of pictures. Returns false if the thread must stop.
bool Viewer::Impl::waitForWork() {
  std::deque<Order> orders;
  {
    std::unique_lock lock(mutex);
    const bool mayMake = hasBegun && pace.maySend();
    const auto news = [&] { return stops || mayFollow() || (hasBegun && !mayMake && pace.maySend()); };
    if (mayMake)
      changed.wait_for(lock, std::chrono::duration<double>(session->secondsUntilStep()), news);
    else
      changed.wait(lock, news);
    if (stops) return false;
    orders = takeOrders();
  }
  hasBegun |= !orders.empty();
  for (const Order& order : orders) follow(order);
  return true;
}

void Viewer::Impl::follow(const Order& order) {
  if (const auto* input = std::get_if<view::Input>(&order.what))
    session->input(*input);
  else if (const auto* shot = std::get_if<TakeScreenshot>(&order.what))
    sendScreenshot(shot->side);
  else if (const auto* lights = std::get_if<ShowLights>(&order.what))
    showsLights = lights->on;
  else if (const auto* refused = std::get_if<Refused>(&order.what))
    send({{"failed", refused->sentence}}, {});
  serial = std::max(serial, order.serial);  // a file's order is executed once the file is complete
}

// `memory` is the claim for the message, if it has a payload.
void Viewer::Impl::send(Json header, const std::vector<std::string_view>& payload, MemoryClaim memory) {
  header["number"] = ++messages;
  header["serial"] = serial;
  Message message{envelope(header, payload), std::move(memory)};
  {
    std::lock_guard lock(mutex);
    pace.sent(messages, message.bytes.size(), Clock::now());
  }
  calls.send(std::move(message));
}

void Viewer::Impl::sendScreenshot(view::Side side) {
  std::vector<std::byte> png;
  MemoryClaim memory, messageMemory;
  const std::string refusal = refusalOf([&] {
    const view::State& state = session->state();
    memory.grow(kScreenshotBytesPerPixel * state.width * state.height, "the screenshot");
    png = session->screenshot(side);
    messageMemory.grow(png.size(), "the screenshot");
  });
  if (!refusal.empty()) return send({{"failed", refusal}}, {});
  send({{"screenshot", png.size()}}, {{reinterpret_cast<const char*>(png.data()), png.size()}},
       std::move(messageMemory));
}

// Sends the changes of the state and a new picture, if any, or only a confirmation that orders were executed. A fast
// device renders at full resolution while something moves; the last picture is sent again at final quality once nothing
// moves.
void Viewer::Impl::sendNews() {
  Json header = Json::object();
  Encoded encoded{};
  std::vector<std::string_view> payload;
  if (session->wantsFrame()) session->next();
  const view::SessionFrame& frame = session->frame();
  const bool fine = frame.final && !session->moves();
  if (frame.width != 0 && (frame.number != pictures || (fine && !isFine))) {
    pictures = frame.number, isFine = fine;
    refusal = refusalOf([&] { encoded = encode(frame, paceNow(), fine); });
    if (refusal.empty()) header["picture"] = encoded.header;
    if (!fine && refusal.empty()) notePicture(bytesOf(encoded.strips));
    for (const Strip& strip : encoded.strips) payload.push_back(strip.jpeg);
  }
  Json now = describe(*session, showsLights);
  if (!refusal.empty()) now["error"] = refusal;
  Json changed = changes(told, now);
  told = std::move(now);
  if (!changed.empty()) header["state"] = std::move(changed);
  const bool rests = fine && !session->wantsFrame();
  if (header.empty() && serial == serialTold && rests == restsTold) return;
  header["rests"] = restsTold = rests;
  serialTold = serial;
  send(std::move(header), payload, std::move(encoded.messageMemory));
}

void Viewer::Impl::run() {
  try {
    if (!session) session = std::make_unique<view::ViewSession>(start);
    send({{"tables", tables(start)}}, {});
    while (waitForWork())
      if (hasBegun && paceNow().maySend()) sendNews();
    validationMessages = session->validationMessages();
  } catch (const Error& error) {
    calls.fail({error.what(), !session && error.code() == ExitCode::BadInput});
  } catch (const std::exception& error) {
    calls.fail({error.what()});
  }
  session.reset();
  calls.ended();
}

Viewer::Viewer(std::unique_ptr<view::ViewSession> ready, const view::Start& start, Calls calls)
    : impl_(std::make_unique<Impl>(std::move(ready), start, std::move(calls))) {
  impl_->thread = std::thread([impl = impl_.get()] {
    const SignalStack stack;
    impl->run();
  });
}

Viewer::~Viewer() {
  stop();
  impl_->thread.join();
}

void Viewer::take(Order order) {
  std::lock_guard lock(impl_->mutex);
  if (const auto* shown = std::get_if<Shown>(&order.what))
    impl_->pace.shown(shown->number, Clock::now());
  else if (impl_->waiting.size() < kMaxOrdersWaiting)
    impl_->waiting.push_back(std::move(order));
  else
    throw BadMessage("too many messages at once");
  impl_->changed.notify_all();
}

void Viewer::dropFile() {
  std::lock_guard lock(impl_->mutex);
  std::erase_if(impl_->waiting, isFile);
}

void Viewer::wrote() {
  std::lock_guard lock(impl_->mutex);
  impl_->pace.written(Clock::now());
  impl_->changed.notify_all();
}

void Viewer::stop() {
  std::lock_guard lock(impl_->mutex);
  impl_->stops = true;
  impl_->changed.notify_all();
}

const std::vector<std::string>& Viewer::validationMessages() const {
  return impl_->validationMessages;
}

}  // namespace latelight::serve
