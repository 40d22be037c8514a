// What is told while a run goes on, by the clock: on a terminal a line that changes (of 80 characters at
// most, with its bar), in a log a line each time the run has taken twice as long as at the one before.
// Telling it after every step would take longer than small mechanisms take for one.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "ordering/stopwatch.hpp"
#include "parts/progress_display.hpp"

namespace mfs::dae {

/// "90 s", "15 min", "3 h", "12 d".
inline std::string duration_text(double seconds) {
  constexpr struct {
    double length;
    const char* name;
  } kUnits[] = {{1.0, "s"}, {60.0, "min"}, {3600.0, "h"}};
  for (const auto& unit : kUnits)
    if (seconds < 100.0 * unit.length) return fmt::format("{:.0f} {}", seconds / unit.length, unit.name);
  return fmt::format("{:.3g} d", seconds / 86400.0);
}

class RunProgress {
 public:
  RunProgress(double end, bool on_terminal) : end_(end), on_terminal_(on_terminal) {}

  /// After a step or an output, `wall` s after the run has begun; empty: nothing is to be told. What is left
  /// is expected to take as long as what has been done since something was told.
  std::string after_step(std::int64_t number, double t, double wall) {
    if (wall < next_) return {};
    const bool is_later = t > t_then_;  // outputs are told after the step that they are in
    const double took = is_later ? wall - told_at_ : wall, done = is_later ? t - t_then_ : t;
    const double left = (end_ - t) * took / done;
    told_at_ = wall;
    t_then_ = t;
    next_ = on_terminal_ ? wall + kOnTerminal : 2.0 * wall;
    const std::string time = on_terminal_ ? "" : fmt::format(", t = {:.6g} of {:.6g} s", t, end_);
    return fmt::format("step {}{}", number, time) +
           (std::isfinite(left) ? fmt::format(", {} to go", duration_text(left)) : "");
  }

  static constexpr double kOnTerminal = 0.2, kFirstInLog = 60.0;  ///< s

 private:
  double end_;
  bool on_terminal_;
  double next_ = on_terminal_ ? kOnTerminal : kFirstInLog;
  double told_at_ = 0.0, t_then_ = 0.0;
};

/// Tells it, by the clock of the machine from now on.
class RunDisplay {
 public:
  /// `display` has to live as long. `end`: of the run, s.
  RunDisplay(program::ProgressDisplay& display, double end)
      : display_(display),
        end_(end),
        on_terminal_(static_cast<bool>(display.callback())),
        progress_(end, on_terminal_) {}

  /// After a step, or an output within one.
  void tell(std::int64_t number, double t) {
    const std::string text = progress_.after_step(number, t, since_begun_.seconds());
    if (text.empty()) return;
    if (on_terminal_)
      display_.show(text, t / end_);
    else
      fmt::print(stderr, "mfs-dae: {}\n", text);
  }

 private:
  program::ProgressDisplay& display_;
  const double end_;
  const bool on_terminal_;
  RunProgress progress_;
  Stopwatch since_begun_;
};

}  // namespace mfs::dae
