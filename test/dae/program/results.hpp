// Tables and matrices that the program left in a folder.
#pragma once

#include <Eigen/Core>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "solver/program/matrix_market.hpp"
#include "test/program/temporary_folder.hpp"

using Table = std::map<std::string, std::vector<double>>;

/// Columns by name.
inline Table read_table(const std::string& path) {
  std::istringstream lines(text_of(path));
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) names.push_back(cell);
  Table table;
  for (const std::string& name : names) table[name];
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i)
      table[names.at(i)].push_back(std::stod(cell));
  }
  return table;
}

inline Eigen::MatrixXd read_dense(const std::string& path) {
  const auto read = mfs::io::read_matrix_market(path);
  const auto& csr = std::get<mfs::io::CsrMatrix<double>>(read.content);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(csr.rows, csr.columns);
  for (int i = 0; i < csr.rows; ++i)
    for (auto k = csr.offsets[i]; k < csr.offsets[i + 1]; ++k)
      matrix(i, csr.column_indices[k]) = csr.values[k];
  return matrix;
}
