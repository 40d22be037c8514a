#include "solver/program/text_blocks.hpp"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace mfs::io {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 20;
constexpr unsigned kInflateBuffer = 1u << 18;

// zlib's file reader: inflates gzip, passes anything else through.
class FileSource final : public TextSource {
 public:
  explicit FileSource(const std::string& path) {
    errno = 0;
    file_ = gzopen(path.c_str(), "rb");
    if (!file_) throw TextError(std::string("cannot be opened: ") + std::strerror(errno ? errno : ENOMEM));
    gzbuffer(file_, kInflateBuffer);
  }
  ~FileSource() override { gzclose_r(file_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::size_t read(char* to, std::size_t bytes) override {
    const int got = gzread(file_, to, static_cast<unsigned>(std::min<std::size_t>(bytes, 1u << 30)));
    int code = Z_OK;
    const char* why = gzerror(file_, &code);
    if (code == Z_ERRNO) throw TextError(std::string("cannot be read: ") + std::strerror(errno));
    if (code == Z_BUF_ERROR) throw TextError("the gzip stream is cut off");
    if (got < 0 || code != Z_OK) throw TextError(std::string("the gzip stream is damaged: ") + why);
    return static_cast<std::size_t>(got);
  }

 private:
  gzFile file_;
};

class MemorySource final : public TextSource {
 public:
  explicit MemorySource(std::string_view text) : rest_(text) {}
  std::size_t read(char* to, std::size_t bytes) override {
    const std::size_t got = rest_.copy(to, bytes);
    rest_.remove_prefix(got);
    return got;
  }

 private:
  std::string_view rest_;
};

}  // namespace

std::unique_ptr<TextSource> open_file(const std::string& path) {
  return std::make_unique<FileSource>(path);
}
std::unique_ptr<TextSource> open_memory(std::string_view text) {
  return std::make_unique<MemorySource>(text);
}

bool BlockReader::next(std::string& block) {
  block = std::move(rest_);
  rest_.clear();
  for (;;) {
    const std::size_t old = block.size();
    block.resize(old + block_bytes_);
    const std::size_t got = source_.read(block.data() + old, block_bytes_);
    block.resize(old + got);
    if (got == 0) return !block.empty();
    const std::size_t end = std::string_view(block).substr(old).rfind('\n');
    if (end != std::string_view::npos) {
      rest_.assign(block, old + end + 1);
      block.resize(old + end + 1);
      return true;
    }
    if (block.size() > kLongestLine) throw TextError("a line is longer than 1048576 characters");
  }
}

}  // namespace mfs::io
