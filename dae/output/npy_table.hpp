// A table in NumPy's file format: a record per row, made of named fields of 64-bit floats, each a number or
// an array of a fixed shape. So one file holds all results of a run, and without copying:
//
//   r = numpy.load("results.npy", mmap_mode="r", max_header_size=10**9)
//   r["t"], r["bodies.crank.position"][:, 0]
//
// The header is a text of a fixed length, so that the number of rows in it can be brought up to date with
// every row: the file can be read while it grows, and an interrupted run leaves what it had.
//
//   93 NUMPY 02 00 | length, 4 bytes | {'descr': [...], 'fortran_order': False, 'shape': (7,), }   \n | rows
//
// Source: NumPy Enhancement Proposal 1, "A simple file format for NumPy arrays", version 2.0.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "parts/output_file.hpp"

namespace mfs::dae {

struct NpyField {
  std::string name;
  std::vector<int> shape;  ///< none: a number
};

class NpyTable {
 public:
  /// Throws InvalidInput where the file cannot be written, or a name is there twice or has a quote, a
  /// backslash or a control character in it.
  NpyTable(const std::string& path, const std::vector<NpyField>& fields);
  /// The numbers of all fields, one field after another, arrays with the last index the fastest. Throws
  /// InvalidInput.
  void add_row(const std::vector<double>& values);

 private:
  std::size_t columns_ = 0;
  std::int64_t rows_ = 0;
  std::size_t rows_at_ = 0;  // where their number is in the file
  io::OutputFile file_;
};

}  // namespace mfs::dae
