// Simulates the actions of a desktop environment on windows, on a display without one.
#pragma once

#include <string>

namespace latelight::app {

// Drags the file over the topmost window at a place of the screen and lets go of it there, by the protocol XDND
// (freedesktop.org, version 5). Returns once the window has taken it; throws std::runtime_error where it does not.
void dropFile(const std::string& display, int x, int y, const std::string& file);

// How large letters are wanted, in 1/100 of the usual; windows that open later follow it.
void setContentScale(const std::string& display, int percent);

// As window managers do it (ICCCM 4.1.4) to the topmost window at a place; gives its number, to restore it by.
unsigned long minimise(const std::string& display, int x, int y);
void restore(const std::string& display, unsigned long window);

// The text that a window has copied; throws std::runtime_error where none has.
std::string clipboard(const std::string& display);

}  // namespace latelight::app
