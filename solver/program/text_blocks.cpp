#include "solver/program/text_blocks.hpp"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <optional>

namespace mfs::io {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 20;
constexpr std::size_t kInflateBuffer = 1u << 18;

// Bytes of a file, "-": of standard input.
class PlainSource final : public TextSource {
 public:
  explicit PlainSource(const std::string& path)
      : file_(path == "-" ? stdin : std::fopen(path.c_str(), "rb")) {
    if (!file_) throw TextError(std::string("cannot be opened: ") + std::strerror(errno));
  }
  ~PlainSource() override {
    if (file_ != stdin) std::fclose(file_);
  }
  PlainSource(const PlainSource&) = delete;
  PlainSource& operator=(const PlainSource&) = delete;

  std::size_t read(char* to, std::size_t bytes) override {
    const std::size_t got = std::fread(to, 1, bytes, file_);
    if (got < bytes && std::ferror(file_))
      throw TextError(std::string("cannot be read: ") + std::strerror(errno));
    return got;
  }

 private:
  std::FILE* file_;
};

// Gzip members one after another (RFC 1952), each with its checksum. zlib's own file reader takes whatever
// follows the last one for padding, and a file that was cut and joined then reads as a whole one.
class GzipSource final : public TextSource {
 public:
  explicit GzipSource(TextSource& compressed) : compressed_(compressed), input_(kInflateBuffer, '\0') {
    constexpr int kGzip = 16;
    if (inflateInit2(&stream_, kGzip + MAX_WBITS) != Z_OK) throw std::bad_alloc();
  }
  ~GzipSource() override { inflateEnd(&stream_); }
  GzipSource(const GzipSource&) = delete;
  GzipSource& operator=(const GzipSource&) = delete;

  std::size_t read(char* to, std::size_t bytes) override {
    const auto most = static_cast<unsigned>(std::min<std::size_t>(bytes, 1u << 30));
    stream_.next_out = reinterpret_cast<Bytef*>(to);
    stream_.avail_out = most;
    while (stream_.avail_out == most && !at_end()) inflate_more();
    return most - stream_.avail_out;
  }

 private:
  /// Also begins the next member.
  bool at_end() {
    if (within_) return false;
    if (stream_.avail_in == 0) fill();
    if (stream_.avail_in == 0) return true;
    if (begun_ && *stream_.next_in != 0x1f) throw TextError("bytes follow the end of the gzip stream");
    if (begun_) inflateReset(&stream_);
    return !(begun_ = within_ = true);
  }
  void inflate_more() {
    if (stream_.avail_in == 0) fill();
    if (stream_.avail_in == 0) throw TextError("the gzip stream is cut off");
    const int code = inflate(&stream_, Z_NO_FLUSH);
    if (code == Z_STREAM_END) {
      within_ = false;
    } else if (code == Z_MEM_ERROR) {
      throw std::bad_alloc();
    } else if (code != Z_OK && code != Z_BUF_ERROR) {
      throw TextError(std::string("the gzip stream is damaged: ") +
                      (stream_.msg ? stream_.msg : "not as it begins"));
    }
  }
  void fill() {
    stream_.avail_in = static_cast<unsigned>(compressed_.read(input_.data(), input_.size()));
    stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
  }

  TextSource& compressed_;
  std::string input_;
  z_stream stream_{};
  bool within_ = false, begun_ = false;  // a member
};

class FileSource final : public TextSource {
 public:
  explicit FileSource(const std::string& path) : file_(path), peeked_(file_, 2) {
    if (peeked_.head() == "\x1f\x8b") gzip_.emplace(peeked_);
  }
  std::size_t read(char* to, std::size_t bytes) override {
    return gzip_ ? gzip_->read(to, bytes) : peeked_.read(to, bytes);
  }

 private:
  PlainSource file_;
  PeekedSource peeked_;
  std::optional<GzipSource> gzip_;
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

PeekedSource::PeekedSource(TextSource& source, std::size_t bytes) : source_(source), head_(bytes, '\0') {
  std::size_t filled = 0, got = 0;
  while (filled < bytes && (got = source.read(head_.data() + filled, bytes - filled)) > 0) filled += got;
  head_.resize(filled);
}

std::size_t PeekedSource::read(char* to, std::size_t bytes) {
  if (given_ == head_.size()) return source_.read(to, bytes);
  const std::size_t got = head_.copy(to, bytes, given_);
  given_ += got;
  return got;
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
