#include "viewer/desktop.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>

#include "base/text.h"

namespace latelight::app {

namespace {

struct Close {
  void operator()(::Display* display) const { XCloseDisplay(display); }
};
using Connection = std::unique_ptr<::Display, Close>;

Connection connect(const std::string& display) {
  Connection made(XOpenDisplay(display.c_str()));
  if (!made) throw std::runtime_error("no display " + display);
  return made;
}

::Window windowAt(::Display* display, int x, int y) {
  int inX = 0, inY = 0;
  ::Window found = 0;
  XTranslateCoordinates(display, DefaultRootWindow(display), DefaultRootWindow(display), x, y, &inX, &inY, &found);
  if (!found) throw std::runtime_error("there is no window there");
  return found;
}

void setState(::Display* display, ::Window window, long state) {
  const Atom name = XInternAtom(display, "WM_STATE", False);
  const long words[] = {state, None};
  XChangeProperty(display, window, name, name, 32, PropModeReplace, reinterpret_cast<const unsigned char*>(words), 2);
}

class Drag {
 public:
  Drag(const std::string& display, int x, int y, std::string file) : display_(connect(display)), x_(x), y_(y) {
    replaceAll(file, " ", "%20");
    list_ = "file://" + file + "\r\n";
    source_ = XCreateSimpleWindow(get(), DefaultRootWindow(get()), 0, 0, 1, 1, 0, 0, 0);
    XSetSelectionOwner(get(), atom("XdndSelection"), source_, CurrentTime);
    target_ = windowAt(get(), x, y);
  }

  void drop() {
    send("XdndEnter", {long{5} << 24, static_cast<long>(atom("text/uri-list"))});
    send("XdndPosition", {0, long{x_} << 16 | y_, CurrentTime, static_cast<long>(atom("XdndActionCopy"))});
    if (!(waitFor("XdndStatus").data.l[1] & 1)) throw std::runtime_error("the window takes no files");
    send("XdndDrop", {0, CurrentTime});
    // GLFW returns the number of bytes that it accepted, where XDND has a single bit.
    if (waitFor("XdndFinished").data.l[1] == 0) throw std::runtime_error("the window did not take the file");
  }

 private:
  ::Display* get() const { return display_.get(); }
  Atom atom(const char* name) const { return XInternAtom(get(), name, False); }

  void send(const char* type, std::initializer_list<long> words) const {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = target_;
    event.xclient.message_type = atom(type);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(source_);
    long* word = event.xclient.data.l;
    for (const long value : words) *++word = value;
    XSendEvent(get(), target_, False, NoEventMask, &event);
  }

  // The list of files, for a window that requests it.
  void give(const XSelectionRequestEvent& asked) const {
    XChangeProperty(get(), asked.requestor, asked.property, asked.target, 8, PropModeReplace,
                    reinterpret_cast<const unsigned char*>(list_.data()), static_cast<int>(list_.size()));
    XEvent event{};
    event.xselection.type = SelectionNotify;
    event.xselection.requestor = asked.requestor;
    event.xselection.selection = asked.selection;
    event.xselection.target = asked.target;
    event.xselection.property = asked.property;
    XSendEvent(get(), asked.requestor, False, NoEventMask, &event);
  }

  XClientMessageEvent waitFor(const char* type) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);  // only against hangs
    while (std::chrono::steady_clock::now() < end) {
      while (XPending(get())) {
        XEvent event;
        XNextEvent(get(), &event);
        if (event.type == SelectionRequest) give(event.xselectionrequest);
        if (event.type == ClientMessage && event.xclient.message_type == atom(type)) return event.xclient;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    throw std::runtime_error(std::string("no ") + type + " from the window");
  }

  Connection display_;
  int x_, y_;
  std::string list_;
  ::Window source_ = 0, target_ = 0;
};

}  // namespace

void dropFile(const std::string& display, int x, int y, const std::string& file) {
  Drag(display, x, y, file).drop();
}

void setContentScale(const std::string& display, int percent) {
  const Connection to = connect(display);
  const std::string text = fmt::format("Xft.dpi:\t{}\n", 96 * percent / 100);
  XChangeProperty(to.get(), DefaultRootWindow(to.get()), XA_RESOURCE_MANAGER, XA_STRING, 8, PropModeReplace,
                  reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
}

unsigned long minimise(const std::string& display, int x, int y) {
  const Connection to = connect(display);
  const ::Window window = windowAt(to.get(), x, y);
  XUnmapWindow(to.get(), window);
  setState(to.get(), window, IconicState);
  return window;
}

void restore(const std::string& display, unsigned long window) {
  const Connection to = connect(display);
  setState(to.get(), window, NormalState);
  XMapWindow(to.get(), window);
}

// Its owner provides it as a property of a window of ours (ICCCM 2.2).
std::string clipboard(const std::string& display) {
  const Connection to = connect(display);
  const auto atom = [&to](const char* name) { return XInternAtom(to.get(), name, False); };
  const ::Window own = XCreateSimpleWindow(to.get(), DefaultRootWindow(to.get()), 0, 0, 1, 1, 0, 0, 0);
  const Atom property = atom("LATELIGHT_TEXT");
  XConvertSelection(to.get(), atom("CLIPBOARD"), atom("UTF8_STRING"), property, own, CurrentTime);
  XEvent event;
  do XNextEvent(to.get(), &event);
  while (event.type != SelectionNotify);
  if (event.xselection.property == None) throw std::runtime_error("nobody has copied a text");
  Atom type = 0;
  int bits = 0;
  unsigned long size = 0, left = 0;
  unsigned char* bytes = nullptr;
  XGetWindowProperty(to.get(), own, property, 0, 1 << 20, False, AnyPropertyType, &type, &bits, &size, &left, &bytes);
  std::string text(reinterpret_cast<const char*>(bytes), size);
  XFree(bytes);
  return text;
}

}  // namespace latelight::app
