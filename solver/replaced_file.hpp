// A file that takes its place only when it is complete: text goes to a file beside it, which is renamed at
// the end. A disk that is full, or an exception on the way, leaves what was there before. Header only: libmfs
// and the programs share it, and libmfs shows nothing of it.
#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <mfs/error.hpp>

namespace mfs {

class ReplacedFile {
 public:
  /// Throws InvalidInput, which names `path`. What is no regular file (a device, a pipe) is written in place,
  /// and so is a file whose folder takes no other.
  explicit ReplacedFile(const std::string& path) : path_(path), target_(behind_links(path)) {
    struct stat old {};
    const bool exists = stat(target_.c_str(), &old) == 0;
    if (!exists || S_ISREG(old.st_mode)) {
      beside_ = name_beside();
      file_ = std::fopen(beside_.c_str(), "w");
      if (file_ && exists) fchmod(fileno(file_), old.st_mode & 07777);
      if (!file_) beside_.clear();
    }
    if (!file_ && exists) file_ = std::fopen(target_.c_str(), "w");
    if (!file_) fail("cannot be opened for writing");
  }
  ~ReplacedFile() {
    if (file_) std::fclose(file_);
    if (!beside_.empty()) unlink(beside_.c_str());
  }
  ReplacedFile(const ReplacedFile&) = delete;
  ReplacedFile& operator=(const ReplacedFile&) = delete;

  /// Throws InvalidInput.
  void write(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail("cannot be written");
  }
  /// Puts the file into its place. Throws InvalidInput. Nothing is written after this.
  void commit() {
    const bool flushed = std::fflush(file_) == 0, closed = std::fclose(file_) == 0;
    file_ = nullptr;
    if (!flushed || !closed) fail("cannot be written");
    if (beside_.empty()) return;
    if (std::rename(beside_.c_str(), target_.c_str()) != 0) fail("cannot be replaced");
    beside_.clear();
  }

 private:
  // A link stays one: what it leads to is replaced.
  static std::string behind_links(const std::string& path) {
    char* real = realpath(path.c_str(), nullptr);
    const std::string target = real ? real : path;
    std::free(real);
    return target;
  }
  std::string name_beside() const {
    static std::atomic<int> count{0};
    return target_ + ".part-" + std::to_string(getpid()) + "-" + std::to_string(count++);
  }
  [[noreturn]] void fail(const char* what) const {
    throw InvalidInput(path_, std::string(what) + ": " + std::strerror(errno));
  }

  std::string path_, target_, beside_;
  std::FILE* file_ = nullptr;
};

}  // namespace mfs
