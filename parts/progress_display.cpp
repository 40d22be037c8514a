#include "parts/progress_display.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

namespace mfs::program {

ProgressDisplay::ProgressDisplay() : terminal_(isatty(STDERR_FILENO) == 1) {}
ProgressDisplay::~ProgressDisplay() {
  clear();
}

void ProgressDisplay::show(const std::string& phase, double fraction) {
  if (!terminal_) return;
  constexpr int width = 30;
  const double part = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  const std::string bar(static_cast<std::size_t>(part * width), '=');
  std::string line = fmt::format("{:<10} [{:<{}}] {:3.0f} %", phase, bar, width, 100 * part);
  if (line == shown_) return;
  fmt::print(stderr, "\r\033[K{}", line);
  std::fflush(stderr);
  shown_ = std::move(line);
}

void ProgressDisplay::clear() {
  if (shown_.empty()) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  shown_.clear();
}

std::function<void(const Progress&)> ProgressDisplay::callback() {
  if (!terminal_) return {};
  return [this](const Progress& progress) { show(progress.phase, progress.fraction); };
}

}  // namespace mfs::program
