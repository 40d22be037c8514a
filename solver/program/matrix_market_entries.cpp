#include "solver/program/matrix_market_entries.hpp"

#include <algorithm>
#include <deque>
#include <future>
#include <optional>
#include <thread>
#include <utility>

#include "solver/program/line_scanner.hpp"

namespace mfs::io {
namespace {

// Calls visit(line) for each line of `text` until it answers false; gives back the lines visited.
template <class Visit>
std::int64_t for_each_line(std::string_view text, Visit&& visit) {
  std::int64_t lines = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    ++lines;
    if (!visit(text.substr(0, end))) break;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

double read_value(LineScanner& scan, Field field, double) {
  if (field == Field::integer) return static_cast<double>(scan.integer("the value"));
  return scan.real("the value");
}

std::complex<double> read_value(LineScanner& scan, Field, std::complex<double>) {
  const double real = scan.real("the real part");
  return {real, scan.real("the imaginary part")};
}

std::int32_t read_index(LineScanner& scan, const char* what, std::int64_t size) {
  const std::int64_t index = scan.integer(what);
  if (index < 1 || index > size)
    throw TextError(std::string(what) + " " + std::to_string(index) + " is not in 1.." +
                    std::to_string(size));
  return static_cast<std::int32_t>(index - 1);
}

void check_triangle(Symmetry symmetry, std::int32_t row, std::int32_t column) {
  if (symmetry == Symmetry::general || row > column) return;
  const std::string place = "(" + std::to_string(row + 1) + ", " + std::to_string(column + 1) + ")";
  if (row < column)
    throw TextError("entry " + place +
                    " is above the diagonal: of a symmetric, skew-symmetric or hermitian " +
                    "matrix only the lower triangle is listed");
  if (symmetry == Symmetry::skew_symmetric)
    throw TextError("entry " + place + " is on the diagonal, which is zero in a skew-symmetric matrix");
}

void check_hermitian_diagonal(const std::complex<double>& value) {
  if (value.imag() != 0) throw TextError("the diagonal of a hermitian matrix is real");
}
void check_hermitian_diagonal(double) {}

template <class Scalar>
class BlockParser {
 public:
  BlockParser(const Header& header, std::string_view text) : header_(header), text_(text) {}

  /// Stops at the first line that is wrong: `fault` then says why, and the block's lines end with it.
  EntryBlock<Scalar> parse(std::optional<TextError>& fault) {
    reserve();
    block_.lines = for_each_line(text_, [&](std::string_view text) {
      try {
        LineScanner scan(text);
        if (!scan.at_end()) parse_entry(scan, text);
        return true;
      } catch (const TextError& e) {
        fault = e;
        return false;
      }
    });
    release_unused();
    return std::move(block_);
  }

 private:
  void reserve() {
    const bool coordinate = header_.format == Format::coordinate;
    const std::size_t shortest = coordinate ? 4 : 2;  // "1 1" or "1", and the line end
    const std::size_t lines = static_cast<std::size_t>(std::count(text_.begin(), text_.end(), '\n')) + 1;
    const std::size_t most = std::min(lines, text_.size() / shortest + 1);
    if (coordinate) {
      block_.rows.reserve(most);
      block_.columns.reserve(most);
    }
    if (header_.field != Field::pattern) block_.values.reserve(most);
  }

  // Blocks of blank lines must not hold memory that no entry needs.
  void release_unused() {
    const auto shrink = [&](auto& array) {
      if (array.size() < array.capacity() / 2) array.shrink_to_fit();
    };
    shrink(block_.rows);
    shrink(block_.columns);
    shrink(block_.values);
  }

  void parse_entry(LineScanner& scan, std::string_view text) {
    if (text[text.find_first_not_of(" \t\r")] == '%')
      throw TextError("a comment after the size line: comments belong between banner and size line");
    bool diagonal = false;
    if (header_.format == Format::coordinate) {
      const std::int32_t row = read_index(scan, "row", header_.rows);
      const std::int32_t column = read_index(scan, "column", header_.columns);
      check_triangle(header_.symmetry, row, column);
      diagonal = row == column;
      block_.rows.push_back(row);
      block_.columns.push_back(column);
    }
    if (header_.field != Field::pattern) block_.values.push_back(read_value(scan, header_.field, Scalar()));
    scan.finish();
    if (diagonal && header_.symmetry == Symmetry::hermitian) check_hermitian_diagonal(block_.values.back());
    ++block_.entries;
  }

  const Header& header_;
  std::string_view text_;
  EntryBlock<Scalar> block_;
};

// The line, within the block, of its entry number `wanted` (0-based).
std::int64_t line_of_entry(std::string_view text, std::int64_t wanted) {
  std::int64_t found = 0;
  return for_each_line(text,
                       [&](std::string_view line) { return LineScanner(line).at_end() || found++ < wanted; });
}

// Reads blocks ahead and parses up to `threads` of them at a time; results are taken in the order of the
// file, so that the first fault of the file is the one that is reported, whatever thread sees which first.
template <class Scalar>
class EntryReader {
 public:
  EntryReader(const Header& header, BlockReader& blocks, std::int64_t lines, int threads)
      : header_(header), blocks_(blocks), lines_(lines), threads_(static_cast<std::size_t>(threads)) {}

  std::vector<EntryBlock<Scalar>> read(std::string text) {
    do {
      start(std::move(text));
      if (running_.size() >= threads_) take_oldest();
    } while (blocks_next(text));
    while (!running_.empty()) take_oldest();
    if (entries_ < header_.listed)
      throw TextError("the file ends after " + std::to_string(entries_) + " of " +
                          std::to_string(header_.listed) + " entries",
                      lines_);
    return std::move(result_);
  }

 private:
  struct Parsed {
    std::string text;
    EntryBlock<Scalar> block;
    std::optional<TextError> fault;  // in the last of the block's lines
  };

  // A fault in the text that was read before comes first.
  bool blocks_next(std::string& text) {
    try {
      return blocks_.next(text);
    } catch (const TextError& e) {
      while (!running_.empty()) take_oldest();
      throw TextError(e.what(), lines_ + 1);
    }
  }

  void start(std::string text) {
    const auto policy = threads_ > 1 ? std::launch::async : std::launch::deferred;
    running_.push_back(std::async(policy, [this, text = std::move(text)]() mutable {
      Parsed parsed{std::move(text), {}, {}};
      parsed.block = BlockParser<Scalar>(header_, parsed.text).parse(parsed.fault);
      return parsed;
    }));
  }

  void take_oldest() {
    Parsed parsed = running_.front().get();
    running_.pop_front();
    if (parsed.block.entries > header_.listed - entries_)
      throw TextError("more than the promised " + std::to_string(header_.listed) + " entries",
                      lines_ + line_of_entry(parsed.text, header_.listed - entries_));
    if (parsed.fault) throw TextError(parsed.fault->what(), lines_ + parsed.block.lines);
    entries_ += parsed.block.entries;
    lines_ += parsed.block.lines;
    if (parsed.block.entries > 0) result_.push_back(std::move(parsed.block));
  }

  const Header& header_;
  BlockReader& blocks_;
  std::int64_t lines_;
  std::int64_t entries_ = 0;
  std::size_t threads_;
  std::vector<EntryBlock<Scalar>> result_;
  std::deque<std::future<Parsed>> running_;  // last: its destructor waits for the threads that use the rest
};

}  // namespace

template <class Scalar>
std::vector<EntryBlock<Scalar>> read_entries(const Header& header, BlockReader& blocks, std::string text,
                                             std::int64_t lines, int threads) {
  return EntryReader<Scalar>(header, blocks, lines, threads).read(std::move(text));
}

template std::vector<EntryBlock<double>> read_entries(const Header&, BlockReader&, std::string, std::int64_t,
                                                      int);
template std::vector<EntryBlock<std::complex<double>>> read_entries(const Header&, BlockReader&, std::string,
                                                                    std::int64_t, int);

}  // namespace mfs::io
