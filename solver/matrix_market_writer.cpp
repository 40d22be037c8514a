#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <string>

#include <mfs/error.hpp>
#include <mfs/matrix_market.hpp>

#include "solver/replaced_file.hpp"

namespace mfs {
namespace {

constexpr std::size_t kFlushBytes = std::size_t{1} << 20;
constexpr int kDigitsAfterPoint = 16;  // 17 significant digits: the shortest number that always reads back

// Collects numbers and passes them on in blocks to what `Sink` is.
template <class Sink>
class Output {
 public:
  explicit Output(Sink& sink) : sink_(sink) {}
  void text(const std::string& text) { buffer_ += text; }
  void number(std::int64_t value) {
    char digits[24];
    buffer_.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  }
  void number(double value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value, std::chars_format::scientific,
                                   kDigitsAfterPoint);
    buffer_.append(digits, end.ptr);
  }
  void number(const std::complex<double>& value) {
    number(value.real());
    blank();
    number(value.imag());
  }
  void blank() { buffer_ += ' '; }
  void end_line() {
    buffer_ += '\n';
    if (buffer_.size() >= kFlushBytes) flush();
  }
  void flush() {
    sink_.write(buffer_);
    buffer_.clear();
  }

 private:
  Sink& sink_;
  std::string buffer_;
};

// A stream of the caller's, which stays open.
class StreamSink {
 public:
  explicit StreamSink(std::FILE* stream) : stream_(stream) {
    if (!stream) throw InvalidInput("stream", "null pointer");
  }
  void write(const std::string& text) {
    check(std::fwrite(text.data(), 1, text.size(), stream_) == text.size());
  }
  void commit() { check(std::fflush(stream_) == 0); }

 private:
  static void check(bool good) {
    if (!good) throw InvalidInput("stream", std::string("cannot be written: ") + std::strerror(errno));
  }
  std::FILE* stream_;
};

template <class Scalar>
constexpr bool kComplex = !std::is_floating_point_v<Scalar>;

template <class Scalar>
auto in_double(const Scalar& value) {
  return static_cast<std::conditional_t<kComplex<Scalar>, std::complex<double>, double>>(value);
}

std::string banner(const char* format, const char* field, const std::string& comment) {
  std::string text = std::string("%%MatrixMarket matrix ") + format + " " + field + " general\n% ";
  for (const char c : comment) {
    if (c == '\r') continue;
    text += c;
    if (c == '\n') text += "% ";  // each line of it is a comment
  }
  return text + "\n";
}

// What the writer follows must lead nowhere else.
template <class Scalar>
void check_shape(const CsrView<Scalar>& a) {
  if (a.rows < 0 || a.columns < 0) throw InvalidInput("rows", "must not be negative");
  if (!a.row_offsets.data()) throw InvalidInput("row_offsets", "null pointer");
  if (a.row_offsets[0] != 0) throw InvalidInput("row_offsets", "must begin with 0", 0);
  for (std::int64_t i = 0; i < a.rows; ++i)
    if (a.row_offsets[i + 1] < a.row_offsets[i]) throw InvalidInput("row_offsets", "must not decrease", i);
  if (a.row_offsets[a.rows] > 0 && !a.column_indices.data())
    throw InvalidInput("column_indices", "null pointer");
  for (std::int64_t i = 0; i < a.rows; ++i)
    for (std::int64_t k = a.row_offsets[i]; k < a.row_offsets[i + 1]; ++k)
      if (a.column_indices[k] < 0 || a.column_indices[k] >= a.columns)
        throw InvalidInput("column_indices", "out of range", i, a.column_indices[k]);
}

template <class Scalar, class Sink>
void write_sparse(Sink& sink, const CsrView<Scalar>& a, const std::string& comment) {
  Output out(sink);
  out.text(banner("coordinate", !a.values ? "pattern" : kComplex<Scalar> ? "complex" : "real", comment));
  for (const std::int64_t size : std::array<std::int64_t, 3>{a.rows, a.columns, a.row_offsets[a.rows]}) {
    out.number(size);
    out.blank();
  }
  out.end_line();
  for (std::int64_t i = 0; i < a.rows; ++i)
    for (std::int64_t k = a.row_offsets[i]; k < a.row_offsets[i + 1]; ++k) {
      out.number(i + 1);
      out.blank();
      out.number(a.column_indices[k] + 1);
      if (a.values) {
        out.blank();
        out.number(in_double(a.values[k]));
      }
      out.end_line();
    }
  out.flush();
  sink.commit();
}

template <class Scalar, class Sink>
void write_dense(Sink& sink, const Scalar* values, std::int64_t rows, std::int64_t columns, std::int64_t ld,
                 const std::string& comment) {
  Output out(sink);
  out.text(banner("array", kComplex<Scalar> ? "complex" : "real", comment));
  out.text(std::to_string(rows) + " " + std::to_string(columns) + "\n");
  for (std::int64_t j = 0; j < columns; ++j)
    for (std::int64_t i = 0; i < rows; ++i) {
      out.number(in_double(values[i + j * ld]));
      out.end_line();
    }
  out.flush();
  sink.commit();
}

}  // namespace

template <class Scalar>
void write_matrix_market(const std::string& path, const CsrView<Scalar>& a, const std::string& comment) {
  check_shape(a);
  ReplacedFile file(path);
  write_sparse(file, a, comment);
}
template <class Scalar>
void write_matrix_market(std::FILE* stream, const CsrView<Scalar>& a, const std::string& comment) {
  check_shape(a);
  StreamSink sink(stream);
  write_sparse(sink, a, comment);
}

template <class Scalar>
void write_matrix_market(const std::string& path, const Scalar* values, std::int64_t rows,
                         std::int64_t columns, std::int64_t ld, const std::string& comment) {
  ReplacedFile file(path);
  write_dense(file, values, rows, columns, ld, comment);
}
template <class Scalar>
void write_matrix_market(std::FILE* stream, const Scalar* values, std::int64_t rows, std::int64_t columns,
                         std::int64_t ld, const std::string& comment) {
  StreamSink sink(stream);
  write_dense(sink, values, rows, columns, ld, comment);
}

#define MFS_INSTANTIATE(S)                                                                                 \
  template MFS_API void write_matrix_market<S>(const std::string&, const CsrView<S>&, const std::string&); \
  template MFS_API void write_matrix_market<S>(std::FILE*, const CsrView<S>&, const std::string&);         \
  template MFS_API void write_matrix_market<S>(const std::string&, const S*, std::int64_t, std::int64_t,   \
                                               std::int64_t, const std::string&);                          \
  template MFS_API void write_matrix_market<S>(std::FILE*, const S*, std::int64_t, std::int64_t,           \
                                               std::int64_t, const std::string&);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
