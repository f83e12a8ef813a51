// Simulates the actions of a desktop environment on windows, on a display without one.
#pragma once

#include <string>

namespace latelight::app {

// Drags the file over the topmost window at a position of the screen and drops it there, with the protocol XDND
// (freedesktop.org, version 5). Returns once the window has accepted it; throws std::runtime_error if it does not.
void dropFile(const std::string& display, int x, int y, const std::string& file);

// Sets the size of letters, in 1/100 of the usual one, for windows that open later.
void setContentScale(const std::string& display, int percent);

// Minimizes the topmost window at a position, as window managers do (ICCCM 4.1.4). Returns its number, with which it
// can be restored.
unsigned long minimise(const std::string& display, int x, int y);
void restore(const std::string& display, unsigned long window);

// Returns the text that a window has copied; throws std::runtime_error if none has.
std::string clipboard(const std::string& display);

}  // namespace latelight::app
