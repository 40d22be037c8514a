// A file that is written from beginning to end, with every failure reported.
#pragma once

#include <cstdio>
#include <memory>
#include <string>

namespace mfs::io {

/// Opened at once, so that a wrong path is known before any work; "-" is standard output.
class OutputFile {
 public:
  /// Throws InvalidInput.
  explicit OutputFile(const std::string& path);
  /// Writes and flushes. Throws InvalidInput.
  void write(const std::string& text);

 private:
  struct Closer {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

/// To standard output. Throws InvalidInput.
void print(const std::string& text);

}  // namespace mfs::io
