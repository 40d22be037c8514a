#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include <mfs/error.hpp>

#include "solver/program/matrix_market.hpp"

namespace mfs::io {
namespace {

constexpr std::size_t kFlushBytes = std::size_t{1} << 20;
constexpr int kDigitsAfterPoint = 16;  // 17 significant digits: the shortest number that always reads back

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// Writes through one buffer and remembers nothing else: any failure throws.
class Output {
 public:
  explicit Output(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "w")) {
    if (!file_) fail("cannot be opened for writing");
  }
  void text(const std::string& text) { buffer_ += text; }
  void number(double value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value, std::chars_format::scientific,
                                   kDigitsAfterPoint);
    buffer_.append(digits, end.ptr);
    buffer_ += '\n';
    if (buffer_.size() >= kFlushBytes) flush();
  }
  void close() {
    flush();
    if (std::fclose(file_.release()) != 0) fail("cannot be written");
  }

 private:
  void flush() {
    if (std::fwrite(buffer_.data(), 1, buffer_.size(), file_.get()) != buffer_.size())
      fail("cannot be written");
    buffer_.clear();
  }
  [[noreturn]] void fail(const char* what) {
    throw InvalidInput(path_, std::string(what) + ": " + std::strerror(errno));
  }

  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::string buffer_;
};

}  // namespace

void write_matrix_market(const std::string& path, const DenseMatrix<double>& matrix,
                         const std::string& comment) {
  Output out(path);
  out.text("%%MatrixMarket matrix array real general\n% " + comment + "\n");
  out.text(std::to_string(matrix.rows) + " " + std::to_string(matrix.columns) + "\n");
  for (const double value : matrix.values) out.number(value);
  out.close();
}

}  // namespace mfs::io
