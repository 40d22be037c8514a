// Text in blocks of whole lines, from a plain file, a gzip file or memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace mfs::io {

/// What is wrong with the text and where: `line` counts from 1, 0 while the place is not known.
class TextError : public std::runtime_error {
 public:
  explicit TextError(const std::string& reason, std::int64_t line = 0)
      : std::runtime_error(reason), line_(line) {}
  std::int64_t line() const { return line_; }

 private:
  std::int64_t line_;
};

class TextSource {
 public:
  virtual ~TextSource() = default;
  /// Up to `bytes` bytes into `to`; 0 at the end. Throws TextError.
  virtual std::size_t read(char* to, std::size_t bytes) = 0;
};

/// A plain or gzip file, "-" is standard input. Throws TextError if it cannot be opened.
std::unique_ptr<TextSource> open_file(const std::string& path);
/// `text` must outlive the source.
std::unique_ptr<TextSource> open_memory(std::string_view text);

/// Reads ahead up to `bytes` bytes of a source and gives them back as its beginning.
class PeekedSource final : public TextSource {
 public:
  PeekedSource(TextSource& source, std::size_t bytes);
  std::string_view head() const { return head_; }
  std::size_t read(char* to, std::size_t bytes) override;

 private:
  TextSource& source_;
  std::string head_;
  std::size_t given_ = 0;
};

/// Cuts a source into blocks that end at a line end (the last one perhaps not).
class BlockReader {
 public:
  BlockReader(TextSource& source, std::size_t block_bytes) : source_(source), block_bytes_(block_bytes) {}
  /// False at the end. Throws TextError for a line that is longer than one MiB.
  bool next(std::string& block);

 private:
  TextSource& source_;
  std::size_t block_bytes_;
  std::string rest_;  // the beginning of a line that the last block did not finish
};

}  // namespace mfs::io
