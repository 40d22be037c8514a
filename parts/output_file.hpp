// A file that is written from beginning to end, with every failure reported.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace mfs::io {

/// Opened at once, so that a wrong path is known before any work; "-" is standard output.
class OutputFile {
 public:
  /// Throws InvalidInput.
  explicit OutputFile(const std::string& path);
  /// Writes and flushes. Throws InvalidInput.
  void write(std::string_view text);
  /// Writes over what begins at `position`, of a file on a disk; then goes on at the end. Throws
  /// InvalidInput.
  void overwrite(std::size_t position, std::string_view text);

 private:
  struct Closer {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  [[noreturn]] void fail() const;

  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

/// To standard output. Throws InvalidInput.
void print(const std::string& text);

/// Whether `path` is standard output ("-") or something else that is written as a stream: a device, a pipe.
bool is_stream(const std::string& path);
/// Before hours of work: throws InvalidInput where `path` could not be written.
void check_writable(const std::string& path);
/// The file holds `text`, or what it held before (ReplacedFile); "-" is standard output. Throws InvalidInput.
void write_file(const std::string& path, const std::string& text);

}  // namespace mfs::io
