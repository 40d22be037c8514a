// One line on a terminal that says where the solver is; nothing anywhere else.
#pragma once

#include <string>

#include <mfs/options.hpp>

namespace mfs::program {

class ProgressDisplay {
 public:
  /// Shows something only if standard error is a terminal.
  ProgressDisplay();
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void show(const std::string& phase, double fraction);
  /// Empties the line: call it before anything else is printed.
  void clear();
  /// For Options::progress; empty where nothing would be shown. The display must outlive it.
  std::function<void(const Progress&)> callback();

 private:
  bool terminal_;
  std::string shown_;
};

}  // namespace mfs::program
